//! `zerorate live`.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, anyhow};
use clap::Args;
use zerorate_bench::setup::SetUp;
use zerorate_cal::recording::{ChamberRecording, Recording};
use zerorate_live::Listen;
use zerorate_report::{LiveRun, RunGroup};

use super::Outcome;
use crate::interrupt;
use crate::looking_on::{self, LookingOn};
use crate::screen;

/// How often it is seen whether a recording has grown, and whether Ctrl-C was pressed.
const LOOK_EVERY: Duration = Duration::from_millis(500);

/// Show a recording of the bench on a page, as `calibrate --live` shows a run as it goes
///
/// The recording is only read. One that is still being written (.arrows) is shown as it grows, so that a run which was begun
/// without --live can be looked on too. Ctrl-C ends it.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct LookOn {
    /// The recording (Parquet, or .arrows while it is written)
    #[arg(value_name = "RECORDING")]
    recording: PathBuf,

    /// Where to serve the page: ADDRESS:PORT of this machine (port 0: any free one). Beyond this machine the page's address
    /// has a token in it, which is printed
    #[arg(long, value_name = "ADDRESS:PORT", default_value = looking_on::HERE)]
    on: Listen,
}

const EXAMPLES: &str = "\
Examples:
  zerorate live calibration/full-temperature.parquet
  zerorate live calibration/in-progress/full-temperature.arrows --on 0.0.0.0:5495";

impl LookOn {
    pub fn run(&self) -> Result<Outcome> {
        let mut file = self.recording.clone();
        let mut length = length(&file)?;
        let live = LookingOn::on(&self.on, so_far(&file)?)?;
        interrupt::watch()?;
        screen::note(&live.told());
        while !interrupt::was_asked_for() {
            thread::sleep(LOOK_EVERY);
            // A recording that is finished goes elsewhere; until it is there, what was read of it stays.
            let Ok(now) = self::length(&file) else {
                file = finished(&file).unwrap_or(file);
                continue;
            };
            if now != length
                && let Ok(run) = so_far(&file)
            {
                length = now;
                live.change(|shown| *shown = run);
            }
        }
        Ok(Outcome::Done)
    }
}

fn length(file: &Path) -> Result<u64> {
    Ok(fs::metadata(file).with_context(|| file.display().to_string())?.len())
}

/// Where a recording that was being written is when it is finished: beside it, or out of the folder of what is in progress.
fn finished(file: &Path) -> Option<PathBuf> {
    let beside = file.with_extension("parquet");
    let outside = file.parent()?.parent()?.join(beside.file_name()?);
    [beside, outside].into_iter().find(|place| place.is_file())
}

/// What a recording has so far.
fn so_far(file: &Path) -> Result<LiveRun> {
    let recording = Recording::read(&file.into()).map_err(|error| {
        if ChamberRecording::read(&file.into()).is_err() {
            return error.into();
        }
        anyhow!(
            "{} is a chamber's own recording, without a board: `zerorate info` shows it, and `zerorate fit LOG --chamber` joins it to a log",
            file.display()
        )
    })?;
    let info = &recording.info;
    // A recording of another's set-up is shown by the paper's scales, as `monitor` does.
    let setup = SetUp::parse(&info.set_up, "of the recording").unwrap_or_else(|_| SetUp::paper());
    let mut run = looking_on::about(&format!("{}, {}", info.unit_serial, info.procedure), &setup);
    for row in &recording.rows {
        run.axes[row.axis.index()].push(RunGroup::from(row));
        run.air_c = row.chamber_c;
    }
    run.doing = recording.rows.last().map(|row| row.phase.name().to_owned()).unwrap_or_default();
    run.ended = (!recording.cut).then(|| "The recording is finished.".to_owned());
    Ok(run)
}
