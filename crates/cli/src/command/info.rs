//! `zerorate info`.

mod calibration;
mod log;
mod record;
mod recording;

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde::Serialize;
use zerorate_cal::recording::{Recording, RecordingError};

use super::Outcome;
use crate::progress::Busy;
use crate::screen;
use crate::screen::Page;

/// Say what is in a file: recording, calibration, device record or log
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
  zerorate info calibration/full-temperature.arrows     how much of a cut recording is there
  zerorate info log.csv                                 what fit would take its columns for
  zerorate info calibration/device-record.bin --json";

/// What was found in a file.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
enum Content {
    Recording(recording::Facts),
    Calibration(calibration::Facts),
    DeviceRecord(record::Facts),
    Log(log::Facts),
    Unreadable { error: String },
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
        let mut failed = None;
        for file in &self.files {
            let busy = Busy::reading(file);
            let content = content(file);
            drop(busy);
            match content {
                Ok(content) if self.json => found.push(Found { file, content }),
                Ok(content) => show(file, &content, found.is_empty() && self.files.len() == 1)?,
                // The other files are looked at all the same; the last error ends the program.
                Err(error) => {
                    if self.json {
                        found.push(Found { file, content: Content::Unreadable { error: format!("{error:#}") } });
                    }
                    if let Some(earlier) = failed.replace(error) {
                        screen::error(&earlier);
                    }
                }
            }
        }
        if self.json {
            screen::print_json(&Report { schema: 1, files: found })?;
        }
        failed.map_or(Ok(Outcome::Done), Err)
    }
}

fn show(file: &Path, content: &Content, only: bool) -> Result<()> {
    let mut page = Page::default();
    let name = file.display().to_string();
    match content {
        Content::Recording(facts) => facts.show(&name, &mut page),
        Content::Calibration(facts) => facts.show(&name, &mut page),
        Content::DeviceRecord(facts) => facts.show(&name, &mut page),
        Content::Log(facts) => facts.show(&name, &mut page),
        Content::Unreadable { error } => page.line(error),
    }
    if !only {
        page.gap();
    }
    page.print()
}

/// What a file begins with tells what it is.
fn content(file: &Path) -> Result<Content> {
    let cannot = || format!("{}: cannot be read", file.display());
    ensure!(!file.is_dir(), "{0}: this is a folder: name the files in it, as {0}/*", file.display());
    let mut start = [0; 64];
    let mut length = 0;
    let mut opened = File::open(file).with_context(cannot)?;
    while length < start.len() {
        match opened.read(&mut start[length..]).with_context(cannot)? {
            0 => break,
            read => length += read,
        }
    }
    let start = &start[..length];
    let ends_with = |extension: &str| file.extension().is_some_and(|found| found == extension);
    if start.starts_with(b"ZRCR") || ends_with("bin") {
        return record::Facts::read(file).map(Content::DeviceRecord);
    }
    if start.trim_ascii_start().first() == Some(&b'{') {
        return calibration::Facts::read(file).map(Content::Calibration);
    }
    if start.starts_with(b"PAR1") || start.starts_with(&[0xFF; 4]) || ends_with("arrows") {
        match Recording::read(file) {
            // Parquet that the bench did not write is somebody's log.
            Err(RecordingError::NotARecording { .. }) if start.starts_with(b"PAR1") => {}
            recording => return Ok(Content::Recording(recording::Facts::of(&recording?))),
        }
    }
    log::Facts::read(file).map(Content::Log)
}
