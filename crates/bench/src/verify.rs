//! The proof: the composed record on the device, the same ramp again.

use zerorate_board_run::summary::{Check, TestResult};
use zerorate_cal::recording::Phase;
use zerorate_core::compensate::Mode;
use zerorate_core::units::Axis;

use crate::error::BenchError;
use crate::evaluate::evaluate;
use crate::measure::Measured;
use crate::procedure::compensation_test::{self, Extent, TestRun};
use crate::run::{Recorder, Session};
use crate::setup::{Limits, SetUp};
use crate::soaking::AT_SET_POINT;

/// One compensation test with its results.
#[derive(Debug, Clone)]
pub struct Verification {
    /// The groups.
    pub run: TestRun,
    /// Heating, then cooling where it was run.
    pub results: Vec<TestResult>,
}

impl Verification {
    /// The groups, and the least that is left in one of its ways, counts peak to peak.
    pub(crate) fn left(&self) -> (&TestRun, f64) {
        (&self.run, self.results.iter().map(|result| result.residual_pp_counts).fold(f64::INFINITY, f64::min))
    }
}

/// Puts the record on the device.
///
/// # Errors
/// [`BenchError`].
pub fn deploy(session: &mut Session<'_>, measured: &Measured) -> Result<(), BenchError> {
    // A person need not switch twice: the test that follows begins with that.
    if session.bench.power.obeys() {
        session.begin()?;
    }
    session.bench.device.deploy(&measured.record)?;
    Ok(())
}

/// Runs one compensation test and evaluates it. The device refuses a mode that the axis's law cannot run.
///
/// # Errors
/// [`BenchError`].
pub fn test(
    session: &mut Session<'_>,
    measured: &Measured,
    mode: Mode,
    axis: Axis,
    extent: Extent,
    recorder: &mut Recorder,
) -> Result<Verification, BenchError> {
    let setup = session.setup;
    compensation_test::run(session, &measured.ramp, mode, axis, extent, recorder)
        .map(|run| evaluated(run, measured, setup))
}

/// A test that was run, with its results.
#[must_use]
pub fn evaluated(run: TestRun, measured: &Measured, setup: &SetUp) -> Verification {
    let axis = run.axis;
    let law = measured.axes[axis.index()].law.static_law(measured.record.temperature_scale);
    let results = evaluate(&run, &law, &measured.ramp, AT_SET_POINT.0 * setup.board.counts_per_celsius);
    Verification { run, results }
}

/// Holds the heating tests against the limits. Cooling is reported as it is.
#[must_use]
pub fn check(results: &[&TestResult], limits: &Limits, centre_counts: f64) -> Vec<Check> {
    let heating = || results.iter().filter(|result| result.direction == Phase::Heating);
    let by_trim = |axis| heating().find(|result| (result.axis, result.mode) == (axis, Mode::Trim)).copied();
    heating().flat_map(|result| check_one(result, by_trim(result.axis), limits, centre_counts)).collect()
}

/// Counts, held against the most that they may be.
fn at_most(what: String, limit: f64, measured: f64) -> Check {
    let places = decimals(limit, measured);
    Check {
        what,
        limit: format!("at most {limit:.places$} counts"),
        measured: format!("{measured:.places$} counts"),
        passed: measured <= limit,
    }
}

/// As many decimals as tell a limit from zero and from what was measured, one at least: 40.04 of 40 is not 40.0 of 40.0.
fn decimals(limit: f64, measured: f64) -> usize {
    let written = |number: f64, places: usize| format!("{number:.places$}");
    let tell = |&places: &usize| {
        let of_limit = written(limit, places);
        (limit.total_cmp(&measured).is_eq() || of_limit != written(measured, places))
            && (limit == 0.0 || of_limit != written(0.0, places))
    };
    (1..6).find(tell).unwrap_or(1)
}

/// The checks of a test. `by_trim` is the same axis's by the potentiometer alone, where it was run.
fn check_one(result: &TestResult, by_trim: Option<&TestResult>, limits: &Limits, centre_counts: f64) -> Vec<Check> {
    let whose = format!("{} {}, heating", result.axis.name().to_uppercase(), result.mode.name());
    let mut checks = Vec::new();
    let mut hold =
        |what: &str, limit: f64, measured: f64| checks.push(at_most(format!("{whose}: {what}"), limit, measured));
    if result.mode == Mode::Trim {
        hold("residual, peak to peak", limits.trim_residual_pp_counts, result.residual_pp_counts);
    } else if let Some(floor) = result.floor_pp_counts {
        let limit = limits.hybrid_residual_floors * floor;
        hold("residual, peak to peak, against the floor", limit, result.residual_pp_counts);
    } else if let Some(trim) = by_trim {
        // On a real bench nobody knows the floor. What subtracts more must not leave more.
        hold("residual, peak to peak, against what trim leaves", trim.residual_pp_counts, result.residual_pp_counts);
    }
    let offset = (result.mean_counts - centre_counts).abs();
    hold("distance of the mean from the centre", limits.mean_offset_counts, offset);
    if let Some(crossed) = result.taps_crossed {
        checks.push(Check {
            what: format!("{whose}: wiper writes"),
            // One fewer is a tap at an end of the ramp, to which noise had brought the wiper before or not yet.
            limit: format!("at most the {crossed} taps crossed"),
            measured: format!("{} writes", result.wiper_writes),
            passed: result.wiper_writes <= crossed,
        });
    }
    checks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_measured_is_told_from_its_limit() {
        let told = |limit, measured| {
            let check = at_most(String::new(), limit, measured);
            (check.limit, check.measured, check.passed)
        };
        let strings = |limit: &str, measured: &str, passed| (limit.to_owned(), measured.to_owned(), passed);
        assert_eq!(told(40.0, 36.21), strings("at most 40.0 counts", "36.2 counts", true));
        assert_eq!(told(40.0, 40.004), strings("at most 40.000 counts", "40.004 counts", false));
        assert_eq!(told(0.02, 0.3), strings("at most 0.02 counts", "0.30 counts", false));
        assert_eq!(told(40.0, 40.0), strings("at most 40.0 counts", "40.0 counts", true));
    }

    #[test]
    fn a_write_more_than_taps_crossed_is_chatter_and_one_fewer_is_none() {
        let text = r#"{"mode":"trim","axis":"y","control":"x","direction":"heating","residual_pp_counts":30.0,
            "residual_rms_counts":1.0,"uncompensated_pp_counts":400.0,"control_pp_counts":400.0,"wiper_writes":22,
            "taps_crossed":22,"mean_counts":8200.0,"largest_step_counts":0.5}"#;
        let result: TestResult = serde_json::from_str(text).unwrap();
        for (wiper_writes, passes) in [(21, true), (22, true), (23, false)] {
            let result = TestResult { wiper_writes, ..result.clone() };
            let checks = check(&[&result], &Limits::default(), 8200.0);
            let writes = checks.iter().find(|check| check.what.ends_with("wiper writes")).unwrap();
            assert_eq!((writes.passed, writes.limit.as_str()), (passes, "at most the 22 taps crossed"));
        }
    }
}
