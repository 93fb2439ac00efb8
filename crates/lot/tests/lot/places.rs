//! Where a lot lies and where its models go: nothing is lost, and nothing taken for another.

use std::fs;
use std::path::Path;

use zerorate_lot::export::refit;
use zerorate_lot::models::{self, ModelRow};
use zerorate_lot::report;

use crate::{job, run, simulate, wait};

#[test]
fn the_models_of_another_lot_are_kept_and_rows_that_leave_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    let out = folder.path().join("models.parquet");
    // Both have units ZR-000001 and on.
    simulate(&first, 5, 31, 0.0);
    simulate(&second, 4, 32, 0.0);
    let (summary, rows) = run(&job(&first, &out, "poly:2")).unwrap();
    let mut held_out: Vec<f64> = rows.iter().map(|row| row.held_out_rms).collect();
    held_out.sort_by(f64::total_cmp);
    let middle = f64::midpoint(held_out[4], held_out[5]);
    assert!((summary.median_held_out_rms_counts.unwrap() - middle).abs() < 1e-12);
    for other in [second, first.join("*1.parquet")] {
        let kept = run(&job(&other, &out, "poly:2")).unwrap_err().to_string();
        assert!(kept.contains("is not the models of this lot alone, and it is kept"), "{kept}");
    }
    fs::remove_file(first.join("ZR-000002.parquet")).unwrap();
    let (summary, rows) = run(&job(&first, &out, "poly:2")).unwrap();
    assert_eq!((rows.len(), summary.skipped.len()), (8, 1));
    assert!(summary.skipped[0].reason.contains("no longer there"), "{:?}", summary.skipped);
}

#[test]
fn a_recording_is_found_whatever_its_folders_name_and_drawn_only_if_it_is_the_one_that_was_fitted() {
    let folder = tempfile::tempdir().unwrap();
    let lot = folder.path().join("lot [1]");
    for name in ["検査", "x%20y", "q[1]"] {
        simulate(&lot.join(name), 1, 40 + name.len() as u64, 0.0);
        fs::rename(lot.join(name).join("ZR-000001.parquet"), lot.join(name).join("a.parquet")).unwrap();
    }
    let out = folder.path().join("models.parquet");
    let (_, rows) = run(&job(&lot, &out, "poly:2")).unwrap();
    assert_eq!(rows.len(), 6);
    let drawn = |out: &Path| {
        let refitted = |row: &ModelRow| wait(refit(row, None)).is_ok();
        (models::read(out).unwrap().iter().all(refitted), wait(report::report(out, None, Vec::new())).unwrap())
    };
    assert!(drawn(&out).0);
    let plain = folder.path().join("plain");
    simulate(&plain, 3, 45, 0.0);
    let out = folder.path().join("plain.parquet");
    run(&job(&plain, &out, "poly:2")).unwrap();
    fs::copy(plain.join("ZR-000001.parquet"), plain.join("ZR-000002.parquet")).unwrap();
    let (_, report) = drawn(&out);
    assert_eq!((report.worst.len(), report.undrawn.len()), (2, 1), "{:?}", report.undrawn);
    assert!(report.undrawn[0].contains("ZR-000002") && report.undrawn[0].contains("not the one that was fitted"));
}
