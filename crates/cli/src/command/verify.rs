//! `zerorate verify`.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use clap::Args;
use console::Style;
use serde::Serialize;
use zerorate_cal::calibration::{Calibration, Kind};
use zerorate_cal::source::{Source, in_quotes};
use zerorate_cal::table::Table;
use zerorate_cal::units::{RateUnit, WrittenRate};
use zerorate_cal::verify::{Limit, Limits, Verified, VerifiedAxis, verify};

use super::Outcome;
use crate::log_arguments::ColumnArguments;
use crate::progress::Busy;
use crate::screen::{self, Grid, Page, RateScale, aligned, style};

/// See what a calibration leaves of a log that it has not seen
///
/// Applies a calibration to the log of a second run and tells, for each axis, what was recorded and what is left, over
/// averages of about 10 s. With limits it passes or fails: exit code 1 says that the unit failed. The log that the
/// calibration was fitted on is refused, for it is no test.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Verify {
    /// The log of the second run, of any kind that fit reads
    #[arg(value_name = "LOG")]
    log: PathBuf,

    /// The calibration
    #[arg(long = "with", value_name = "CALIBRATION")]
    calibration: PathBuf,

    /// What may be left at most, root mean square about the mean: 0.5mrad/s, 0.02dps, 30deg/h, 12counts
    #[arg(long, value_name = "LIMIT", help_heading = "Limits")]
    max_rms: Option<Limit>,

    /// What may be left at most, peak to peak
    #[arg(long, value_name = "LIMIT", help_heading = "Limits")]
    max_pp: Option<Limit>,

    /// What the mean may be at most, without its sign
    #[arg(long, value_name = "LIMIT", help_heading = "Limits")]
    max_offset: Option<Limit>,

    /// Limits from a TOML file: max_rms = "0.5 mrad/s", max_pp, max_offset, and [axes.NAME] with the same for one axis
    #[arg(long, value_name = "FILE", help_heading = "Limits", conflicts_with_all = ["max_rms", "max_pp", "max_offset"])]
    limits: Option<PathBuf>,

    /// Take the log that the calibration was fitted on too: what is left is then in-sample, and proves nothing
    #[arg(long)]
    in_sample: bool,

    /// Print JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    columns: ColumnArguments,
}

const EXAMPLES: &str = "\
Examples:
  zerorate verify second.csv --with calibration.json
  zerorate verify second.ulg --with calibration.json --max-rms 1mrad/s --max-pp 5mrad/s
  zerorate verify second.bin --with calibration.json --limits limits.toml --json

Exit codes: 0 within the limits, or none were given; 1 a limit is missed, or the log is no good; 2 error.";

/// What was found, as JSON has it.
#[derive(Serialize)]
struct Found<'a> {
    schema: u32,
    #[serde(flatten)]
    verified: &'a Verified,
}

impl Verify {
    pub fn run(&self) -> Result<Outcome> {
        let calibration = Calibration::read(&(&self.calibration).into())?;
        if calibration.kind == Kind::AnalogueBoard {
            bail!(
                "{}: the calibration of an analogue board: its second run is part of zerorate calibrate",
                self.calibration.display()
            );
        }
        let limits = self.limits()?;
        limits.check(calibration.axes.keys().map(String::as_str))?;
        let log = Source::from(&self.log);
        let busy = Busy::reading(&self.log);
        let mut columns = self.columns.columns();
        columns.else_rate_unit = calibration.axes.values().find_map(|axis| WrittenRate::of(axis.rate_unit));
        if columns.rates.is_empty() {
            columns.rates = self.known_columns(&calibration);
        }
        let verified = verify(&log, &calibration, &columns, &limits, self.in_sample)?;
        drop(busy);
        if self.json {
            screen::print_json(&Found { schema: 1, verified: &verified })?;
        } else {
            page(&verified).print()?;
        }
        Ok(if verified.passed == Some(false) { Outcome::Rejected } else { Outcome::Done })
    }

    fn limits(&self) -> Result<Limits> {
        let Some(path) = &self.limits else {
            return Ok(Limits::for_all(self.max_rms.clone(), self.max_pp.clone(), self.max_offset.clone()));
        };
        let text = fs::read_to_string(path).with_context(|| format!("{}: cannot be read", path.display()))?;
        toml::from_str(&text).map_err(|error| {
            let line = error.span().map_or(1, |span| text[..span.start.min(text.len())].lines().count().max(1));
            anyhow::anyhow!("{}:{line}: {}", path.display(), in_quotes(error.message()))
        })
    }

    /// The calibration's axes as columns, where the log is a table that has them all.
    fn known_columns(&self, calibration: &Calibration) -> Vec<String> {
        let names: Vec<String> = calibration.axes.keys().cloned().collect();
        let table = Table::open(&(&self.log).into()).ok();
        let has_all = table.is_some_and(|table| names.iter().all(|name| table.names().contains(name)));
        if has_all { names } else { Vec::new() }
    }
}

fn page(verified: &Verified) -> Page {
    let mut page = Page::default();
    let (colour, word, meaning) = match verified.passed {
        None => (Style::new(), "measured", "no limits were given (--max-rms, --max-pp)"),
        Some(true) => (Style::new().green(), "passed", "all axes are within their limits"),
        Some(false) if !verified.missing.is_empty() => (Style::new().red(), "failed", "not all axes are there"),
        Some(false) => (Style::new().red(), "failed", "not all axes are within their limits"),
    };
    page.sentence("", &format!("{}: {}: {meaning}", verified.log, style(colour.bold(), word)));
    verified.missing.iter().for_each(|missing| page.sentence("  - ", missing));
    verified.axes.iter().flat_map(|axis| &axis.missed).for_each(|missed| page.sentence("  - ", missed));
    if verified.in_sample {
        page.sentence(
            "  - ",
            "this is the log that the calibration was fitted on: what is left is in-sample, and no test",
        );
    }
    verified.warnings.iter().for_each(|warning| page.sentence("  - ", warning));
    let mut units: Vec<RateUnit> = Vec::new();
    for axis in &verified.axes {
        if !units.contains(&axis.rate_unit) {
            units.push(axis.rate_unit);
        }
    }
    // Rates and accelerations are told apart: they have no scale in common.
    for rate_unit in units {
        let axes: Vec<&VerifiedAxis> = verified.axes.iter().filter(|axis| axis.rate_unit == rate_unit).collect();
        let sizes: Vec<f64> = axes.iter().map(|axis| axis.raw.pp).collect();
        let scale = RateScale::of(rate_unit, &sizes);
        page.heading(&format!(
            "Over {:.1} to {:.1} {}, in {}",
            axes.iter().map(|axis| axis.temperature[0]).fold(f64::INFINITY, f64::min),
            axes.iter().map(|axis| axis.temperature[1]).fold(f64::NEG_INFINITY, f64::max),
            verified.temperature_unit.name(),
            scale.unit()
        ));
        page.grid(&grid(&axes, scale));
    }
    if !verified.axes.is_empty() {
        page.gap();
        page.sentence(
            "  ",
            "Averages over about 10 s. rms is about the mean, which the start of another run sets anew; the mean that is \
             left stands under mean.",
        );
    }
    page
}

fn grid(axes: &[&VerifiedAxis], scale: RateScale) -> Grid {
    let column = |of: &dyn Fn(&VerifiedAxis) -> f64| {
        aligned(&axes.iter().map(|axis| scale.of_rate(of(axis))).collect::<Vec<_>>())
    };
    let columns = [
        column(&|axis| axis.raw.rms),
        column(&|axis| axis.raw.pp),
        column(&|axis| axis.corrected.rms),
        column(&|axis| axis.corrected.pp),
        column(&|axis| axis.offset),
        aligned(&axes.iter().map(|axis| axis.raw.rms / axis.corrected.rms).collect::<Vec<_>>()),
    ];
    let mut grid = Grid::new("lrrrrrr");
    grid.head(["", "recorded", "", "corrected", "", "", "times"]);
    grid.head(["axis", "rms", "pp", "rms", "pp", "mean", "better"]);
    for (place, axis) in axes.iter().enumerate() {
        grid.row([axis.name.clone()].into_iter().chain(columns.iter().map(|column| column[place].clone())));
    }
    grid
}
