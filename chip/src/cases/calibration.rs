//! A calibration in short by the very procedures of the command `calibrate`, on the image and on the native board.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use zerorate_bench::calibrate::calibrate;
use zerorate_bench::calibrated::Unit;
use zerorate_bench::checkpoint::Keep;
use zerorate_bench::instruments::Bench;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::run::Silent;
use zerorate_bench::setup::SetUp;
use zerorate_bench::{simulated, stepped};
use zerorate_cal::recording::{GroupRow, Recording};

use super::{Given, paper};
use crate::lock_step::ChipBoard;
use crate::paper_record::UNIT;

/// Every recording of a run, by its name.
type Recordings = Vec<(String, Vec<GroupRow>)>;

/// The paper's set-up in short: a ramp from the cold end on, with the way back.
fn set_up() -> SetUp {
    let mut setup = SetUp::paper();
    setup.chamber.ramp_groups = 400;
    setup.chamber.soak_groups = 4;
    setup.chamber.soaks_c = vec![-40.0];
    setup.trim.points = 5;
    setup.trim.groups_per_point = 2;
    setup
}

fn run(mut bench: Bench, setup: &SetUp, out: &Path) -> Result<(serde_json::Value, Recordings)> {
    let unit = Unit::new(UNIT, Some((PlantKind::Paper, 1)))?;
    let summary = calibrate(&mut bench, setup, unit, out, &mut Silent, Keep::Nothing)?;
    let mut recordings = Vec::new();
    for entry in std::fs::read_dir(out)? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "parquet") {
            let name = path.file_name().context("a file without a name")?.display().to_string();
            recordings.push((name, Recording::read(&(&path).into())?.rows));
        }
    }
    recordings.sort_by(|a, b| a.0.cmp(&b.0));
    let summary = serde_json::to_value(summary)?;
    Ok((serde_json::json!([summary["axes"], summary["tests"]]), recordings))
}

/// Every number of every recording, and what is concluded from them.
pub fn in_short(given: &Given) -> Result<String> {
    let setup = set_up();
    let folder = tempfile::tempdir()?;
    let serial = given.record.unit.clone();
    let native = run(simulated::bench(paper(), &setup, &serial), &setup, &folder.path().join("native"))?;
    let chip = ChipBoard::new(&given.image, paper())?;
    let image = run(stepped::bench(chip, &setup), &setup, &folder.path().join("image"))?;
    let (mut groups, mut moves) = (0, 0);
    for ((name, native), (_, image)) in native.1.iter().zip(&image.1) {
        for (native, image) in native.iter().zip(image) {
            // Each number written so that no two are written alike: of floats the shortest text that reads back.
            let (native, image) = (format!("{native:?}"), format!("{image:?}"));
            ensure!(native == image, "{name}\n    image {image}\n    native {native}");
        }
        ensure!(native.len() == image.len(), "{name}: {} rows and {}", native.len(), image.len());
        groups += native.len() / 2;
        moves += native.windows(3).filter(|rows| rows[0].tap != rows[2].tap).count();
    }
    ensure!(native.0 == image.0, "other conclusions: {}\n    and {}", native.0, image.0);
    ensure!(native.1.len() == 5 && image.1.len() == 5 && groups > 1000 && moves > 10, "{groups} groups, {moves} moves");
    Ok(format!(
        "`calibrate`: {groups} groups in 5 recordings, {moves} changes of a tap, and all that is concluded, the same bit for bit"
    ))
}
