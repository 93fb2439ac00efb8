//! Many units through the main job: what a design achieves, before a board is built.

use serde::{Serialize, Serializer};
use zerorate_board_run::summary::{Check, TestResult};
use zerorate_core::compensate::Mode;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::Axis;

use crate::error::BenchError;
use crate::measure::{first_time, measure};
use crate::plants::PlantKind;
use crate::procedure::compensation_test::Extent;
use crate::run::{Recorder, Session, Silent};
use crate::setup::SetUp;
use crate::simulated;
use crate::summary::cut_short;
use crate::verify::{check, deploy, test};

/// One unit of a study: its X axis, heating; counts peak to peak, held out but for the drift.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnitResult {
    /// Its number in the study.
    pub unit: u32,
    /// Zero-rate output over the ramp without compensation.
    pub drift_pp_counts: f64,
    /// What mode trim leaves; `None` where the wiper cannot follow.
    pub trim_residual_pp_counts: Option<f64>,
    /// What mode hybrid leaves; mode digital where the wiper cannot follow ([`mode`](Self::mode)).
    pub hybrid_residual_pp_counts: f64,
    /// In which mode that was.
    #[serde(serialize_with = "by_name")]
    pub mode: Mode,
    /// What noise alone makes.
    pub floor_pp_counts: f64,
    /// The drift model chosen.
    pub model: String,
    /// What was outside the set-up's limits, a sentence each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub failed_checks: Vec<String>,
    /// What to look at.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

fn by_name<S: Serializer>(mode: &Mode, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(mode.name())
}

/// A unit that could not be carried through, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnitRejected {
    /// Its number in the study.
    pub unit: u32,
    /// Why.
    pub reason: String,
}

/// Takes one unit through the measurement, the trim test and hybrid test.
///
/// # Errors
/// [`BenchError`], when it cannot be carried through.
pub fn unit(number: u32, plant: PlantKind, seed: u64, setup: &SetUp) -> Result<UnitResult, BenchError> {
    let serial = UnitSerial::new();
    let mut bench = simulated::bench(plant.build(seed), setup, &serial);
    let mut progress = Silent;
    let mut session = Session::new(&mut bench, setup, &mut progress);
    first_time(&mut session)?;
    let measured = measure(&mut session, &serial, Recorder::discarding(), Recorder::discarding())?;
    deploy(&mut session, &measured)?;
    let drift = &measured.axes[0];
    let follows = drift.digital_only.is_none();
    let mut heating = |mode| -> Result<TestResult, BenchError> {
        let extent = Extent { cooling: false, samples: false };
        let verification = test(&mut session, &measured, mode, Axis::X, extent, &mut Recorder::discarding())?;
        Ok(verification.results[0].clone())
    };
    let trim = follows.then(|| heating(Mode::Trim)).transpose()?;
    let hybrid = heating(if follows { Mode::Hybrid } else { Mode::Digital })?;
    let results: Vec<&TestResult> = trim.iter().chain([&hybrid]).collect();
    let checks = check(&results, &setup.limits, setup.board.centre_counts);
    Ok(UnitResult {
        unit: number,
        drift_pp_counts: drift.drift_pp_counts,
        trim_residual_pp_counts: trim.as_ref().map(|trim| trim.residual_pp_counts),
        hybrid_residual_pp_counts: hybrid.residual_pp_counts,
        mode: hybrid.mode,
        floor_pp_counts: hybrid.floor_pp_counts.unwrap_or(f64::NAN),
        failed_checks: checks.iter().filter(|check| !check.passed).map(Check::sentence).collect(),
        model: drift.drift.calibration.fit.chosen_model(),
        warnings: cut_short(&measured, setup).chain(measured.calibration.warnings.clone()).collect(),
    })
}

/// The seed of one unit of a study: units of one study differ, and those of two do not overlap by accident.
#[must_use]
pub fn seed_of(study: u64, unit: u32) -> u64 {
    study.wrapping_mul(1_000_003).wrapping_add(u64::from(unit))
}

/// Takes units `0..units` through, on as many threads as there are cores; `done` is told of each as it comes.
pub fn run(
    units: u32,
    plant: PlantKind,
    seed: u64,
    setup: &SetUp,
    done: &(dyn Fn() + Sync),
) -> Vec<Result<UnitResult, UnitRejected>> {
    let next = std::sync::atomic::AtomicU32::new(0);
    let results = std::sync::Mutex::new(Vec::with_capacity(units as usize));
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                    if number >= units {
                        break;
                    }
                    let result = unit(number, plant, seed_of(seed, number), setup)
                        .map_err(|error| UnitRejected { unit: number, reason: error.to_string() });
                    if let Ok(mut results) = results.lock() {
                        results.push((number, result));
                    }
                    done();
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_default();
    results.sort_by_key(|(number, _)| *number);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Quantiles of a study, counts peak to peak.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantiles {
    /// At these parts of the units.
    pub at: Vec<f64>,
    /// Without compensation.
    pub drift_pp_counts: Vec<f64>,
    /// Mode trim, of the units whose wiper can follow.
    pub trim_residual_pp_counts: Vec<f64>,
    /// Mode hybrid, of the same units.
    pub hybrid_residual_pp_counts: Vec<f64>,
    /// Mode hybrid in multiples of the floor.
    pub hybrid_residual_floors: Vec<f64>,
    /// The floor.
    pub floor_pp_counts: Vec<f64>,
}

impl Quantiles {
    /// The quantiles of a study's results.
    #[must_use]
    pub fn of(results: &[&UnitResult]) -> Self {
        let at = vec![0.0, 0.05, 0.25, 0.5, 0.75, 0.9, 0.95, 1.0];
        let quantiles = |values: Vec<f64>| quantiles(values, &at);
        let hybrid = || results.iter().filter(|unit| unit.mode == Mode::Hybrid);
        Self {
            drift_pp_counts: quantiles(results.iter().map(|r| r.drift_pp_counts).collect()),
            trim_residual_pp_counts: quantiles(results.iter().filter_map(|r| r.trim_residual_pp_counts).collect()),
            hybrid_residual_pp_counts: quantiles(hybrid().map(|r| r.hybrid_residual_pp_counts).collect()),
            hybrid_residual_floors: quantiles(
                hybrid().map(|r| r.hybrid_residual_pp_counts / r.floor_pp_counts).collect(),
            ),
            floor_pp_counts: quantiles(results.iter().map(|r| r.floor_pp_counts).collect()),
            at,
        }
    }
}

/// Quantiles, straight between the values on either side as numpy has them; empty for no values.
fn quantiles(mut values: Vec<f64>, at: &[f64]) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return Vec::new() };
    let quantile = |part: &f64| {
        let place = part * last as f64;
        // 0 to last.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let below = place as usize;
        let above = values[(below + 1).min(last)];
        values[below] + (place - below as f64) * (above - values[below])
    };
    at.iter().map(quantile).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_numpys() {
        // numpy.quantile([7, 1, 4, 2, 9, 3], [0, .05, .25, .5, .9, 1]), and of one value.
        let found = quantiles(vec![7.0, 1.0, 4.0, 2.0, 9.0, 3.0], &[0.0, 0.05, 0.25, 0.5, 0.9, 1.0]);
        let numpy = [1.0, 1.25, 2.25, 3.5, 8.0, 9.0];
        assert!(found.iter().zip(numpy).all(|(own, theirs)| (own - theirs).abs() < 1e-12), "{found:?}");
        assert_eq!((quantiles(vec![5.0], &[0.0, 0.9]), quantiles(Vec::new(), &[0.5])), (vec![5.0; 2], Vec::new()));
    }
}
