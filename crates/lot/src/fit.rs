//! The fits of some recordings: the engine gives each unit's group means, solvers here fit them by the code of
//! `zerorate fit`.

mod gather;

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use zerorate_cal::calibration::AxisCalibration;
use zerorate_cal::log_fit::FitOptions;
use zerorate_cal::quality::Judgement;
use zerorate_cal::ramp_fit::{RampMeans, fit_axis};
use zerorate_core::units::Axis;

use crate::dataset::{Found, Place};
use crate::engine::{Engine, EngineError};
use gather::{Unit, gather};

/// The fit of one recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fitted {
    /// The verdict on the unit.
    pub judgement: Judgement,
    /// The axes that could be fitted, of a rejected unit too: to be looked at.
    pub axes: BTreeMap<&'static str, AxisCalibration>,
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
                    let own = fit_unit(unit, found.info.ramp_groups(), options);
                    if let Ok(mut fitted) = fitted.lock() {
                        fitted[place] = own;
                    }
                }
            });
        }
    });
    fitted.into_inner().unwrap_or_default()
}

fn fit_unit(unit: &Unit, expected: Option<u64>, options: &FitOptions) -> Fitted {
    let mut fitted = Fitted { inconsistent: unit.inconsistent, ..Fitted::default() };
    for (axis, groups) in Axis::BOTH.into_iter().zip(&unit.axes) {
        let mut means = RampMeans::default();
        groups.iter().for_each(|group| means.push(group));
        let fit = fit_axis(axis.name(), &means, expected, options, &mut fitted.judgement);
        fitted.axes.extend(fit.map(|fit| (axis.name(), fit.calibration)));
    }
    fitted
}
