//! What is said of a lot's units and files: as `zerorate fit` says it, and nothing left out of the page.

use std::fs;
use std::path::Path;

use zerorate_cal::log_fit::FitOptions;
use zerorate_cal::quality::{Reason, ReasonKind, Verdict};
use zerorate_cal::recording::{Recording, RecordingWriter};
use zerorate_core::units::Axis;
use zerorate_lot::export::export;
use zerorate_lot::models::ModelRow;
use zerorate_lot::{models, report};

use crate::{fit_alone, job, run, simulate, wait};

/// Writes a recording again, changed.
fn again(from: &Path, to: &Path, change: impl FnOnce(&mut Recording)) {
    let mut recording = Recording::read(&from.into()).unwrap();
    change(&mut recording);
    let mut writer = RecordingWriter::create(to, &recording.info).unwrap();
    writer.write_group(&recording.rows).unwrap();
    writer.finish().unwrap();
}

fn page_of(out: &Path) -> String {
    wait(report::report(out, None, Vec::new())).unwrap().to_html()
}

#[test]
fn each_unit_is_judged_as_fit_judges_its_recording_alone_in_the_same_words() {
    let folder = tempfile::tempdir().unwrap();
    let (lot, out) = (folder.path().join("lot"), folder.path().join("models.parquet"));
    simulate(&lot, 24, 11, 0.5);
    let path = |name: &str| lot.join(format!("{name}.parquet"));
    // Of one axis the end is missing; a chamber that nobody could ask went faster than the plan; a test without its ramp.
    again(&path("ZR-000001"), &path("ZR-100001"), |recording| {
        recording.info.unit_serial = "ZR-100001".into();
        recording.rows.retain(|row| row.axis == Axis::X || row.group < 1500);
    });
    again(&path("ZR-000001"), &path("ZR-100002"), |recording| {
        recording.info.unit_serial = "ZR-100002".into();
        recording.rows.truncate(4500);
        recording.rows.iter_mut().for_each(|row| row.chamber_c = f64::NAN);
    });
    again(&path("ZR-000001"), &path("ZR-100003"), |recording| {
        recording.info.unit_serial = "ZR-100003".into();
        recording.rows.iter_mut().for_each(|row| row.phase = zerorate_cal::recording::Phase::Soak);
    });
    for model in ["poly:2", "auto"] {
        let (summary, rows) = run(&job(&lot, &out, model)).unwrap();
        assert_eq!((summary.units, rows.len()), (27, 54));
        let of_serial = |reason: &Reason| matches!(reason.kind, ReasonKind::WrongSerial | ReasonKind::DuplicateSerial);
        for row in rows.iter().step_by(2) {
            let options = FitOptions { model: model.parse().unwrap(), ..FitOptions::default() };
            let alone = fit_alone(&lot.join(&row.file), &options).judgement;
            let own: Vec<Reason> = row.reason_list().into_iter().filter(|reason| !of_serial(reason)).collect();
            assert_eq!(own, alone.reasons, "{model} {}", row.file);
            if own.len() == row.reason_list().len() {
                assert_eq!(row.verdict, alone.verdict.name(), "{model} {}", row.file);
            }
        }
        let told = |serial: &str| -> Vec<String> {
            let row = rows.iter().find(|row| row.unit_serial == serial).unwrap();
            row.reason_list().into_iter().map(|reason| reason.text).collect()
        };
        assert!(told("ZR-100001")[0].starts_with("y: the recording ends after "), "{:?}", told("ZR-100001"));
        assert!(told("ZR-100002").iter().all(|text| text.starts_with("the temperature only rises")));
        assert!(told("ZR-100003")[0].contains("holds no ramp"));
    }
}

#[test]
fn files_that_were_skipped_are_on_the_page_with_their_reasons() {
    let folder = tempfile::tempdir().unwrap();
    let (lot, out) = (folder.path().join("lot"), folder.path().join("models.parquet"));
    simulate(&lot, 3, 5, 0.0);
    fs::write(lot.join("notes.txt"), "the chamber's door was open on Monday").unwrap();
    fs::write(lot.join("ZR-000009.arrows"), "half of a recording").unwrap();
    run(&job(&lot, &out, "poly:2")).unwrap();
    let page = page_of(&out);
    for part in [
        "Skipped files",
        "notes.txt",
        "not a recording: not a Parquet file",
        "ZR-000009.arrows",
        "a recording that was not finished: <code>zerorate fit</code> reads it alone",
        "2 files were skipped.",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // The next run finds them gone.
    fs::remove_file(lot.join("notes.txt")).unwrap();
    fs::remove_file(lot.join("ZR-000009.arrows")).unwrap();
    run(&job(&lot, &out, "poly:2")).unwrap();
    let page = page_of(&out);
    assert!(!page.contains("Skipped files") && !page.contains(" skipped. ") && !page.contains("notes.txt"));
}

#[test]
fn one_run_under_two_serials_is_told_on_both_and_no_longer_when_the_copy_is_gone() {
    let folder = tempfile::tempdir().unwrap();
    let (lot, out) = (folder.path().join("lot"), folder.path().join("models.parquet"));
    simulate(&lot, 4, 6, 0.0);
    let (original, copy) = (lot.join("ZR-000002.parquet"), lot.join("ZR-000077.parquet"));
    again(&original, &copy, |recording| {
        recording.info.unit_serial = "ZR-000077".into();
        recording.info.labels.insert("station".into(), "another".into());
    });
    assert_ne!(fs::read(&original).unwrap(), fs::read(&copy).unwrap());
    let copied = |rows: &[ModelRow]| -> Vec<(String, String)> {
        let told = rows.iter().step_by(2).flat_map(|row| {
            let reasons = row.reasons_of(Verdict::Warning).into_iter();
            reasons
                .filter(|reason| reason.kind == ReasonKind::Copied)
                .map(|reason| (row.file.clone(), reason.text))
                .collect::<Vec<_>>()
        });
        told.collect()
    };
    // A second run takes the rows as they are.
    for _ in 0..2 {
        let (summary, rows) = run(&job(&lot, &out, "poly:2")).unwrap();
        assert_eq!((summary.units, summary.rejected.len()), (5, 0));
        let told = copied(&rows);
        let files: Vec<&str> = told.iter().map(|(file, _)| file.as_str()).collect();
        assert_eq!(files, ["ZR-000002.parquet", "ZR-000077.parquet"]);
        assert!(told[0].1.contains("those of ZR-000077.parquet (serial ZR-000077), to the last bit"), "{}", told[0].1);
        let json = serde_json::to_value(&summary).unwrap();
        crate::schema::hold("lot-fit.json", &json);
        assert_eq!(json["warned"].to_string().matches("\"copied\"").count(), 2);
        let page = page_of(&out);
        assert!(told.iter().all(|(_, text)| page.contains(text)), "{told:?}");
    }
    // Who takes the copy's calibration hears of it.
    let exported = wait(export(&out, None, "ZR-000077", &folder.path().join("unit"))).unwrap();
    assert!(exported.warnings.iter().any(|text| text.contains("those of ZR-000002.parquet (serial ZR-000002)")));
    fs::remove_file(&copy).unwrap();
    let (_, rows) = run(&job(&lot, &out, "poly:2")).unwrap();
    assert_eq!((copied(&rows), models::read(&out).unwrap().len()), (Vec::new(), 8));
}
