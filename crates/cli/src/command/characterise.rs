//! `zerorate characterise`.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;
use zerorate_cal::calibration::Calibration;
use zerorate_cal::fit::fit;
use zerorate_cal::log::SensorChoice;
use zerorate_cal::log_fit::{AxisFit, FitOptions};
use zerorate_cal::quality::{Reason, ReasonKind};
use zerorate_cal::recording::Recording;
use zerorate_cal::source::Source;
use zerorate_cal::table::Columns;
use zerorate_cal::units::{RateUnit, decimal, from_to};
use zerorate_characterise::{
    AxisNoise, Characteristics, NoiseOf, is_of_a_soak, noise, told_of_noise, told_of_sensitivities,
};
use zerorate_fit::allan::{Allan, Coefficient};

use super::Outcome;
use crate::log_arguments::ColumnArguments;
use crate::progress::Busy;
use crate::screen::{self, Grid, Page, three_digits};

/// Tell a sensor's noise, hysteresis and sensitivities from a log
///
/// The noise is told by the overlapping Allan deviation, sample by sample (a log of more than 131 072 rows is first averaged by
/// twos, fours and so on) and without spikes, of the longest soak in the log (constant temperature), or with a calibration of
/// what that leaves of the whole log; on a ramp it is refused, for there it would show the drift. Hysteresis and sensitivities
/// are told where the log holds both directions and several speeds of the temperature. Names are those of IEEE Std 952 and 528.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Characterise {
    /// The log, of any kind that fit reads
    #[arg(value_name = "LOG")]
    log: PathBuf,

    /// Take the noise of what this calibration leaves of the log
    #[arg(long = "with", value_name = "CALIBRATION")]
    calibration: Option<PathBuf>,

    /// These sensors alone: gyro, accel, gyro0 or another number, or a part's device id
    #[arg(long, value_name = "SENSOR")]
    sensor: Option<SensorChoice>,

    /// Print JSON on standard output, with the curves, and nothing else there
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    columns: ColumnArguments,
}

const EXAMPLES: &str = "\
Examples:
  zerorate characterise at-rest.ulg
  zerorate characterise chamber.csv --with calibration.json
  zerorate characterise at-rest.bin --sensor gyro --json

Exit codes: 0 something was told; 1 the log holds neither noise nor sensitivities, with reasons; 2 error.";

/// What was found, as JSON has it.
#[derive(Serialize)]
struct Found<'a> {
    schema: u32,
    noise: &'a [AxisNoise],
    sensitivities: Vec<Sensitivities<'a>>,
    /// What is to be known of both, a sentence each.
    warnings: Vec<String>,
    reasons: Vec<&'a Reason>,
}

#[derive(Serialize)]
struct Sensitivities<'a> {
    axis: &'a str,
    rate_unit: RateUnit,
    #[serde(flatten)]
    found: &'a Characteristics,
}

impl Characterise {
    pub fn run(&self) -> Result<Outcome> {
        let calibration = self.calibration.as_ref().map(|file| Calibration::read(&file.into())).transpose()?;
        let busy = Busy::reading(&self.log);
        let columns = self.columns.columns();
        let log = Source::from(&self.log);
        if columns == Columns::default() && Recording::is_one(&log) {
            let recording = Recording::read(&log)?;
            if !recording.rows.iter().any(|row| row.phase.is_ramp()) {
                bail!("{}: {}", self.log.display(), recording.without_a_ramp());
            }
        }
        let noises = noise(&log, &columns, self.sensor, calibration.as_ref())?;
        // A log of one temperature has no sensitivities, and its fit says why.
        let options = FitOptions { columns, sensor: self.sensor, allow_narrow: true, ..FitOptions::default() };
        let fit = fit(&[log], &options)?;
        let warmed = || fit.axes.iter().filter(|axis| !is_of_a_soak(axis));
        let sensitivities: Vec<(&AxisFit, Characteristics)> =
            warmed().map(|axis| (axis, Characteristics::of(axis, None))).collect();
        drop(busy);
        // That a soak spans little is no fault of one, but why there are no sensitivities.
        let is_told = |reason: &&Reason| match reason.kind {
            ReasonKind::NarrowSpan => sensitivities.is_empty(),
            ReasonKind::WorseThanUncorrected => !sensitivities.is_empty(),
            _ => true,
        };
        let reasons: Vec<&Reason> = fit.judgement.reasons.iter().filter(is_told).collect();
        let told = !sensitivities.is_empty() || noises.iter().any(|axis| axis.noise.is_ok());
        let of_sensitivities = || told_of_sensitivities(sensitivities.iter().map(|(axis, found)| (*axis, found)), None);
        if self.json {
            let warnings = told_of_noise(&noises).into_iter().chain(of_sensitivities()).collect();
            let sensitivities = sensitivities
                .iter()
                .map(|(axis, found)| Sensitivities { axis: &axis.name, rate_unit: axis.calibration.rate_unit, found })
                .collect();
            screen::print_json(&Found { schema: 1, noise: &noises, sensitivities, warnings, reasons })?;
        } else {
            let mut page = Page::default();
            page.sentence("", &format!("{}:", self.log.display()));
            let degree = fit.axes.first().map_or("C", |axis| axis.temperature_unit.name());
            noise_page(&mut page, &noises, degree);
            sensitivity_page(&mut page, &sensitivities, degree);
            of_sensitivities().iter().for_each(|sentence| page.sentence("  - ", sentence));
            if !reasons.is_empty() {
                page.heading(if sensitivities.is_empty() { "Sensitivities" } else { "To look at in the log" });
                let is_soak = |reason: &Reason| reason.kind == ReasonKind::NarrowSpan && !fit.axes.is_empty();
                for reason in &reasons {
                    page.sentence("  - ", if is_soak(reason) { OF_A_SOAK } else { &reason.text });
                }
            }
            page.print()?;
        }
        Ok(if told { Outcome::Done } else { Outcome::Rejected })
    }
}

const OF_A_SOAK: &str =
    "none are told: the temperature differs by no more than in a soak; let it warm and cool by 10 C or more";

/// Units that people compare gyros in: degrees and hours; of others the log's own.
struct Usual {
    walk: (f64, String),
    bias: (f64, String),
    rate_walk: (f64, String),
}

impl Usual {
    fn of(unit: RateUnit) -> Self {
        let degrees = match unit {
            RateUnit::RadPerS => Some(1.0_f64.to_degrees()),
            RateUnit::Dps => Some(1.0),
            RateUnit::Counts | RateUnit::MetresPerS2 => None,
        };
        match degrees {
            Some(degrees) => Self {
                walk: (degrees * 60.0, "deg/rt-h".to_owned()),
                bias: (degrees * 3600.0, "deg/h".to_owned()),
                rate_walk: (degrees * 3600.0 * 60.0, "deg/h/rt-h".to_owned()),
            },
            None => Self {
                walk: (1.0, format!("{unit} rt-s")),
                bias: (1.0, unit.to_string()),
                rate_walk: (1.0, format!("{unit}/rt-s")),
            },
        }
    }
}

fn noise_page(page: &mut Page, noises: &[AxisNoise], degree: &str) {
    let heading = match noises.first().map(|axis| axis.of) {
        Some(NoiseOf::Residual) => "Noise of what the calibration leaves",
        _ => "Noise of the longest soak",
    };
    page.heading(heading);
    let mut grid = Grid::new("lrrrr");
    grid.head(["axis", "angle random walk N", "bias instability B", "rate random walk K", "samples"]);
    let mut any = false;
    for axis in noises {
        let Ok(allan) = &axis.noise else { continue };
        any = true;
        let usual = Usual::of(axis.rate_unit);
        let Allan { coefficients, samples, .. } = allan;
        grid.row([
            axis.name.clone(),
            cell(&coefficients.angle_random_walk, &usual.walk),
            cell(&coefficients.bias_instability, &usual.bias),
            cell(&coefficients.rate_random_walk, &usual.rate_walk),
            screen::thousands(*samples),
        ]);
    }
    if any {
        page.grid(&grid);
        for axis in noises.iter().filter(|axis| axis.noise.is_ok()).take(1) {
            let ([from, to], [min, max]) = (axis.time_s, axis.temperature);
            page.gap();
            page.sentence(
                "  ",
                &format!(
                    "From {from:.0} to {to:.0} s, {} {degree}. In brackets the 95 % confidence; < where other noise \
                     or a trend hides it.",
                    from_to(min, max)
                ),
            );
        }
    }
    told_of_noise(noises).iter().for_each(|sentence| page.sentence("  - ", sentence));
}

fn cell(coefficient: &Coefficient, (factor, unit): &(f64, String)) -> String {
    match coefficient {
        Coefficient::Seen { value, low, high, .. } => {
            let [value, low, high] = [value, low, high].map(|value| three_digits(value * factor));
            format!("{value} ({low} to {high}) {unit}")
        }
        Coefficient::Hidden { at_most } => format!("< {} {unit}", three_digits(at_most * factor)),
    }
}

/// A standard error; nothing where it is not known, or where nothing scatters.
fn or_unknown(error: f64) -> String {
    if error.is_finite() && error > 0.0 { format!(" +- {error:.0e}") } else { String::new() }
}

fn sensitivity_page(page: &mut Page, axes: &[(&AxisFit, Characteristics)], degree: &str) {
    if axes.is_empty() {
        return;
    }
    page.heading(&format!(
        "Sensitivities of the bias, per {degree}, of the straight line nearest to its curve and where that is steepest; thermal hysteresis, mean and largest; ramp, per {degree}/s"
    ));
    let mut grid = Grid::new("lrrrrl");
    grid.head(["axis", "straight line", "steepest", "hysteresis", "ramp", "unit"]);
    for (axis, found) in axes {
        let slope = found.temperature_sensitivity;
        let ramp = found.ramp_sensitivity.as_ref();
        grid.row([
            axis.name.clone(),
            format!("{:.2e}{}", slope.mean, or_unknown(slope.mean_standard_error)),
            format!(
                "{:.2e}{} at {}",
                slope.steepest,
                or_unknown(slope.steepest_standard_error),
                decimal(slope.steepest_at, 0)
            ),
            found.hysteresis.as_ref().map_or("-".to_owned(), |found| {
                let share = Some(found.share).filter(|share| share.is_finite());
                let share = share.map(|share| format!(" ({:.0} %)", 100.0 * share)).unwrap_or_default();
                format!(
                    "{:.2e}{}; {:.2e}{} at {}{share}",
                    found.mean,
                    or_unknown(found.mean_standard_error),
                    found.largest,
                    or_unknown(found.standard_error),
                    decimal(found.at, 0)
                )
            }),
            ramp.map_or("-".to_owned(), |found| format!("{:.1e} +- {:.1e}", found.value, found.standard_error)),
            axis.calibration.rate_unit.to_string(),
        ]);
    }
    page.grid(&grid);
}
