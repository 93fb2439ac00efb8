//! The fits of some recordings: the engine gives each unit's group means, solvers here fit them by the code of
//! `zerorate fit`.

mod gather;

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use zerorate_cal::calibration::{AxisCalibration, sha256};
use zerorate_cal::log_fit::FitOptions;
use zerorate_cal::quality::{Judgement, Reason, ReasonKind};
use zerorate_cal::ramp_fit::{RampMeans, UnitFit};
use zerorate_cal::recording::RecordingInfo;
use zerorate_cal::source::Source;

use crate::dataset::{Found, Place};
use crate::engine::{Engine, EngineError};
use gather::{Unit, gather};

/// The fit of one recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fitted {
    /// The verdict on the unit.
    pub judgement: Judgement,
    /// The axes that could be fitted, of a rejected unit too: to be looked at.
    pub axes: BTreeMap<String, AxisCalibration>,
    /// What the readings are known by, whatever is said about them: SHA-256 of the ramps' means, X first.
    pub readings_sha256: String,
    /// Groups whose means are not those of their sums: the file is damaged.
    pub inconsistent: u64,
}

/// Fits some recordings, in their order.
///
/// # Errors
/// [`EngineError`], when the query fails: then none of these is fitted.
pub async fn fit(
    engine: &Engine,
    place: &Place,
    files: &[&Found],
    options: &FitOptions,
) -> Result<Vec<Fitted>, EngineError> {
    let units = gather(engine, place, files).await?;
    Ok(tokio::task::block_in_place(|| solve(&units, files, options)))
}

/// Reads all groups of one recording, to see whether that can be done.
///
/// # Errors
/// [`EngineError`], when it cannot.
pub async fn look(engine: &Engine, place: &Place, file: &Found) -> Result<(), EngineError> {
    gather(engine, place, &[file]).await.map(|_| ())
}

/// Fits the units, on as many threads as there are cores.
fn solve(units: &[Unit], files: &[&Found], options: &FitOptions) -> Vec<Fitted> {
    let next = AtomicUsize::new(0);
    let fitted = Mutex::new(vec![Fitted::default(); units.len()]);
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, std::num::NonZero::get) {
            scope.spawn(|| {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some((unit, found)) = units.get(place).zip(files.get(place)) else {
                        return;
                    };
                    let own = fit_unit(unit, &found.info, options);
                    if let Ok(mut fitted) = fitted.lock() {
                        fitted[place] = own;
                    }
                }
            });
        }
    });
    fitted.into_inner().unwrap_or_default()
}

fn fit_unit(unit: &Unit, info: &RecordingInfo, options: &FitOptions) -> Fitted {
    let ramps = unit.axes.each_ref().map(|groups| {
        let mut means = RampMeans::default();
        groups.iter().for_each(|group| means.push(group));
        means
    });
    let mut fitted = Fitted { inconsistent: unit.inconsistent, readings_sha256: hash_of(&ramps), ..Fitted::default() };
    if unit.axes.iter().all(Vec::is_empty) {
        fitted.judgement.add(Reason::new(ReasonKind::TooFewGroups, info.without_a_ramp()));
        return fitted;
    }
    // A chamber that nobody could ask goes at its own pace, not at the plan's.
    let expected = info.ramp_groups().filter(|_| unit.driven);
    let UnitFit { judgement, axes, .. } = UnitFit::of(&ramps, expected, options);
    Fitted { judgement, axes: axes.into_iter().map(|axis| (axis.name, axis.calibration)).collect(), ..fitted }
}

/// What two recordings of the same readings have in common, and no others: to the last bit, for readings of another run never
/// are the same.
fn hash_of(ramps: &[RampMeans; 2]) -> String {
    let numbers = ramps.iter().flat_map(|means| means.temperatures.iter().chain(&means.readings));
    let bytes: Vec<u8> = numbers.flat_map(|number| number.to_bits().to_le_bytes()).collect();
    // Bytes in memory can be read.
    sha256(&Source::bytes("readings", bytes)).unwrap_or_default()
}
