//! `zerorate report`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use serde::Serialize;
use zerorate_board_run::folder::{BoardRun, CALIBRATION, CERTIFICATE, FILES, REPORT};
use zerorate_cal::calibration::{AxisCalibration, Calibration, Kind, Origin, sha256};
use zerorate_cal::log::{Sensor, SensorChoice};
use zerorate_cal::log_fit::{FitOptions, GROUP_SECONDS, LogFit, are_alike};
use zerorate_cal::source::Source;
use zerorate_cal::table::Columns;
use zerorate_cal::units::{RateScale, RateUnit, WrittenRate};
use zerorate_fit::drift_fit::{FitStatistics, ResidualOver};
use zerorate_fit::model::Model;
use zerorate_report::{board_page, certificate};

use super::Outcome;
use super::fit::{About, fitted};
use crate::log_arguments::{ShownUnits, UnitArguments};
use crate::progress::Busy;
use crate::screen::Page;
use crate::{output, screen};

/// Make the report of a calibration again
///
/// Finds the log that a calibration was made from by its name, makes sure by its SHA-256 that it is the same, fits it as
/// it was fitted then, and writes the report as one HTML page. In the folder of a board's run the report is made from the
/// files that `zerorate calibrate` left there, if they are of one run, and so is its certificate.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Report {
    /// The calibration that `zerorate fit --out` wrote, or a folder with a calibration.json, as `calibrate` leaves it
    #[arg(value_name = "CALIBRATION")]
    calibration: PathBuf,

    /// The log it was made from, of several the first; without this it is looked for beside the calibration. The others are
    /// looked for beside that one
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,

    /// The log's temperature column, where its name does not make it plain
    #[arg(long, value_name = "COL")]
    temperature: Option<String>,

    /// The log's time column, where its name does not make it plain
    #[arg(long, value_name = "COL")]
    time: Option<String>,

    /// Write the report here; without this it is report.html beside the calibration
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Of a board's run: write its certificate here; without this it is certificate.html beside the calibration, or none where
    /// --out is given
    #[arg(long, value_name = "FILE")]
    certificate: Option<PathBuf>,

    #[command(flatten)]
    force: output::Force,

    #[command(flatten)]
    shown: ShownUnits,

    /// Print JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,

    // The last: its heading would stand over what follows.
    #[command(flatten)]
    units: UnitArguments,
}

const EXAMPLES: &str = "\
Examples:
  zerorate report calibration.json
  zerorate report calibration.json --log /data/chamber/log.csv --out chamber.html
  zerorate report calibration
      the folder of a board's run: report.html and certificate.html there

A log that was not calibrated yet is reported by `zerorate fit FILE --report report.html`.";

/// What was done, as JSON has it.
#[derive(Serialize)]
struct Done<'a> {
    schema: u32,
    out: &'a Path,
    /// Of a board's run alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    certificate: Option<&'a Path>,
    /// A board's run has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    log: Option<&'a Path>,
}

impl Report {
    pub fn run(&self) -> Result<Outcome> {
        let path = match self.calibration.as_path() {
            // Names without `./` are easier to read, here and in the report.
            folder if folder == Path::new(".") => PathBuf::from(CALIBRATION),
            folder if folder.is_dir() => folder.join(CALIBRATION),
            file => file.to_owned(),
        };
        let calibration = Calibration::read(&(&path).into())?;
        let out = self.out.clone().unwrap_or_else(|| path.with_file_name(REPORT));
        if went_through_a_run(&calibration) {
            return self.of_run(&path, &calibration, &out);
        }
        ensure!(
            self.certificate.is_none(),
            "--certificate: {} is no board's run, and a log has no certificate: leave it out",
            path.display()
        );
        let logs = self.logs(&path, &calibration)?;
        let log = &logs[0];
        let inputs: Vec<&Path> = logs.iter().map(PathBuf::as_path).collect();
        output::check("--out", &out, &[&[path.as_path()], &inputs[..]].concat())?;
        let busy = Busy::reading(log);
        let sources: Vec<Source> = logs.iter().map(Source::from).collect();
        let told_in = self.shown.asked().or(calibration.told_in);
        let options = FitOptions { told_in, ..self.options(&calibration) };
        let mut fit = fitted(&sources, &options)?;
        if let Some(then) = averaged_otherwise(&fit, &calibration) {
            fit = fitted(&sources, &FitOptions { group_s: Some(then), ..options })?;
        }
        drop(busy);
        in_the_same_units(log, &fit, &calibration)?;
        self.force.text("--out", &out, &calibration.sources, None)?;
        let units = self.shown.of(fit.axes.iter().map(|axis| axis.calibration.rate_unit))?.or(calibration.told_in);
        let about =
            About { serial: calibration.unit_serial.as_deref(), labels: &calibration.labels, units, chamber: None };
        output::write(&out, &super::fit::page(&fit, about, &calibration.sources, None, Some(&path)))?;
        let done = Done { schema: 1, out: &out, certificate: None, log: Some(log) };
        self.tell(&done, &fit.source(), &fit.notes)
    }

    /// The report of a board's run, from the files beside its calibration.
    fn of_run(&self, path: &Path, calibration: &Calibration, out: &Path) -> Result<Outcome> {
        let columns = self.temperature.is_some() || self.time.is_some();
        ensure!(
            self.log.is_none() && !columns && self.units == UnitArguments::default(),
            "{}: a board's run has no log: leave --log, --temperature, --time and their units out",
            path.display()
        );
        ensure!(
            path.file_name().is_some_and(|name| name == CALIBRATION),
            "{}: the files of a board's run have their own names: name the folder that calibrate wrote",
            path.display()
        );
        let folder = path.parent().unwrap_or(Path::new(""));
        let inputs = FILES.map(|file| folder.join(file));
        let sheet = self.certificate.clone().or_else(|| self.out.is_none().then(|| path.with_file_name(CERTIFICATE)));
        let places = [("--out", Some(out)), ("--certificate", sheet.as_deref())];
        output::check_all(&places, &inputs.each_ref().map(PathBuf::as_path))?;
        let busy = Busy::reading(folder);
        // The page is in counts, with rates beside them.
        let units = self.shown.of([RateUnit::Counts, RateUnit::Dps].into_iter())?;
        let run = BoardRun::read(folder)?;
        let page = board_page(&run, units);
        drop(busy);
        for (option, place) in places {
            place.map_or(Ok(()), |place| self.force.text(option, place, &calibration.sources, None))?;
        }
        output::write(out, &page)?;
        if let Some(sheet) = &sheet {
            output::write(sheet, &certificate(&run))?;
        }
        let done = Done { schema: 1, out, certificate: sheet.as_deref(), log: None };
        self.tell(&done, &format!("{} and the files beside it", path.display()), &[])
    }

    fn tell(&self, done: &Done, whence: &str, notes: &[String]) -> Result<Outcome> {
        if self.json {
            notes.iter().for_each(|note| screen::note(note));
            screen::print_json(done)?;
        } else {
            let mut page = Page::default();
            let sheet = done.certificate.map(|sheet| format!(" and {}", sheet.display())).unwrap_or_default();
            page.sentence("", &format!("Wrote {}{sheet}, from {whence}.", done.out.display()));
            notes.iter().for_each(|note| page.sentence("  - ", note));
            page.print()?;
        }
        Ok(Outcome::Done)
    }

    /// The logs that the calibration was made from, the first by `--log` and the others beside it.
    fn logs(&self, path: &Path, calibration: &Calibration) -> Result<Vec<PathBuf>> {
        let [first, others @ ..] = &calibration.sources[..] else {
            bail!("{}: the calibration names no log that it was made from", path.display());
        };
        let place = self.log.clone().unwrap_or_else(|| path.with_file_name(&first.file));
        let advice = "--log says where it is";
        let mut logs = vec![same_log(path, place.clone(), first, advice)?];
        for other in others {
            let advice = format!("put it beside {}", place.display());
            logs.push(same_log(path, place.with_file_name(&other.file), other, &advice)?);
        }
        Ok(logs)
    }

    /// The options by which the calibration comes out again.
    fn options(&self, calibration: &Calibration) -> FitOptions {
        let axes = || calibration.axes.values();
        let fits = || axes().map(|axis| &axis.fit.statistics);
        let chosen = fits().any(|fit: &FitStatistics| fit.candidates.len() > 1);
        let sensors: Vec<Sensor> = axes().filter_map(|axis| axis.sensor).collect();
        // A board's recording and an autopilot's log have their columns and know them.
        let is_table = calibration.kind == Kind::Log && calibration.sources.iter().all(|log| log.autopilot().is_none());
        FitOptions {
            columns: Columns {
                time: self.time.clone(),
                temperature: self.temperature.clone(),
                rates: if is_table { calibration.axes.keys().cloned().collect() } else { Vec::new() },
                time_unit: self.units.time_unit,
                temperature_unit: self.units.temperature_unit,
                rate_unit: self.units.rate_unit,
                else_rate_unit: axes().next().and_then(|axis| WrittenRate::of(axis.rate_unit)).filter(|_| is_table),
                likely_rate_unit: None,
            },
            model: if chosen { Model::Auto } else { axes().next().map_or(Model::Auto, AxisCalibration::model) },
            plain: fits().any(|fit| fit.residual_over == ResidualOver::Rows),
            // What was calibrated was allowed.
            allow_narrow: true,
            sensor: choice(&sensors),
            ..FitOptions::default()
        }
    }
}

/// A drift made again that is so many times another is in another unit: the closest, degrees F and C, are 1.8 apart.
const SAME_SIZE: f64 = 1.5;

/// Refuses a fit that comes out otherwise than the calibration, for the log was then read in units that were given.
fn in_the_same_units(log: &Path, fit: &LogFit, calibration: &Calibration) -> Result<()> {
    for (name, own) in &calibration.axes {
        let earlier = own.measured_drift().peak_to_peak();
        // In a unit a thousand times off the unit seems to be moved all the time, and nothing is left to fit.
        let again = fit.axes.iter().find(|axis| axis.name == *name);
        let now = again.map_or(f64::NAN, |axis| axis.calibration.measured_drift().peak_to_peak());
        ensure!(
            (1.0 / SAME_SIZE..SAME_SIZE).contains(&(now / earlier)),
            "{}: {name} does not come out with the drift that the calibration has, {}: give --rate-unit and --temperature-unit as for the fit",
            log.display(),
            RateScale::of(own.rate_unit, &[earlier], None).told(earlier)
        );
    }
    Ok(())
}

/// The seconds in an average of the calibration, where this fit has others: then they were asked for.
fn averaged_otherwise(fit: &LogFit, calibration: &Calibration) -> Option<f64> {
    let (now, then) = fit.averaged_over_s().zip(calibration.averaged_over_s)?;
    Some(then).filter(|then| !are_alike(now, *then) && GROUP_SECONDS.contains(then))
}

/// Whether the calibration is that of a board's run, trim experiment and all, and not of a log or one recording.
fn went_through_a_run(calibration: &Calibration) -> bool {
    calibration.axes.values().any(|axis| axis.trim.as_ref().is_some_and(|trim| trim.paired.is_some()))
}

/// The choice that takes these sensors and, of the usual logs, no others.
fn choice(sensors: &[Sensor]) -> Option<SensorChoice> {
    let first = sensors.first()?;
    if sensors.iter().all(|sensor| sensor == first) {
        return Some(SensorChoice::Instance(first.kind, first.instance));
    }
    sensors.iter().all(|sensor| sensor.kind == first.kind).then_some(SensorChoice::Kind(first.kind))
}

/// A log, if it is the same to the byte; `advice` says what to do where there is none.
fn same_log(path: &Path, log: PathBuf, origin: &Origin, advice: &str) -> Result<PathBuf> {
    let sha256 = sha256(&(&log).into())
        .with_context(|| format!("{}: cannot be read (the log {} is needed; {advice})", log.display(), origin.file))?;
    ensure!(
        sha256 == origin.sha256,
        "{}: not the log that {} was made from (its SHA-256 is another): {advice}, or fit this one",
        log.display(),
        path.display()
    );
    Ok(log)
}
