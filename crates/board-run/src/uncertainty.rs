//! The uncertainty budget of a compensated board, after the GUM (JCGM 100:2008): from its recordings, and from nothing that
//! only a simulated bench knows.
//!
//! The quantity is the zero-rate output of the compensated unit less the centre, the mean of one group: at any temperature of
//! the measured range, passed at the rate of the ramp, as often rising as falling, after another switch-on. Its estimate is 0:
//! nothing is corrected for what the tests show, so their mean counts as an error too.

mod left;
mod statistics;

use statrs::distribution::{ContinuousCDF, StudentsT};
use zerorate_core::compensate::Mode;
use zerorate_core::units::Axis;

use self::left::AxisTests;
use self::statistics::{Bins, Direction};
use crate::folder::BoardRun;

/// The coverage factor of every expanded uncertainty: 95 % of a normal distribution.
pub const COVERAGE_FACTOR: f64 = 2.0;

/// How a standard uncertainty was evaluated (GUM, 4.2 and 4.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Evaluation {
    /// By statistics of what was measured.
    A,
    /// By other knowledge.
    B,
}

/// Where an uncertainty comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The noise of one group's mean.
    Noise,
    /// What differs from the fitted ramp to a test at another switch-on.
    Repeatability,
    /// What differs between a rising and a falling temperature.
    Gradient,
    /// The width of a tap.
    Tap,
    /// By how much the wiper moves late, so that it does not chatter.
    DeadBand,
    /// The step of the temperature that the law sees, on the steepest slope.
    Temperature,
    /// The count of the A/D converter.
    Converter,
}

/// What is known of a contribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    /// Its standard uncertainty, counts.
    Known(f64),
    /// It is in the noise of the groups and counted there.
    InNoise,
    /// Nothing was measured that tells it.
    NotMeasured,
}

/// One row of a budget.
#[derive(Debug, Clone, PartialEq)]
pub struct Contribution {
    /// Where it comes from.
    pub source: Source,
    /// How it was evaluated.
    pub evaluation: Evaluation,
    /// Its standard uncertainty.
    pub part: Part,
    /// How many independent values it rests on, where they are few: its degrees of freedom, for none is lost to a mean.
    pub few: Option<usize>,
    /// On what it rests, a sentence without a full stop.
    pub told: String,
}

impl Contribution {
    /// Its standard uncertainty, counts; 0 where it has none of its own.
    #[must_use]
    pub fn counts(&self) -> f64 {
        if let Part::Known(counts) = self.part { counts } else { 0.0 }
    }
}

/// The budget of one axis in one mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    /// The axis.
    pub axis: Axis,
    /// The mode of its compensation.
    pub mode: Mode,
    /// The contributions, which are taken to be independent.
    pub contributions: Vec<Contribution>,
}

impl Budget {
    /// The combined standard uncertainty, counts: the root of the sum of squares (GUM, 5.1.2).
    #[must_use]
    pub fn combined_counts(&self) -> f64 {
        self.contributions.iter().map(|part| part.counts() * part.counts()).sum::<f64>().sqrt()
    }

    /// The expanded uncertainty U, counts (GUM, 6.2).
    #[must_use]
    pub fn expanded_counts(&self) -> f64 {
        COVERAGE_FACTOR * self.combined_counts()
    }

    /// The effective degrees of freedom by Welch and Satterthwaite (GUM, G.4.1); infinite where nothing rests on few values.
    #[must_use]
    pub fn degrees_of_freedom(&self) -> f64 {
        let fourth = |counts: f64| counts * counts * counts * counts;
        #[allow(clippy::cast_precision_loss)] // a few
        let of_row = |row: &Contribution| row.few.map_or(0.0, |few| fourth(row.counts()) / few as f64);
        fourth(self.combined_counts()) / self.contributions.iter().map(of_row).sum::<f64>()
    }

    /// The share of all cases that U holds, 0 to 1: by Student's distribution of so many degrees of freedom (GUM, G.3), by the
    /// normal one where they are many.
    #[must_use]
    pub fn held(&self) -> f64 {
        // The whole number below (GUM, G.4.1); a million is as good as infinite.
        let freedom = self.degrees_of_freedom().floor().clamp(1.0, 1e6);
        StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |student| 2.0 * student.cdf(COVERAGE_FACTOR) - 1.0)
    }
}

/// The budgets of a run: X, then Y, each in the modes that it was tested in, trim first. An axis without a heating test has
/// none.
#[must_use]
pub fn budgets(run: &BoardRun) -> Vec<Budget> {
    Axis::BOTH.into_iter().flat_map(|axis| of_axis(run, axis)).collect()
}

fn of_axis(run: &BoardRun, axis: Axis) -> Vec<Budget> {
    let Some(tests) = AxisTests::of(run, axis) else { return Vec::new() };
    let Some(noise) = statistics::noise(tests.ramps()) else { return Vec::new() };
    let bins = Bins::over(tests.measured, noise);
    let Some(repeated) = bins.repeatability(tests.heating()) else { return Vec::new() };
    let alike = [
        contribution(
            Source::Noise,
            Evaluation::A,
            Part::Known(noise),
            "second differences of what is left of successive groups in the tests".into(),
        ),
        Contribution {
            few: Some(repeated.ramps),
            ..contribution(
                Source::Repeatability,
                Evaluation::A,
                Part::Known(repeated.counts),
                format!(
                    "what curve and taps leave of {} heating ramps: rms in {} parts of the range, less noise; {}",
                    repeated.ramps,
                    Bins::COUNT,
                    match run.was_switched() {
                        Some(true) => "of the switch-on too, for the power was switched between them",
                        Some(false) => "not of the switch-on, for the power was left on",
                        None => "of the switch-on too where the power was switched between them",
                    }
                ),
            )
        },
        gradient(run, &tests, &bins, repeated.counts),
        temperature(&tests),
        converter(&tests),
    ];
    let of_mode = |mode| {
        let of_trim = if mode == Mode::Trim { vec![tap(&tests), dead_band(&tests)] } else { Vec::new() };
        let contributions = alike.iter().cloned().chain(of_trim).collect();
        Budget { axis, mode, contributions }
    };
    tests.modes().into_iter().map(of_mode).collect()
}

fn contribution(source: Source, evaluation: Evaluation, part: Part, told: String) -> Contribution {
    Contribution { source, evaluation, part, few: None, told }
}

/// From heating and cooling in one test; where no test cools, from the soaks beside the ramp.
fn gradient(run: &BoardRun, tests: &AxisTests, bins: &Bins, repeatability: f64) -> Contribution {
    let of = |part, told| contribution(Source::Gradient, Evaluation::A, part, told);
    if let Some(Direction { counts, ramps }) = bins.direction(&tests.runs) {
        let told = format!(
            "cooling less heating of {ramps} tests at equal temperature, rms less noise, over the root of 2: half of all passes are cooling"
        );
        return Contribution { few: Some(ramps), ..of(Part::Known(counts), told) };
    }
    let soaks = run.summary.soaks.as_ref().and_then(|soaks| soaks.axes.get(tests.axis.name()));
    match soaks.and_then(|soaks| statistics::soaks(&soaks.points, repeatability)) {
        Some(counts) => of(
            Part::Known(counts),
            "soaks less the ramp's curve, rms less repeatability; no test cools, so a falling temperature is not covered"
                .into(),
        ),
        None => {
            of(Part::NotMeasured, "no test cools and no soak was held: U is of a rising temperature alone".into())
        }
    }
}

/// Of the law's own form of temperature: a code is a step, and a temperature lies anywhere in it.
fn temperature(tests: &AxisTests) -> Contribution {
    let told = format!("rectangular: a step of {} count times the steepest slope, over the root of 12", tests.step);
    contribution(
        Source::Temperature,
        Evaluation::B,
        Part::Known(tests.step * tests.steepest_slope() / 12.0_f64.sqrt()),
        told,
    )
}

/// The wiper stands on whole taps, so what is left goes through a tap's width between two of them. The effect of taps is taken
/// off before the repeatability is told, so it is in no other row.
fn tap(tests: &AxisTests) -> Contribution {
    let told = format!("rectangular: a tap of {:.2} counts, over the root of 12", tests.counts_per_tap);
    contribution(Source::Tap, Evaluation::B, Part::Known(tests.counts_per_tap / 12.0_f64.sqrt()), told)
}

/// A wiper that moves late is off by the dead band all the way, to the side that the temperature came from.
fn dead_band(tests: &AxisTests) -> Contribution {
    let counts = tests.dead_band_taps * tests.counts_per_tap;
    let told =
        format!("two values: the wiper moves {} tap late, so {counts:.2} counts to either side", tests.dead_band_taps);
    contribution(Source::DeadBand, Evaluation::B, Part::Known(counts), told)
}

/// Samples that scatter over several counts average to any value between them, and what their rounding adds is in the noise.
fn converter(tests: &AxisTests) -> Contribution {
    let scatter = tests.sample_scatter();
    let of = |part, told| contribution(Source::Converter, Evaluation::B, part, told);
    if scatter >= 0.5 {
        return of(
            Part::InNoise,
            format!("in the noise: samples scatter by {scatter:.1} counts rms, so a group's mean is no whole count"),
        );
    }
    of(Part::Known(1.0 / 12.0_f64.sqrt()), "rectangular: a count, over the root of 12".into())
}

#[cfg(test)]
mod tests;
