//! `zerorate fit`.

mod beside;
mod models;
mod summary;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use zerorate_bench::recorded;
use zerorate_cal::calibration::{Calibration, Origin};
use zerorate_cal::fit::fit;
use zerorate_cal::in_chamber::InChamber;
use zerorate_cal::log_fit::{FitOptions, LogFit};
use zerorate_cal::source::Source;
use zerorate_cal::units::{RateUnit, WrittenRate};
use zerorate_export::Format;
use zerorate_report::LogPage;
use zerorate_words::as_options;

use self::beside::Beside;
use super::{Outcome, Typed};
use crate::log_arguments::{LogArguments, ShownUnits};
use crate::progress::Busy;
use crate::{labels, output, screen};

/// Fit the drift of a log: rate over temperature, recorded at rest
///
/// Reads a log of a unit at rest while its temperature changed, leaves out what is not drift (start-up, spikes, times at
/// which the unit was moved), averages what is left over about 10 s, fits a curve for each axis of each sensor, and says
/// what each is good for. How far to trust the curve is told by the held-out residual, by blocked cross-validation: each
/// of eight folds of the log, predicted by a fit of the other seven.
///
/// What came of another log is kept: a file of it in the place of --out or --report is refused without --force, and what
/// came of a log of the same name, as of this one before it changed, is set aside.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Fit {
    /// The unit's serial number, for the calibration
    #[arg(long, value_parser = NonEmptyStringValueParser::new())]
    serial: Option<String>,

    /// What is to stand in the calibration and in the report besides, as operator="A. N." or station="oven 2"; may be given
    /// again. A recording of the bench has those of its set-up
    #[arg(long = "label", value_name = "NAME=WORDS", value_parser = label)]
    labels: Vec<(String, String)>,

    /// Write the calibration here, as JSON; a rejected log writes none. Without --out and --report both are written to the
    /// working folder, named after the log (not with --json or --plain)
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Write the device record here; only for a recording of the bench (`zerorate calibrate` records one)
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,

    /// Write a report here, as one HTML page; a rejected log writes none
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,

    #[command(flatten)]
    force: output::Force,

    /// Show every model that was compared, and what each predicts of data that it was not fitted to (--json has it too)
    #[arg(long)]
    explain: bool,

    #[command(flatten)]
    chamber: Beside,

    #[command(flatten)]
    units: ShownUnits,

    /// Print JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,

    // The last: its heading would stand over what follows.
    #[command(flatten)]
    log: LogArguments,
}

const EXAMPLES: &str = "\
Examples:
  zerorate fit flight.ulg
      the verdict, flight.calibration.json and flight.report.html in this folder, and what to type next
  zerorate fit cold-day.bin warm-day.bin
      two logs of one unit, fitted as one
  zerorate fit log.csv --out calibration.json --report report.html
  zerorate fit imu.tsv --temperature imu.temp --rate gx,gy,gz --rate-unit dps
      where the columns' names do not make it plain
  zerorate fit chamber.csv.gz --temperature-unit kelvin
      packed, and in another unit than its names say
  zerorate fit log.csv --units deg/h --serial G-0007 --label operator=\"A. N.\"
      what is told, in another unit; of which unit, and by whom
  zerorate fit flight.ulg --chamber night.parquet
      the chamber's air beside the board's own temperature, and what the rate was at the end of each soak
  zerorate fit log.csv --explain
      every model that was compared
  zerorate fit log.parquet --model poly:3 --plain --json
      the cubic that numpy.polyfit gives, as JSON

Exit codes: 0 fitted; 1 the log was rejected, with reasons; 2 error.";

impl Fit {
    /// `typed` is the command as it was typed, for what to type next.
    pub fn run(&self, typed: &Typed) -> Result<Outcome> {
        let logs = self.log.paths();
        let places = self.places();
        let files = [("--out", &places.out), ("--record", &self.record), ("--report", &places.report)];
        output::check_all(&files.map(|(option, path)| (option, path.as_deref())), &logs)?;
        labels::tell_doubts(&self.labels());
        let busy = Busy::reading(logs[0]);
        let options = FitOptions { told_in: self.units.asked(), ..self.log.options() };
        let fit = fitted(&self.log.sources(), &options)?;
        let chamber = self.chamber.joined(&fit)?;
        let units = self.units.of(fit.axes.iter().map(|axis| axis.calibration.rate_unit))?;
        let written =
            if fit.judgement.rejected() { Vec::new() } else { self.write(&fit, chamber.as_ref(), &places, units)? };
        drop(busy);
        if self.json {
            fit.notes.iter().for_each(|note| screen::note(note));
            screen::print_json(&beside::Fitted { fit: &fit, chamber: chamber.as_ref() })?;
        } else {
            let about = summary::About {
                asked: units,
                over: self.log.over(),
                explained: self.explain,
                chamber: chamber.as_ref(),
            };
            summary::page(&fit, &about, &written, &self.next(&fit, &places, typed)).print()?;
        }
        Ok(if fit.judgement.rejected() { Outcome::Rejected } else { Outcome::Done })
    }

    /// Where results go: where they were asked for; where nothing was asked for and people look on, to the working folder,
    /// named after the first log.
    fn places(&self) -> Places {
        let asked = Places { out: self.out.clone(), report: self.report.clone() };
        if asked.out.is_some() || asked.report.is_some() || self.json || self.log.is_plain() {
            return asked;
        }
        let name = self.log.files[0].file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Places {
            out: Some(PathBuf::from(format!("{name}.calibration.json"))),
            report: Some(PathBuf::from(format!("{name}.report.html"))),
        }
    }

    /// Writes the results and says what was written. The calibration comes last: where it is, all is.
    fn write(
        &self,
        fit: &LogFit,
        chamber: Option<&InChamber>,
        places: &Places,
        units: Option<WrittenRate>,
    ) -> Result<Vec<PathBuf>> {
        let mut written = Vec::new();
        if places.out.is_none() && places.report.is_none() && self.record.is_none() {
            return Ok(written);
        }
        let calibration = recorded::of_fit(&self.log.sources(), fit, self.serial.clone(), self.labels())?;
        let calibration = Calibration { told_in: units, ..calibration };
        let origins = &calibration.sources;
        // Before the first is written, all places are known to be free.
        if let Some(out) = &places.out {
            self.force.calibration("--out", out, origins, self.serial.as_deref())?;
        }
        if let Some(report) = &places.report {
            self.force.text("--report", report, origins, None)?;
        }
        if let Some(path) = &self.record {
            self.force.record("--record", path, calibration.unit_serial.as_deref().unwrap_or_default())?;
        }
        if let Some(path) = &places.report {
            let next = places.out.as_ref().map(|out| self.use_command(fit, out).1);
            let about =
                About { serial: calibration.unit_serial.as_deref(), labels: &calibration.labels, units, chamber };
            output::write(path, &page(fit, about, origins, next.as_deref(), places.out.as_deref()))?;
            written.push(path.clone());
        }
        if let Some(path) = &self.record {
            output::write_bytes(path, &recorded::device_record(&calibration)?)?;
            written.push(path.clone());
        }
        if let Some(path) = &places.out {
            let text = calibration.to_json();
            output::write(path, &text.with_context(|| format!("{}: damaged, it seems", fit.source()))?)?;
            written.push(path.clone());
        }
        Ok(written)
    }

    fn labels(&self) -> BTreeMap<String, String> {
        self.labels.iter().cloned().collect()
    }

    /// What to do with a calibration: an autopilot's parameters come of an autopilot's log.
    fn use_command(&self, fit: &LogFit, out: &Path) -> (&'static str, String) {
        match fit.autopilot {
            Some(format) => (
                "To get the autopilot's parameters from it",
                format!("zerorate export {} --format {}", output::argument(out), Format::from(format)),
            ),
            // A recording of the bench has two axes and two temperatures in counts, which no table of a log has.
            None if fit.axes.iter().any(|axis| axis.calibration.rate_unit == RateUnit::Counts) => (
                "To get its curves as a table",
                format!("zerorate export {} --format csv --out curves.csv", output::argument(out)),
            ),
            None => (
                "To correct a log by it",
                format!(
                    "zerorate apply {} {}{} --out corrected.csv",
                    output::argument(out),
                    output::argument(&self.log.files[0]),
                    self.log.typed_columns()
                ),
            ),
        }
    }

    /// What to type next, and why.
    fn next(&self, fit: &LogFit, places: &Places, typed: &Typed) -> Option<(&'static str, String)> {
        match &places.out {
            _ if fit.judgement.rejected() => None,
            Some(out) => Some(self.use_command(fit, out)),
            // The same command again, whatever options it had.
            None if places.report.is_some() => {
                Some(("To keep the calibration", format!("{typed} --out calibration.json")))
            }
            None => Some((
                "To keep the calibration, and to see it drawn",
                format!("{typed} --out calibration.json --report report.html"),
            )),
        }
    }
}

/// The page of a fit, with the commands that go on from it where the calibration is kept.
pub(super) fn page(
    fit: &LogFit,
    about: About,
    origins: &[Origin],
    next_command: Option<&str>,
    calibration: Option<&Path>,
) -> String {
    let name = output::argument(calibration.unwrap_or(Path::new("calibration.json")));
    let export = |format: Format| format!("zerorate export {name} --format {format} --out {}", format.file_name());
    let About { serial, labels, units, chamber } = about;
    LogPage { fit, units, serial, labels, chamber, sources: origins, next_command, export_command: Some(&export) }
        .to_html()
}

/// Fits logs. The fit's sentences name the command's options, where the library names its parameters, on the page and in the
/// files that are made of it.
pub(super) fn fitted(sources: &[Source], options: &FitOptions) -> Result<LogFit> {
    let mut fit = fit(sources, options)?;
    fit.notes.iter_mut().for_each(|note| *note = as_options(note));
    fit.judgement.reasons.iter_mut().for_each(|reason| reason.text = as_options(&reason.text));
    Ok(fit)
}

/// Of what unit a page is, by whom, and how it is to be told.
#[derive(Clone, Copy)]
pub(super) struct About<'a> {
    pub serial: Option<&'a str>,
    pub labels: &'a BTreeMap<String, String>,
    pub units: Option<WrittenRate>,
    pub chamber: Option<&'a InChamber>,
}

/// A label as it is typed.
fn label(text: &str) -> std::result::Result<(String, String), String> {
    let parts = text.split_once('=').map(|(name, words)| (name.trim().to_owned(), words.trim().to_owned()));
    parts.filter(|(name, words)| !name.is_empty() && !words.is_empty()).ok_or("give NAME=WORDS".to_owned())
}

/// Where results go.
struct Places {
    out: Option<PathBuf>,
    report: Option<PathBuf>,
}
