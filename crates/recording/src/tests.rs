use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use parquet::file::reader::{FileReader, SerializedFileReader};
use tempfile::TempDir;

use super::*;

fn info() -> RecordingInfo {
    RecordingInfo {
        unit_serial: "G-0042".into(),
        procedure: "full-temperature".into(),
        set_up: "[bench]\ngroup_length = 500\n".into(),
        firmware: "0.1.0".into(),
        seed: Some(1),
        started: Some("2026-03-01T08:00:00Z".parse().unwrap()),
        labels: [("station".to_owned(), "S-3".to_owned())].into(),
    }
}

fn group(number: u32) -> [GroupRow; 2] {
    let offset = u16::try_from(number).unwrap();
    Axis::BOTH.map(|axis| {
        let mut sums = GroupSums::default();
        (0..500_u16).for_each(|i| sums.push(9000 + (offset + i) % 700, 8200 + (i * 7) % 90));
        GroupRow {
            group: number,
            t_s: 1.5 * f64::from(number),
            phase: if number < 5 { Phase::Soak } else { Phase::Heating },
            axis,
            sums,
            corrected_counts: 8200.25,
            tap: 511,
            mode: Mode::Hybrid,
            chamber_set_c: -40.0,
            chamber_c: f64::from(number) - 39.5,
            status_bits: 3,
        }
    })
}

/// A recording of some groups that was not finished, and its bytes.
fn unfinished(groups: u32) -> (TempDir, PathBuf, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.parquet");
    let mut writer = RecordingWriter::create(&path, &info()).unwrap();
    (0..groups).for_each(|number| writer.write_group(&group(number)).unwrap());
    let stream = path.with_extension("arrows");
    let bytes = fs::read(&stream).unwrap();
    (folder, stream, bytes)
}

fn rows(groups: u32) -> Vec<GroupRow> {
    (0..groups).flat_map(group).collect()
}

#[test]
fn a_finished_recording_is_parquet_and_reads_back_exactly() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.parquet");
    let mut writer = RecordingWriter::create(&path, &info()).unwrap();
    (0..40).for_each(|number| writer.write_group(&group(number)).unwrap());
    assert_eq!(writer.finish().unwrap(), path);
    assert!(fs::read(&path).unwrap().starts_with(b"PAR1"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
    assert_eq!(Recording::read(&(&path).into()).unwrap(), Recording { info: info(), rows: rows(40), cut: false });
}

/// Read as DuckDB does: the file's own key-value pairs, without Arrow's packed schema.
#[test]
fn a_finished_recordings_key_values_tell_its_columns_bits_and_start() {
    let folder = tempfile::tempdir().unwrap();
    let path = RecordingWriter::create(&folder.path().join("run.parquet"), &info()).unwrap().finish().unwrap();
    let reader = SerializedFileReader::new(fs::File::open(path).unwrap()).unwrap();
    let file = reader.metadata().file_metadata();
    let pairs = file.key_value_metadata().unwrap();
    let text = |key: &str| pairs.iter().find(|pair| pair.key == key).and_then(|pair| pair.value.clone()).unwrap();
    let json = |key| serde_json::from_str::<serde_json::Value>(&text(key)).unwrap();
    assert_eq!((&*text("zerorate.schema_version"), &*text("zerorate.started")), ("2", "2026-03-01T08:00:00Z"));
    assert_eq!((&*text("zerorate.unit_serial"), &*text("zerorate.label.station")), ("G-0042", "S-3"));
    let told = json("zerorate.columns");
    let names: Vec<&str> = file.schema_descr().columns().iter().map(|column| column.name()).collect();
    assert_eq!(told.as_object().unwrap().keys().map(String::as_str).collect::<Vec<_>>(), names);
    assert_eq!((&told["t_s"]["unit"], &told["zro_sq_sum"]["unit"]), (&"s".into(), &"count^2".into()));
    assert!(told.as_object().unwrap().values().all(|column| column["description"].as_str().unwrap().ends_with('.')));
    assert!(["group", "mode", "flags"].iter().all(|word| !names.contains(word)), "SQL and pandas keep them");
    let bits = json("zerorate.status_bits");
    assert_eq!((bits.as_object().unwrap().len(), &bits["8"]), (8, &"The tap changed when the group closed.".into()));
}

#[test]
fn the_readme_says_every_status_bit() {
    for (bit, meaning) in status::MEANINGS {
        let row = format!("| {bit} | {} |", meaning.trim_end_matches('.'));
        assert!(include_str!("../README.md").contains(&row), "{row}");
    }
}

#[test]
fn a_simulated_recording_has_no_start_and_the_same_bytes_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |name| {
        let info = RecordingInfo { started: None, ..info() };
        let mut writer = RecordingWriter::create(&folder.path().join(name), &info).unwrap();
        writer.write_group(&group(0)).unwrap();
        fs::read(writer.finish().unwrap()).unwrap()
    };
    assert_eq!(bytes("first.parquet"), bytes("second.parquet"));
    assert_eq!(Recording::read(&(&folder.path().join("first.parquet")).into()).unwrap().info.started, None);
}

/// `tests/recordings/version-1.parquet` is `soaks.parquet` as a program that wrote schema version 1 left it, of two soaks;
/// the numbers are pyarrow's.
#[test]
fn a_recording_of_schema_version_1_is_read() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recordings/version-1.parquet");
    let recording = Recording::read(&(&path).into()).unwrap();
    assert_eq!((&*recording.info.unit_serial, recording.info.started), ("ZR-0001", None));
    assert_eq!((recording.rows.len(), recording.groups()), (160, 80));
    let told: BTreeSet<u16> = recording.rows.iter().map(|row| row.status_bits).collect();
    assert_eq!(told, [0, status::BELOW, status::MOVED, status::BELOW | status::MOVED].into());
    let last = recording.rows.last().unwrap();
    assert_eq!((last.group, last.axis, last.mode, last.status_bits), (79, Axis::Y, Mode::Hybrid, 0));
    assert_eq!((last.sums.zro, last.sums.temperature), (4_095_955, 5_957_686));
}

#[test]
fn a_recording_of_no_group_reads_back_where_no_test_could_be_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = RecordingWriter::create(&folder.path().join("run.parquet"), &info()).unwrap().finish().unwrap();
    assert_eq!(Recording::read(&(&path).into()).unwrap(), Recording { info: info(), rows: Vec::new(), cut: false });
}

#[test]
fn an_unfinished_recording_has_every_group_that_was_written() {
    let (_folder, stream, _) = unfinished(7);
    let recording = Recording::read(&(&stream).into()).unwrap();
    assert_eq!((recording.groups(), recording.cut), (7, true));
    assert_eq!(recording.rows, rows(7));
}

#[test]
fn a_recording_cut_at_any_byte_keeps_every_whole_group() {
    // Where each group ends: the length of the stream when it was written.
    let ends: Vec<usize> = (0..=4).map(|groups| unfinished(groups).2.len()).collect();
    let (folder, _, bytes) = unfinished(4);
    let path = folder.path().join("cut.arrows");
    for length in 0..bytes.len() {
        fs::write(&path, &bytes[..length]).unwrap();
        let whole = ends.iter().filter(|end| **end <= length).count();
        match Recording::read(&(&path).into()) {
            Ok(recording) => {
                assert!(recording.cut);
                assert_eq!(recording.rows, rows(u32::try_from(whole).unwrap() - 1), "cut at {length}");
            }
            Err(error) => {
                assert_eq!(whole, 0, "cut at {length}: {error}");
                assert!(matches!(error.fault, RecordingFault::NothingWhole));
            }
        }
    }
}

#[test]
fn a_damaged_byte_never_panics_and_never_changes_a_sum_unseen() {
    let (folder, _, bytes) = unfinished(3);
    let path = folder.path().join("damaged.arrows");
    for place in (0..bytes.len()).step_by(7) {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x55;
        fs::write(&path, &damaged).unwrap();
        if let Ok(recording) = Recording::read(&(&path).into()) {
            for (row, original) in recording.rows.iter().zip(rows(3)) {
                assert_eq!((row.sums.zro, row.sums.temperature), (original.sums.zro, original.sums.temperature));
            }
        }
    }
}

#[test]
fn a_cut_parquet_file_is_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.parquet");
    let mut writer = RecordingWriter::create(&path, &info()).unwrap();
    writer.write_group(&group(0)).unwrap();
    writer.finish().unwrap();
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 20]).unwrap();
    assert!(matches!(Recording::read(&(&path).into()).unwrap_err().fault, RecordingFault::Damaged { .. }));
}

#[test]
fn another_file_is_no_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    fs::write(&path, "t,x\n1,2\n").unwrap();
    assert!(matches!(Recording::read(&(&path).into()).unwrap_err().fault, RecordingFault::NotARecording));
    let missing = Recording::read(&"/nowhere/run.parquet".into()).unwrap_err();
    assert!(matches!(missing.fault, RecordingFault::Read(_)));
    assert!(missing.to_string().starts_with("/nowhere/run.parquet: cannot be read"), "{missing}");
}

#[test]
fn starting_again_keeps_what_was_finished_and_what_was_cut() {
    let (folder, stream, bytes) = unfinished(3);
    let path = folder.path().join("run.parquet");
    fs::write(&path, "finished earlier").unwrap();
    let _writer = RecordingWriter::create(&path, &info()).unwrap();
    assert_eq!(fs::read(stream.with_extension("cut.arrows")).unwrap(), bytes);
    assert_eq!(fs::read(&path).unwrap(), b"finished earlier");
}

#[cfg(unix)]
#[test]
fn what_another_run_writes_is_left_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.parquet");
    let mut first = RecordingWriter::create(&path, &info()).unwrap();
    first.write_group(&group(0)).unwrap();
    let error = RecordingWriter::create(&path, &info()).err().unwrap().to_string();
    assert!(error.contains("run.arrows: another run writes its recording there"), "{error}");
    first.finish().unwrap();
    assert_eq!(Recording::read(&(&path).into()).unwrap().rows, rows(1));
    RecordingWriter::create(&path, &info()).unwrap();
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let error = RecordingWriter::create(Path::new("/nowhere/run.parquet"), &info()).err().unwrap().to_string();
    assert!(error.starts_with("/nowhere/run.arrows: the recording cannot be started"), "{error}");
}

/// `/dev/full` fails every write as a full disk does.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_says_what_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.parquet");
    let mut writer = RecordingWriter::create(&path, &info()).unwrap();
    writer.write_group(&group(0)).unwrap();
    std::os::unix::fs::symlink("/dev/full", folder.path().join("run.parquet.partial")).unwrap();
    let error = writer.finish().unwrap_err().to_string();
    assert!(
        error.contains("all of it is kept in") && error.contains("(groups: 1)") && error.contains("run.arrows"),
        "{error}"
    );
    assert_eq!(Recording::read(&(&folder.path().join("run.arrows")).into()).unwrap().rows, rows(1));
}
