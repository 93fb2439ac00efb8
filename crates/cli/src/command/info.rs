//! `zerorate info`.

mod calibration;
mod chamber;
mod flight;
mod log;
mod record;
mod recording;

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde::{Deserialize, Serialize};
use zerorate_bench::profile::Profile;
use zerorate_cal::recording::{ChamberRecording, Recording, RecordingFault};
use zerorate_cal::source::packed::unpacked;
use zerorate_words::sentence;

use super::Outcome;
use crate::progress::Busy;
use crate::screen;
use crate::screen::Page;

/// Say what is in a recording, calibration, device record or log
///
/// The kind is told by what is in the file, not by its name. A recording that was cut off, or is still being written, is
/// shown up to its last whole group.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Info {
    /// Recordings (Parquet, or .arrows while they are written), calibrations, device records, logs
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,

    /// Print JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  zerorate info calibration/*
  zerorate info calibration/in-progress/full-temperature.arrows
                                                        how much of a cut recording is there
  zerorate info log.csv                                 what fit would take its columns for
  zerorate info flight.ulg                              the sensors in it, how warm, how long
  zerorate info calibration/device-record.bin --json";

/// What was found in a file.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
enum Content {
    Recording(recording::Facts),
    ChamberRecording(chamber::Facts),
    Calibration(calibration::Facts),
    DeviceRecord(record::Facts),
    Log(log::Facts),
    FlightLog(flight::Facts),
    /// What stands beside those in a folder of results.
    Other {
        what: &'static str,
    },
    Unreadable {
        error: String,
    },
}

/// A file and what was found in it, as JSON has it.
#[derive(Debug, Serialize)]
struct Found<'a> {
    file: &'a Path,
    #[serde(flatten)]
    content: Content,
}

/// All of them.
#[derive(Debug, Serialize)]
struct Report<'a> {
    schema: u32,
    files: Vec<Found<'a>>,
}

impl Info {
    pub fn run(&self) -> Result<Outcome> {
        let mut found = Vec::new();
        let mut outcome = Outcome::Done;
        for (place, file) in self.files.iter().enumerate() {
            let busy = Busy::reading(file);
            let content = content(file);
            drop(busy);
            let content = content.unwrap_or_else(|error| {
                // The other files are looked at all the same.
                screen::error(&error);
                outcome = Outcome::Failed;
                Content::Unreadable { error: sentence(error.as_ref()) }
            });
            if self.json {
                found.push(Found { file, content });
            } else {
                show(file, &content, place + 1 < self.files.len())?;
            }
        }
        if self.json {
            screen::print_json(&Report { schema: 1, files: found })?;
        }
        Ok(outcome)
    }
}

fn show(file: &Path, content: &Content, another: bool) -> Result<()> {
    let mut page = Page::default();
    let name = file.display().to_string();
    match content {
        Content::Recording(facts) => facts.show(&name, &mut page),
        Content::ChamberRecording(facts) => facts.show(&name, &mut page),
        Content::Calibration(facts) => facts.show(&name, &mut page),
        Content::DeviceRecord(facts) => facts.show(&name, &mut page),
        Content::Log(facts) => facts.show(&name, &mut page),
        Content::FlightLog(facts) => facts.show(&name, &mut page),
        Content::Other { what } => page.sentence("", &format!("{name}: {what}")),
        // Told already.
        Content::Unreadable { .. } => return Ok(()),
    }
    if another {
        page.gap();
    }
    page.print()
}

/// A summary has the tests that a calibration has not.
fn is_summary(file: &Path) -> bool {
    #[derive(Deserialize)]
    struct Summary {
        #[serde(rename = "tests")]
        _tests: Vec<serde::de::IgnoredAny>,
    }
    File::open(file).is_ok_and(|file| serde_json::from_reader::<_, Summary>(BufReader::new(file)).is_ok())
}

/// As much of a file as tells what it is.
const START_BYTES: u64 = 64;

/// What a file begins with tells what it is, also where it is packed.
fn content(file: &Path) -> Result<Content> {
    let cannot = || format!("{}: cannot be read", file.display());
    ensure!(!file.is_dir(), "{0}: this is a folder: name the files in it, as {0}/*", file.display());
    let start = unpacked(&file.into())?.start(START_BYTES).with_context(cannot)?;
    let start = start.as_slice();
    let ends_with = |extension: &str| file.extension().is_some_and(|found| found == extension);
    if let Some(facts) = flight::Facts::read(file, start)? {
        return Ok(Content::FlightLog(facts));
    }
    if start.starts_with(b"ZRCR") || ends_with("bin") {
        return record::Facts::read(file).map(Content::DeviceRecord);
    }
    if start.starts_with(b"<!DOCTYPE html") {
        return Ok(Content::Other { what: "a report: open it in a browser" });
    }
    if ends_with("toml") && Profile::read(file, Profile::ANYWHERE).is_ok() {
        return Ok(Content::Other {
            what: "a chamber's profile: zerorate chamber runs it, and says the plan with --dry-run",
        });
    }
    if ends_with("toml") {
        return Ok(Content::Other { what: "a set-up file: zerorate setup --check says whether it is sound" });
    }
    if start.trim_ascii_start().first() == Some(&b'{') {
        if is_summary(file) {
            return Ok(Content::Other { what: "the summary of a calibration, for programs" });
        }
        return calibration::Facts::read(file).map(Content::Calibration);
    }
    if start.starts_with(b"PAR1") || start.starts_with(&[0xFF; 4]) || ends_with("arrows") {
        match Recording::read(&file.into()) {
            // It may be a chamber's; Parquet that is neither is somebody's log.
            Err(error) if matches!(error.fault, RecordingFault::NotARecording) => {
                match ChamberRecording::read(&file.into()) {
                    Ok(recording) => return Ok(Content::ChamberRecording(chamber::Facts::of(&recording))),
                    Err(_) if start.starts_with(b"PAR1") => {}
                    Err(_) => return Err(error.into()),
                }
            }
            recording => return Ok(Content::Recording(recording::Facts::of(&recording?))),
        }
    }
    log::Facts::read(file).map(Content::Log)
}
