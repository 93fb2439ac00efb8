//! A simulated lot from end to end, embedded: agreement with `zerorate fit`, verdicts, damage, duplicates, resuming, export,
//! report.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::RecordBatch;
use arrow_schema::{Field, FieldRef, Schema};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::reader::{FileReader, SerializedFileReader};
use zerorate_cal::calibration::Calibration;
use zerorate_cal::fit::fit;
use zerorate_cal::log_fit::{FitOptions, LogFit};
use zerorate_cal::quality::ReasonKind;
use zerorate_cal::ramp_fit::RampMeans;
use zerorate_cal::recording::{Recording, name_in_version_1};
use zerorate_core::record::DeviceRecord;
use zerorate_core::units::Axis;
use zerorate_fit::model::Model;
use zerorate_lot::engine::Engine;
use zerorate_lot::export::{ExportError, export};
use zerorate_lot::models::{self, ModelRow};
use zerorate_lot::run::{FitRun, RunError, Summary};
use zerorate_lot::simulate::{Defect, Simulation, Truth};
use zerorate_lot::{raw, report};

mod places;
mod told;

/// The forms of JSON are held by the same few lines in all tests.
#[path = "../../../cli/tests/command/schema.rs"]
#[allow(dead_code)] // The other tests' half of it.
mod schema;

fn simulate(folder: &Path, units: u32, seed: u64, bad: f64) -> Truth {
    Simulation { units, seed, out: folder.to_owned(), bad, cooling: false }.run(&|| ()).unwrap()
}

fn job(dataset: &Path, out: &Path, model: &str) -> FitRun {
    FitRun {
        dataset: dataset.display().to_string(),
        out: out.to_owned(),
        model: model.parse().unwrap(),
        allow_narrow: false,
        engine: Engine::embedded(),
        fresh: false,
    }
}

fn wait<T>(task: impl Future<Output = T>) -> T {
    tokio::runtime::Builder::new_multi_thread().enable_all().thread_stack_size(16 << 20).build().unwrap().block_on(task)
}

fn run(job: &FitRun) -> Result<(Summary, Vec<ModelRow>), RunError> {
    let summary = wait(job.run(&|_, _| ()))?;
    Ok((summary, models::read(&job.out).unwrap()))
}

fn fit_alone(path: &Path, options: &FitOptions) -> LogFit {
    fit(&[path.into()], options).unwrap()
}

/// The group means of an axis as a table for `zerorate fit --plain`.
fn means_as_csv(recording: &Path, axis: Axis, csv: &Path) {
    let means = RampMeans::of(&Recording::read(&recording.into()).unwrap(), axis);
    let rows = means.times_s.iter().zip(&means.temperatures).zip(&means.readings);
    let rows: String = rows.map(|((t, temperature), reading)| format!("{t},{temperature},{reading}\n")).collect();
    fs::write(csv, format!("time_s,temperature_counts,zro_counts\n{rows}")).unwrap();
}

#[test]
fn polynomials_agree_with_the_plain_fit_of_the_group_means() {
    let folder = tempfile::tempdir().unwrap();
    let lot = folder.path().join("lot");
    simulate(&lot, 12, 3, 0.0);
    let csv = folder.path().join("means.csv");
    for model in ["poly:2", "poly:5"] {
        let (summary, rows) = run(&job(&lot, &folder.path().join(format!("{model}.parquet")), model)).unwrap();
        assert_eq!((summary.units, summary.fits, summary.rejected.len()), (12, 24, 0), "{summary:?}");
        for row in &rows {
            let axis = Axis::BOTH.into_iter().find(|axis| axis.name() == row.axis).unwrap();
            means_as_csv(&lot.join(&row.file), axis, &csv);
            let options = FitOptions { model: model.parse().unwrap(), plain: true, ..FitOptions::default() };
            let alone = fit_alone(&csv, &options);
            let (theirs, own) = (&alone.axes[0].calibration.fit, row.axis_calibration().unwrap().fit);
            let (min, max) = (own.model.drift.valid.min(), own.model.drift.valid.max());
            let range = own.model.drift.peak_to_peak();
            for step in 0..=200 {
                let t = min + (max - min) * f64::from(step) / 200.0;
                let off = (own.model.drift.evaluate(t).0 - theirs.model.drift.evaluate(t).0).abs();
                assert!(off < 1e-9 * range, "{model} {} {}: {off} of {range}", row.file, row.axis);
            }
            let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-6;
            let (theirs, own) = (&theirs.statistics, &own.statistics);
            let held_out = theirs.held_out.unwrap();
            assert!(near(row.in_sample_rms, theirs.in_sample.rms) && near(row.in_sample_pp, theirs.in_sample.pp));
            assert!(near(row.held_out_rms, held_out.rms) && near(row.held_out_pp, held_out.pp));
            for (a, b) in own.covariance.iter().flatten().zip(theirs.covariance.iter().flatten()) {
                assert!((a - b).abs() <= 1e-6 * theirs.covariance[0][0], "{a} {b}");
            }
        }
    }
}

#[test]
fn every_planted_bad_unit_is_rejected_with_its_reason_and_no_good_one_is() {
    let folder = tempfile::tempdir().unwrap();
    let lot = folder.path().join("lot");
    let truth = simulate(&lot, 400, 11, 0.05);
    let expected = |defect| match defect {
        Defect::StuckTemperature => ReasonKind::StuckTemperature,
        Defect::StuckReading => ReasonKind::StuckReading,
        Defect::CutRun => ReasonKind::CutRun,
        Defect::WrongSerial => ReasonKind::WrongSerial,
        Defect::Outliers => ReasonKind::Outliers,
    };
    for model in ["poly:2", "auto"] {
        let (summary, _) = run(&job(&lot, &folder.path().join(format!("{model}.parquet")), model)).unwrap();
        let rejected: BTreeMap<&str, Vec<ReasonKind>> = summary
            .rejected
            .iter()
            .map(|unit| (unit.file.as_str(), unit.reasons.iter().map(|reason| reason.kind).collect()))
            .collect();
        for unit in &truth.units {
            match (unit.defect, rejected.get(unit.file.as_str())) {
                (None, None) => {}
                (Some(defect), Some(kinds)) => {
                    assert!(kinds.contains(&expected(defect)), "{model} {}: {defect:?}, {kinds:?}", unit.file);
                }
                (defect, kinds) => panic!("{model} {}: {defect:?}, but {kinds:?}", unit.file),
            }
        }
        assert!(Defect::ALL.iter().all(|kind| truth.units.iter().any(|unit| unit.defect == Some(*kind))));
    }
}

#[test]
fn files_that_are_damaged_empty_or_foreign_are_named_and_the_rest_is_fitted() {
    let folder = tempfile::tempdir().unwrap();
    let lot = folder.path().join("lot");
    // More than a batch.
    let truth = simulate(&lot, 150, 11, 0.05);
    let planted = truth.units.iter().filter(|unit| unit.defect.is_some()).count();
    let spoilt = ["ZR-000003.parquet", "ZR-000007.parquet", "ZR-000009.parquet"];
    assert!(truth.units.iter().all(|unit| unit.defect.is_none() || !spoilt.contains(&unit.file.as_str())));
    fs::write(lot.join("empty.parquet"), "").unwrap();
    fs::write(lot.join("notes.txt"), "the chamber's door was open on Monday").unwrap();
    fs::write(lot.join("foreign.parquet"), b"PAR1 and nothing of the kind, PAR1").unwrap();
    let whole = fs::read(lot.join("ZR-000003.parquet")).unwrap();
    fs::write(lot.join("ZR-000003.parquet"), &whole[..whole.len() / 2]).unwrap();
    // Pages are overwritten, the footer is whole: only who reads the rows can tell.
    let mut pages = fs::read(lot.join("ZR-000007.parquet")).unwrap();
    pages[4..40_000].fill(0xA5);
    fs::write(lot.join("ZR-000007.parquet"), pages).unwrap();
    fs::copy(lot.join("ZR-000009.parquet"), lot.join("copy-of-ZR-000009.parquet")).unwrap();
    for model in ["poly:2", "auto"] {
        let (summary, rows) = run(&job(&lot, &folder.path().join(format!("{model}.parquet")), model)).unwrap();
        let skipped: Vec<&str> = summary.skipped.iter().map(|skipped| skipped.file.as_str()).collect();
        let expected = ["ZR-000003.parquet", "ZR-000007.parquet", "empty.parquet", "foreign.parquet", "notes.txt"];
        assert_eq!(skipped, expected, "{:?}", summary.skipped);
        assert!(summary.skipped[2].reason.contains("no bytes") && summary.skipped[4].reason.contains("not a Parquet"));
        assert_eq!((summary.units, rows.len(), summary.rejected.len()), (149, 298, planted + 2));
        // Both are named after the serial, and which is the unit's cannot be told.
        let twice = summary.rejected.iter().filter(|unit| unit.file.contains("ZR-000009"));
        for unit in twice.clone() {
            let kinds: Vec<ReasonKind> = unit.reasons.iter().map(|reason| reason.kind).collect();
            assert_eq!(kinds, [ReasonKind::OneDirection, ReasonKind::DuplicateSerial, ReasonKind::Copied]);
        }
        assert_eq!(twice.map(|unit| unit.file.as_str()).collect::<Vec<_>>(), [spoilt[2], "copy-of-ZR-000009.parquet"]);
    }
}

fn in_version_1(name: &str) -> &str {
    name_in_version_1(name).unwrap_or(name)
}

/// Writes a recording again as schema version 1 had it.
fn to_version_1(path: &Path) {
    let builder = ParquetRecordBatchReaderBuilder::try_new(fs::File::open(path).unwrap()).unwrap();
    let field = |field: &FieldRef| Field::new(in_version_1(field.name()), field.data_type().clone(), false);
    let fields: Vec<Field> = builder.schema().fields().iter().map(field).collect();
    let mut metadata = builder.schema().metadata().clone();
    metadata.insert("zerorate.schema_version".into(), "1".into());
    let schema = Arc::new(Schema::new_with_metadata(fields, metadata));
    let batches: Vec<RecordBatch> = builder.build().unwrap().map(Result::unwrap).collect();
    let mut writer = ArrowWriter::try_new(fs::File::create(path).unwrap(), Arc::clone(&schema), None).unwrap();
    for batch in batches {
        writer.write(&RecordBatch::try_new(Arc::clone(&schema), batch.columns().to_vec()).unwrap()).unwrap();
    }
    writer.close().unwrap();
}

#[test]
fn a_recording_of_schema_version_1_is_fitted_beside_newer_ones() {
    let folder = tempfile::tempdir().unwrap();
    let lot = folder.path().join("lot");
    simulate(&lot, 4, 3, 0.0);
    let (_, newer) = run(&job(&lot, &folder.path().join("newer.parquet"), "poly:2")).unwrap();
    to_version_1(&lot.join("ZR-000002.parquet"));
    let (summary, mixed) = run(&job(&lot, &folder.path().join("mixed.parquet"), "poly:2")).unwrap();
    assert_eq!((summary.units, summary.skipped.len()), (4, 0), "{:?}", summary.skipped);
    let fitted = |rows: &[ModelRow]| -> Vec<_> {
        rows.iter().map(|row| (row.file.clone(), row.coefficients.clone(), row.reasons.clone())).collect()
    };
    assert_eq!(fitted(&mixed), fitted(&newer));
}

#[test]
fn a_dataset_without_recordings_is_an_error_that_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("models.parquet");
    let missing = run(&job(&folder.path().join("none"), &out, "poly:2")).unwrap_err();
    assert!(missing.to_string().contains("no such folder"), "{missing}");
    let lot = folder.path().join("lot");
    fs::create_dir(&lot).unwrap();
    assert!(run(&job(&lot, &out, "poly:2")).unwrap_err().to_string().contains("no file there"));
    fs::write(lot.join("notes.txt"), "nothing yet, but soon").unwrap();
    let nothing = run(&job(&lot, &out, "poly:2")).unwrap_err().to_string();
    assert!(nothing.contains("none of its 1 files") && nothing.contains("notes.txt"), "{nothing}");
}

#[test]
fn a_run_that_was_ended_goes_on_without_doing_finished_units_again() {
    let folder = tempfile::tempdir().unwrap();
    let (lot, out) = (folder.path().join("lot"), folder.path().join("models.parquet"));
    simulate(&lot, 300, 2, 0.0);
    let parts = folder.path().join("models.parquet.parts");
    let kept = || {
        fs::read_dir(&parts).map_or(0, |parts| {
            parts.flatten().filter(|part| part.path().extension().is_some_and(|it| it == "parquet")).count()
        })
    };
    // The process that fits is killed when it has kept its first batch; it may be through before that is seen.
    for attempt in 0.. {
        assert!(attempt < 100, "it was never interrupted in time");
        let mut process = std::process::Command::new(env!("CARGO_BIN_EXE_zerorate-lot"))
            .args(["fit", &lot.display().to_string(), "--out", &out.display().to_string(), "--model", "poly:2"])
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        while kept() == 0 && process.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        process.kill().unwrap();
        process.wait().unwrap();
        if !out.exists() {
            break;
        }
        fs::remove_file(&out).unwrap();
    }
    let job = job(&lot, &out, "poly:2");
    let (summary, rows) = run(&job).unwrap();
    assert_eq!(summary.units, 300);
    assert!(summary.reused >= 128, "{}", summary.reused);
    assert!(!parts.exists());
    let fresh = FitRun { fresh: true, out: folder.path().join("fresh.parquet"), ..job.clone() };
    assert_eq!(run(&fresh).unwrap().1, rows);
    // A second run has nothing to do; a recording that was written again is fitted again.
    assert_eq!(run(&job).unwrap().0.reused, 300);
    let again = lot.join("ZR-000300.parquet");
    let bytes = fs::read(&again).unwrap();
    fs::write(&again, bytes).unwrap();
    assert_eq!(run(&job).unwrap().0.reused, 299);
    // Another model is another fit.
    let other = FitRun { model: Model::Poly(3), ..job };
    assert_eq!(run(&other).unwrap().0.reused, 0);
}

#[test]
fn auto_tells_hysteresis_where_both_directions_were_recorded_and_export_puts_it_on_the_device() {
    let folder = tempfile::tempdir().unwrap();
    let lot = folder.path().join("lot");
    Simulation { units: 8, seed: 12, out: lot.clone(), bad: 0.0, cooling: true }.run(&|| ()).unwrap();
    let fitted = |model: &str| {
        let (summary, rows) = run(&job(&lot, &folder.path().join(format!("{model}.parquet")), model)).unwrap();
        assert_eq!((summary.units, summary.rejected.len()), (8, 0), "{:?}", summary.rejected);
        rows
    };
    let (auto, cubic) = (fitted("auto"), fitted("poly:3"));
    let remembering: Vec<&ModelRow> =
        auto.iter().filter(|row| row.axis_calibration().unwrap().fit.model.history.is_some()).collect();
    assert!(remembering.len() >= 8, "{}", remembering.len());
    assert!(remembering.iter().all(|row| row.model.contains("lags") || row.model.contains("plays")));
    // Held out, auto's with the choice made anew for each fold.
    let held_out = |rows: &[ModelRow]| rows.iter().map(|row| row.held_out_rms).sum::<f64>() / rows.len() as f64;
    assert!(held_out(&auto) < 0.85 * held_out(&cubic), "{} {}", held_out(&auto), held_out(&cubic));
    let unit = &remembering[0].unit_serial;
    let exported = wait(export(&folder.path().join("auto.parquet"), None, unit, &folder.path().join("unit"))).unwrap();
    let record = DeviceRecord::decode(&fs::read(exported.record).unwrap()).unwrap();
    let calibration = Calibration::read(&(&exported.calibration).into()).unwrap();
    for axis in Axis::BOTH {
        let terms = record.axis(axis).law.history.as_ref().map(|history| history.terms.len());
        assert_eq!(
            terms,
            calibration.axes[axis.name()].fit.model.history.as_ref().map(|history| history.terms().len())
        );
    }
}

fn read(path: PathBuf) -> Vec<u8> {
    fs::read(path).unwrap()
}

#[test]
fn an_exported_unit_is_what_fit_makes_of_its_recording_alone() {
    let folder = tempfile::tempdir().unwrap();
    let lot = folder.path().join("lot");
    simulate(&lot, 6, 8, 0.0);
    for model in ["poly:3", "auto"] {
        let out = folder.path().join(format!("{model}.parquet"));
        run(&job(&lot, &out, model)).unwrap();
        let unit = folder.path().join(format!("unit-{model}"));
        let exported = wait(export(&out, None, "ZR-000004", &unit)).unwrap();
        assert!(exported.disagreement < 1e-9);
        let recording = lot.join("ZR-000004.parquet");
        let fit = fit_alone(&recording, &FitOptions { model: model.parse().unwrap(), ..FitOptions::default() });
        let alone = zerorate_bench::recorded::calibration(&(&recording).into(), &fit).unwrap();
        assert_eq!(read(exported.calibration.clone()), alone.to_json().unwrap().into_bytes());
        assert_eq!(read(exported.record), zerorate_bench::recorded::device_record(&alone).unwrap());
        assert_eq!(
            Calibration::read(&(&exported.calibration).into()).unwrap().unit_serial.as_deref(),
            Some("ZR-000004")
        );
    }
    let out = folder.path().join("poly:3.parquet");
    let mine = folder.path().join("mine");
    fs::create_dir(&mine).unwrap();
    fs::write(mine.join("calibration.json"), "of another unit").unwrap();
    assert!(matches!(wait(export(&out, None, "ZR-000004", &mine)), Err(ExportError::Out(_))));
    assert_eq!(fs::read_to_string(mine.join("calibration.json")).unwrap(), "of another unit");
    assert!(matches!(wait(export(&out, None, "ZR-9", folder.path())), Err(ExportError::NoSuchUnit { .. })));
    // A recording that is another one by now is no source of the row's calibration.
    fs::copy(lot.join("ZR-000005.parquet"), lot.join("ZR-000004.parquet")).unwrap();
    assert!(matches!(wait(export(&out, None, "ZR-000004", folder.path())), Err(ExportError::Disagrees { .. })));
    let moved = folder.path().join("moved");
    fs::rename(&lot, &moved).unwrap();
    assert!(wait(export(&out, None, "ZR-000001", folder.path())).is_err());
    let there = moved.display().to_string();
    assert!(wait(export(&out, Some(&there), "ZR-000001", &folder.path().join("there"))).is_ok());
}

#[test]
fn json_has_the_documented_form_and_columns_say_their_units() {
    let folder = tempfile::tempdir().unwrap();
    let (lot, out) = (folder.path().join("lot"), folder.path().join("models.parquet"));
    let truth = simulate(&lot, 20, 4, 0.5);
    schema::hold("lot-truth.json", &serde_json::to_value(&truth).unwrap());
    let (summary, _) = run(&job(&lot, &out, "poly:2")).unwrap();
    assert!(!summary.rejected.is_empty());
    schema::hold("lot-fit.json", &serde_json::to_value(&summary).unwrap());
    // As other tools see it: the file's own key-value pairs.
    let reader = SerializedFileReader::new(fs::File::open(&out).unwrap()).unwrap();
    let pairs = reader.metadata().file_metadata().key_value_metadata().unwrap();
    let columns = pairs.iter().find(|pair| pair.key == "zerorate.columns").unwrap().value.as_deref().unwrap();
    let columns: serde_json::Value = serde_json::from_str(columns).unwrap();
    assert_eq!(columns.as_object().unwrap().len(), 34);
    assert_eq!(columns["held_out_rms"]["unit"], "count");
}

#[test]
fn the_report_has_yield_worst_units_and_the_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let (lot, out) = (folder.path().join("lot"), folder.path().join("models.parquet"));
    simulate(&lot, 40, 4, 0.2);
    run(&job(&lot, &out, "poly:2")).unwrap();
    let limits = folder.path().join("limits.toml");
    fs::write(&limits, "[limits]\nheld_out_rms_counts = 3.0\nreading_mid_counts = { min = 7000.0, max = 9000.0 }\n")
        .unwrap();
    let limits = report::limits(&limits).unwrap();
    let lot = wait(report::report(&out, None, limits)).unwrap();
    assert_eq!((lot.units.len(), lot.worst.len(), lot.undrawn.len()), (40, 10, 0));
    assert!(lot.worst.windows(2).all(|pair| pair[0].held_out_rms >= pair[1].held_out_rms));
    assert!(lot.passed() < 40 - lot.rejected() && lot.rejected() > 0 && lot.passed() > 0);
    // Five minutes a unit.
    assert!((lot.units[39].day - 39.0 * 300.0 / 86_400.0).abs() < 1e-9);
    let page = lot.to_html();
    for part in ["Yield", "Distribution over the lot", "The process over time", "The worst units", "Rejected", "<svg"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("http://") && !page.contains("<script"));
    assert_eq!(page, lot.to_html());
}

#[test]
fn raw_samples_become_the_sums_of_their_recording() {
    use arrow_array::{StringArray, UInt16Array, UInt32Array};
    use arrow_schema::DataType;

    let folder = tempfile::tempdir().unwrap();
    let field = |name, kind| Field::new(name, kind, false);
    let schema = Arc::new(Schema::new(vec![
        field("group_number", DataType::UInt32),
        field("axis", DataType::Utf8),
        field("index", DataType::UInt16),
        field("temperature_counts", DataType::UInt16),
        field("zro_counts", DataType::UInt16),
    ]));
    let rows: Vec<(u32, &str, u16)> = (0..7)
        .flat_map(|group| ["x", "y"].into_iter().flat_map(move |axis| (0..50).map(move |at| (group, axis, at))))
        .collect();
    let reading =
        |row: &(u32, &str, u16)| 8000 + u16::try_from(row.0).unwrap() * 13 + row.2 * 3 + u16::from(row.1 == "y");
    let batch = RecordBatch::try_new(
        Arc::clone(&schema),
        vec![
            Arc::new(rows.iter().map(|row| row.0).collect::<UInt32Array>()),
            Arc::new(StringArray::from_iter_values(rows.iter().map(|row| row.1))),
            Arc::new(rows.iter().map(|row| row.2).collect::<UInt16Array>()),
            Arc::new(rows.iter().map(|row| 9000 + row.2).collect::<UInt16Array>()),
            Arc::new(rows.iter().map(reading).collect::<UInt16Array>()),
        ],
    )
    .unwrap();
    let raw = folder.path().join("raw.parquet");
    let mut writer = ArrowWriter::try_new(fs::File::create(&raw).unwrap(), schema, None).unwrap();
    writer.write(&batch).unwrap();
    writer.close().unwrap();
    let out = folder.path().join("sums.parquet");
    let grouped = wait(raw::group(&Engine::embedded(), &raw.display().to_string(), &out)).unwrap();
    assert_eq!(grouped.rows, 14);
    let reader = ParquetRecordBatchReaderBuilder::try_new(fs::File::open(&out).unwrap());
    let mut found = 0;
    for batch in reader.unwrap().build().unwrap() {
        let batch = batch.unwrap();
        let text = |name: &str, row| {
            arrow_cast::display::array_value_to_string(batch.column_by_name(name).unwrap(), row).unwrap()
        };
        for row in 0..batch.num_rows() {
            let own =
                |it: &&(u32, &str, u16)| it.0.to_string() == text("group_number", row) && it.1 == text("axis", row);
            let readings = || rows.iter().filter(own).map(|it| u64::from(reading(it)));
            assert_eq!(text("n", row), "50");
            assert_eq!(text("zro_sum", row), readings().sum::<u64>().to_string());
            assert_eq!(text("zro_sq_sum", row), readings().map(|z| z * z).sum::<u64>().to_string());
            found += 1;
        }
    }
    assert_eq!(found, 14);
}

#[test]
fn raw_samples_that_cannot_be_summed_without_a_loss_are_refused() {
    use arrow_array::{ArrayRef, Float64Array, StringArray, UInt16Array};

    let folder = tempfile::tempdir().unwrap();
    let whole = || -> ArrayRef { Arc::new(UInt16Array::from(vec![8200, 8201])) };
    let words = |words: [&str; 2]| -> ArrayRef { Arc::new(StringArray::from(words.to_vec())) };
    let refused = |axis: ArrayRef, readings: Option<ArrayRef>| {
        let mut columns = vec![("group_number", whole()), ("axis", axis), ("temperature_counts", whole())];
        columns.extend(readings.map(|readings| ("zro_counts", readings)));
        let batch = RecordBatch::try_from_iter(columns).unwrap();
        let raw = folder.path().join("raw.parquet");
        let file = fs::File::create(&raw).unwrap();
        let mut writer = ArrowWriter::try_new(file, batch.schema(), None).unwrap();
        writer.write(&batch).unwrap();
        writer.close().unwrap();
        let out = folder.path().join("sums.parquet");
        let result = wait(raw::group(&Engine::embedded(), &raw.display().to_string(), &out));
        assert!(!out.exists());
        result.unwrap_err().to_string()
    };
    let xy = || words(["x", "y"]);
    for (text, axis, readings) in [
        ("no column 'zro_counts'", xy(), None),
        (
            "'zro_counts' is of type Float64",
            xy(),
            Some(Arc::new(Float64Array::from(vec![8200.25, 8201.0])) as ArrayRef),
        ),
        ("1 values are missing", xy(), Some(Arc::new(UInt16Array::from(vec![Some(8200), None])) as ArrayRef)),
        ("'axis' is of type UInt16", whole(), Some(whole())),
        ("other words than x and y", words(["x", "z"]), Some(whole())),
    ] {
        let said = refused(axis, readings);
        assert!(said.contains(text) && said.contains("raw.parquet"), "{said}");
    }
}
