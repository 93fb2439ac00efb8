//! What a compensation test shows, in numbers.

use zerorate_board_run::summary::TestResult;
use zerorate_core::compensate::{Mode, StaticLaw};
use zerorate_core::drift::{Scale, Shape};
use zerorate_core::units::{Axis, TemperatureCode};
use zerorate_fit::least_squares::{Basis, Fit};

use crate::procedure::compensation_test::TestRun;
use crate::run::{Phase, Taken};
use crate::steps::largest_step;

/// Ramps whose ends are nearer than this share of the way were between the same temperatures: two in the same chamber differ
/// by a hundredth.
const SAME_ENDS: f64 = 0.02;

/// Smallest and largest.
pub(crate) fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], v| [least.min(v), most.max(v)])
}

/// Largest less smallest.
#[must_use]
pub fn peak_to_peak(values: impl Iterator<Item = f64>) -> f64 {
    let [least, most] = extremes(values);
    most - least
}

/// Mean and rms about it.
#[must_use]
pub fn mean_and_rms(values: &[f64]) -> (f64, f64) {
    #[allow(clippy::cast_precision_loss)]
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (mean, (squares / n).sqrt())
}

/// The zero-rate output of ramps without compensation in one direction, counts peak to peak; `None` where they have none
/// in it.
#[must_use]
pub fn drift_pp(ramps: &[Taken], axis: Axis, direction: Phase) -> Option<f64> {
    let mut readings = ramps.iter().filter(|taken| taken.phase == direction).map(|taken| taken.zro(axis).0).peekable();
    readings.peek().is_some().then(|| peak_to_peak(readings))
}

/// The results of a test's directions. `law` is the compensated axis's law in f64, `full` the ramps of the
/// full-temperature test, `held_to` how near a chamber is held to its set point, counts.
#[must_use]
pub fn evaluate(test: &TestRun, law: &StaticLaw, full: &[Taken], held_to: f64) -> Vec<TestResult> {
    let judge = Judge { test, law, full, held_to, quadratic: plain_quadratic(full, test.axis) };
    [(&test.heating, Phase::Heating), (&test.cooling, Phase::Cooling)]
        .into_iter()
        .filter(|(ramp, _)| !ramp.is_empty())
        .map(|(ramp, direction)| judge.one_direction(ramp, direction))
        .collect()
}

/// The paper's own model of the ramps: a quadratic by least squares, whatever was chosen for the unit.
fn plain_quadratic(ramps: &[Taken], axis: Axis) -> Option<Shape> {
    let [coldest, hottest] = extremes(ramps.iter().map(|taken| taken.temperature(axis).0));
    let mut fit = Fit::new(Scale::spanning(coldest, hottest)?, Basis::Powers(2));
    ramps.iter().for_each(|taken| fit.push(taken.temperature(axis).0, taken.zro(axis).0));
    fit.finish().ok()?.shape()
}

/// What a test is held against.
struct Judge<'a> {
    test: &'a TestRun,
    law: &'a StaticLaw,
    full: &'a [Taken],
    held_to: f64,
    quadratic: Option<Shape>,
}

impl Judge<'_> {
    fn one_direction(&self, ramp: &[Taken], direction: Phase) -> TestResult {
        let Self { test, law, full, held_to, quadratic } = self;
        let [coldest, hottest] = temperatures(*full, test.axis);
        let axis = test.axis;
        let left_by = |curve: &Shape| {
            let left = untrimmed(ramp, axis, law).zip(ramp);
            peak_to_peak(left.map(|(reading, taken)| reading - curve.evaluate(taken.temperature(axis).0)))
        };
        let corrected: Vec<f64> = ramp.iter().map(|taken| taken.corrected(axis).0).collect();
        let (mean_counts, residual_rms_counts) = mean_and_rms(&corrected);
        let jumps: Vec<f64> = ramp.iter().map(|taken| taken.jumps[axis.index()]).collect();
        let moved: Vec<bool> = ramp.iter().map(|taken| taken.report.axes[axis.index()].moved_to.is_some()).collect();
        TestResult {
            mode: test.mode,
            axis,
            control: axis.other(),
            direction,
            residual_pp_counts: peak_to_peak(corrected.iter().copied()),
            residual_rms_counts,
            uncompensated_pp_counts: uncompensated_pp(&way(full, direction), ramp, axis, law),
            temperature_counts: Some(temperatures(ramp, axis)),
            outside: Some(share_outside(ramp, axis, [coldest - held_to, hottest + held_to])),
            quadratic_pp_counts: quadratic.as_ref().map(left_by),
            control_pp_counts: peak_to_peak(ramp.iter().map(|taken| taken.zro(axis.other()).0)),
            floor_pp_counts: floor(ramp, axis),
            wiper_writes: u32::try_from(moved.iter().filter(|&&moved| moved).count()).unwrap_or(u32::MAX),
            taps_crossed: taps_crossed(ramp, axis, test.mode, law),
            mean_counts,
            largest_step_counts: largest_step(&jumps, &moved),
        }
    }
}

/// The ramps that go in one direction.
fn way(ramps: &[Taken], direction: Phase) -> Vec<&Taken> {
    ramps.iter().filter(|taken| taken.phase == direction).collect()
}

/// The least and greatest temperature of groups, counts.
fn temperatures<'a>(groups: impl IntoIterator<Item = &'a Taken>, axis: Axis) -> [f64; 2] {
    extremes(groups.into_iter().map(|taken| taken.temperature(axis).0))
}

/// What the axis does without compensation over the temperatures of a test's ramp, counts peak to peak: what was measured
/// between the same ends, else the test's own. Counts of one range say nothing of another.
fn uncompensated_pp(full: &[&Taken], ramp: &[Taken], axis: Axis, law: &StaticLaw) -> f64 {
    let [cold, hot] = temperatures(full.iter().copied(), axis);
    let [own_cold, own_hot] = temperatures(ramp, axis);
    let near = SAME_ENDS * (hot - cold);
    if !full.is_empty() && (own_cold - cold).abs() <= near && (own_hot - hot).abs() <= near {
        peak_to_peak(full.iter().map(|taken| taken.zro(axis).0))
    } else {
        peak_to_peak(untrimmed(ramp, axis, law))
    }
}

/// The share of groups outside of a range of temperatures.
#[allow(clippy::cast_precision_loss)]
fn share_outside(ramp: &[Taken], axis: Axis, [cold, hot]: [f64; 2]) -> f64 {
    let outside = ramp.iter().filter(|taken| !(cold..=hot).contains(&taken.temperature(axis).0)).count();
    outside as f64 / ramp.len() as f64
}

/// What a compensated axis would have read at the middle tap: the effect of its taps taken away.
fn untrimmed(ramp: &[Taken], axis: Axis, law: &StaticLaw) -> impl Iterator<Item = f64> {
    let effect = move |taken: &Taken| law.trim.effect(taken.report.axes[axis.index()].tap).0;
    ramp.iter().map(move |taken| taken.zro(axis).0 - effect(taken))
}

/// Group means less the plant's own drift and wiper, peak to peak.
fn floor(ramp: &[Taken], axis: Axis) -> Option<f64> {
    let unexplained = |taken: &Taken| {
        let truth = &taken.truth.as_ref()?.axes[axis.index()];
        Some(taken.zro(axis).0 - truth.drift_counts - truth.wiper_counts)
    };
    let left: Option<Vec<f64>> = ramp.iter().map(unexplained).collect();
    left.map(|left| peak_to_peak(left.into_iter()))
}

/// How often the noise-free law changes the tap along the plant's true temperature, from the tap that the ramp's first
/// group was taken at.
fn taps_crossed(ramp: &[Taken], axis: Axis, mode: Mode, law: &StaticLaw) -> Option<u32> {
    let first = ramp.first()?;
    if first.truth.is_some() && !matches!(mode, Mode::Trim | Mode::Hybrid) {
        return Some(0);
    }
    let mut tap = first.report.axes[axis.index()].tap;
    let mut crossed = 0;
    for taken in ramp {
        let truth = taken.truth.as_ref()?;
        let code: TemperatureCode = law.temperature_scale.code(truth.axes[axis.index()].temperature_counts)?;
        let next = law.next(tap, code);
        crossed += u32::from(next != tap);
        tap = next;
    }
    Some(crossed)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use zerorate_core::drift::{Coverage, Drift, Polynomial, ValidRange};
    use zerorate_core::group::GroupSums;
    use zerorate_core::trim::{Trim, TrimLine};
    use zerorate_core::units::{Counts, GroupNumber, Seconds, Taps, TemperatureScale};
    use zerorate_core::wire::{AxisReport, GroupReport};

    /// Fifty groups of a heating ramp between two temperatures, a count of drift to ten of temperature, one tap up.
    fn ramp(from: u16, to: u16, tap: u16) -> Vec<Taken> {
        ramp_of(50, from, to, tap)
    }

    /// The same of so many groups.
    pub(crate) fn ramp_of(groups: u16, from: u16, to: u16, tap: u16) -> Vec<Taken> {
        let group = |number: u16| {
            let along = u32::from(to - from) * u32::from(number) / u32::from(groups - 1);
            let temperature = from + u16::try_from(along).unwrap();
            let mut sums = GroupSums::default();
            sums.push(temperature, 8000 + temperature / 10 + 31 * (tap - 511));
            let axis = AxisReport {
                sums,
                tap: Taps::new(tap).unwrap(),
                mode: Mode::Trim,
                corrected_q16: 0,
                coverage: Coverage::Inside,
                saturated: false,
                moved_to: None,
                temperature: Default::default(),
                trim_failed: false,
            };
            let number = u32::from(number);
            let axes = [axis.clone(), axis];
            let report = GroupReport { group: GroupNumber(number), lost: 0, acquisition_errors: 0, axes };
            let time = Seconds(f64::from(number));
            Taken { report, time, phase: Phase::Heating, jumps: [f64::NAN; 2], truth: None }
        };
        (0..groups).map(group).collect()
    }

    #[test]
    fn a_test_between_other_temperatures_is_held_against_the_drift_between_those() {
        let scale = Scale::spanning(8500.0, 9480.0).unwrap();
        let drift = Drift {
            shape: Shape::Polynomial(Polynomial::new(scale, &[8899.0, 49.0]).unwrap()),
            valid: ValidRange::new(8500.0, 9480.0).unwrap(),
        };
        let line = TrimLine::new(-1.0 / 31.0, 0.0, Counts(8899.0), Taps::MIDDLE).unwrap();
        let law = StaticLaw {
            drift,
            trim: Trim { line, measured: None },
            dead_band: 0.05,
            temperature_scale: TemperatureScale { zero: 0.0, step: 1.0 },
        };
        // The test begins a third of a kelvin below, as near as a chamber is held.
        let full = ramp(8510, 9490, 511);
        for (to, drifts, outside) in [(9480, 98.0, 0.0), (11_930, 343.0, 0.7)] {
            let heating = ramp(8500, to, 513);
            let test = TestRun { mode: Mode::Trim, axis: Axis::X, heating, cooling: Vec::new() };
            let result = &evaluate(&test, &law, &full, 17.0)[0];
            // A count of drift to ten of temperature; readings are whole counts.
            assert!((result.uncompensated_pp_counts - drifts).abs() <= 1.0, "{result:?}");
            assert_eq!(result.temperature_counts.map(|ends| ends.map(f64::round)), Some([8500.0, f64::from(to)]));
            assert!((result.outside.unwrap() - outside).abs() < 0.03, "{result:?}");
        }
    }
}
