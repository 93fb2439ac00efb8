//! `zerorate fit`.

mod summary;

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use zerorate_cal::calibration::{Calibration, Source};
use zerorate_cal::log_fit::{LogFit, fit_log};
use zerorate_cal::report::LogReport;

use super::Outcome;
use crate::log_arguments::LogArguments;
use crate::progress::Busy;
use crate::{output, screen};

/// Fit the drift of a log: rate over temperature, recorded at rest
///
/// Reads a log of a gyro at rest while its temperature changed, leaves out what is not drift (start-up, spikes, times at
/// which the unit was moved), averages what is left over about 10 s, fits a curve for each rate column, and says what
/// the log is good for. How far to trust the curve is told by the held-out residual: each eighth of the log, predicted
/// by a fit of the other seven.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Fit {
    /// The unit's serial number, for the calibration
    #[arg(long)]
    serial: Option<String>,

    /// Write the calibration here, as JSON; a rejected log writes none
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Write a report here, as one HTML page; a rejected log writes none
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,

    /// Print JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,

    // The last: its heading would stand over what follows.
    #[command(flatten)]
    log: LogArguments,
}

const EXAMPLES: &str = "\
Examples:
  zerorate fit log.csv
      look at a log; nothing is written
  zerorate fit log.csv --out calibration.json --report report.html
  zerorate fit imu.tsv --temperature imu.temp --rate gx,gy,gz --rate-unit dps
      where the columns' names do not make it plain
  zerorate fit log.parquet --model poly:3 --plain --json
      the cubic that numpy.polyfit gives, as JSON

Exit codes: 0 fitted; 1 the log was rejected, with reasons; 2 error.";

impl Fit {
    pub fn run(&self) -> Result<Outcome> {
        let log = self.log.file.as_path();
        for (option, path) in [("--out", &self.out), ("--report", &self.report)] {
            if let Some(path) = path {
                output::check(option, path, &[log])?;
            }
        }
        let busy = Busy::reading(log);
        let fit = fit_log(log, &self.log.options())?;
        let written = if fit.judgement.rejected() { Vec::new() } else { self.write(&fit)? };
        drop(busy);
        if self.json {
            fit.notes.iter().for_each(|note| screen::note(note));
            screen::print_json(&fit)?;
        } else {
            summary::page(&fit, self.log.over(), &written, &self.next(&fit)).print()?;
        }
        Ok(if fit.judgement.rejected() { Outcome::Rejected } else { Outcome::Done })
    }

    /// Writes what was asked for and says what was written. The calibration comes last: where it is, all is.
    fn write(&self, fit: &LogFit) -> Result<Vec<PathBuf>> {
        let mut written = Vec::new();
        let calibration = self.out.as_ref().map(|_| self.calibration(fit)).transpose()?;
        if let Some(path) = &self.report {
            let mut report = LogReport::from(fit);
            report.next_command = self.out.as_ref().map(|out| apply_command(out, &self.log.file));
            output::write(path, &report.to_html())?;
            written.push(path.clone());
        }
        if let Some((path, calibration)) = self.out.as_ref().zip(calibration) {
            calibration.write(path)?;
            written.push(path.clone());
        }
        Ok(written)
    }

    fn calibration(&self, fit: &LogFit) -> Result<Calibration> {
        let source = Source::of_file("log", &self.log.file)?;
        Ok(Calibration::of_log(fit, self.log.over(), source, self.serial.clone())?)
    }

    /// What to type next, and why.
    fn next(&self, fit: &LogFit) -> Option<(&'static str, String)> {
        match &self.out {
            _ if fit.judgement.rejected() => None,
            Some(out) => Some(("To correct a log by it", apply_command(out, &self.log.file))),
            // The same command again, whatever options it had.
            None if self.report.is_some() => Some(("To keep the calibration", typed() + " --out calibration.json")),
            None => Some((
                "To keep the calibration, and to see it drawn",
                typed() + " --out calibration.json --report report.html",
            )),
        }
    }
}

fn apply_command(calibration: &Path, log: &Path) -> String {
    format!("zerorate apply {} {} --out corrected.csv", output::argument(calibration), output::argument(log))
}

/// The command as it was typed.
fn typed() -> String {
    let arguments = std::env::args_os().skip(1).map(|argument| output::argument(Path::new(&argument)));
    std::iter::once("zerorate".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}
