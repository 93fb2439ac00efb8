//! Models that no sums settle (a choice by held-out error, tables, history): the engine streams each unit's group sums
//! here, 2400 rows a run, and a pool of solvers fits them with `cal`'s own code.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use zerorate_cal::log_fit::FitOptions;
use zerorate_cal::quality::Judgement;
use zerorate_cal::ramp_fit::{RampGroup, RampMeans, fit_axis};
use zerorate_core::units::Axis;
use zerorate_fit::model::Model;

use crate::dataset::{Found, Place, columns};
use crate::engine::{Engine, EngineError};
use crate::fitted::{AxisRow, Fitted};
use crate::poly::{column, count};
use crate::table::Files;

const SQL: &str = "
SELECT file, CASE WHEN axis = 'y' THEN 1 ELSE 0 END AS y, CAST(\"group\" AS BIGINT) AS g, t_s,
       temperature_counts AS t, zro_counts AS z, CAST(n AS BIGINT) AS n, CAST(flags AS BIGINT) AS flags,
       CAST(tap AS BIGINT) AS tap,
       CASE WHEN phase IN ('heating', 'cooling') AND n > 0 THEN 1 ELSE 0 END AS used,
       CASE WHEN n > 0 AND (temperature_counts <> CAST(temperature_sum AS DOUBLE) / n
                            OR zro_counts <> CAST(zro_sum AS DOUBLE) / n) THEN 1 ELSE 0 END AS inconsistent
FROM files";

/// What came of one file.
#[derive(Debug, Clone, Default)]
struct Unit {
    rows: u64,
    inconsistent: u64,
    axes: [Vec<RampGroup>; 2],
}

/// Fits some files.
///
/// # Errors
/// [`EngineError`], when the query fails: then no file of these is fitted.
pub async fn fit(
    engine: &Engine,
    place: &Place,
    files: &[&Found],
    model: Model,
    allow_narrow: bool,
) -> Result<Vec<Fitted>, EngineError> {
    let units = gather(engine, place, files).await?;
    let options = FitOptions { model, allow_narrow, ..FitOptions::default() };
    Ok(tokio::task::block_in_place(|| solve(&units, files, &options)))
}

// Group numbers, counts, flags and taps fit their types in the file.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
async fn gather(engine: &Engine, place: &Place, files: &[&Found]) -> Result<Vec<Unit>, EngineError> {
    let table = files.iter().map(|file| (file.meta.clone(), Vec::new())).collect();
    let batches = engine.collect(place, Files::new(place.root.clone(), columns(), table), SQL).await?;
    let mut units = vec![Unit::default(); files.len()];
    for batch in &batches {
        let get = |name| column(batch, name);
        let (file, y, group, t_s) = (get("file")?, get("y")?, get("g")?, get("t_s")?);
        let (t, z, n, flags, tap) = (get("t")?, get("z")?, get("n")?, get("flags")?, get("tap")?);
        let (used, inconsistent) = (get("used")?, get("inconsistent")?);
        for row in 0..batch.num_rows() {
            let unit = &mut units[file[row] as usize];
            unit.rows += 1;
            unit.inconsistent += count(inconsistent[row]);
            if used[row] > 0.5 {
                unit.axes[usize::from(y[row] > 0.5)].push(RampGroup {
                    group: group[row] as u32,
                    time_s: t_s[row],
                    temperature: t[row],
                    reading: z[row],
                    samples: n[row] as u32,
                    flags: flags[row] as u16,
                    tap: tap[row] as u16,
                });
            }
        }
    }
    for (unit, found) in units.iter_mut().zip(files) {
        if unit.rows != found.rows {
            return Err(EngineError::Lost { file: found.file.clone(), expected: found.rows, found: unit.rows });
        }
        unit.axes.iter_mut().for_each(|rows| rows.sort_by_key(|row| row.group));
    }
    Ok(units)
}

/// Fits the units, on as many threads as there are cores.
fn solve(units: &[Unit], files: &[&Found], options: &FitOptions) -> Vec<Fitted> {
    let next = AtomicUsize::new(0);
    let fitted: Mutex<Vec<(usize, Fitted)>> = Mutex::new(Vec::with_capacity(units.len()));
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
                        fitted.push((place, own));
                    }
                }
            });
        }
    });
    let mut fitted = fitted.into_inner().unwrap_or_default();
    fitted.sort_by_key(|(place, _)| *place);
    fitted.into_iter().map(|(_, fitted)| fitted).collect()
}

fn fit_unit(unit: &Unit, expected: Option<u64>, options: &FitOptions) -> Fitted {
    let mut judgement = Judgement::default();
    let mut axes = Vec::new();
    for (axis, rows) in Axis::BOTH.into_iter().zip(&unit.axes) {
        let mut means = RampMeans::default();
        for row in rows {
            means.push(row);
        }
        if let Some(fit) = fit_axis(axis.name(), &means, expected, options, &mut judgement) {
            axes.push(AxisRow { axis: fit.name, calibration: fit.calibration });
        }
    }
    Fitted { judgement, axes, inconsistent: unit.inconsistent }
}
