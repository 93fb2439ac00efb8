//! Polynomials as plain sums on the engine, in three passes, and a solve for each axis here.
//!
//! 1. Counts and extremes of each axis: its scale and level.
//! 2. Sums of powers of the centred, scaled temperature and of the reading less its level, an eighth of the ramp each.
//! 3. What the curve leaves: squares, fourth powers and extremes of the residual, in-sample and held out.

mod extent;
mod moments;
mod residual;

use std::collections::HashMap;

use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use datafusion::arrow::compute::cast;
use datafusion::arrow::datatypes::{DataType, Float64Type};
use zerorate_cal::calibration::AxisCalibration;
use zerorate_cal::log_fit::FitOptions;
use zerorate_cal::quality::{Judgement, Reason, ReasonKind};
use zerorate_cal::ramp_fit::{AxisSurvey, JUDGED_ORDER, RampMeans, judge_residual, judge_survey, verdict_of};
use zerorate_cal::units::RateUnit;
use zerorate_core::drift::{Drift, Polynomial, Scale, Shape, ValidRange};
use zerorate_core::units::Axis;
use zerorate_fit::drift_fit::{Candidate, DriftFit, FitStatistics, ResidualOver};
use zerorate_fit::folds::FOLDS;
use zerorate_fit::model::Model;
use zerorate_fit::predict::DriftModel;
use zerorate_fit::residual::ResidualStatistics;

use crate::dataset::{Found, Place};
use crate::engine::{Engine, EngineError};
use crate::fitted::{AxisRow, Fitted};
use crate::solve::Sums;
use extent::Extent;
use moments::Moments;
use residual::Left;

/// An axis of a file: the file's place in the query and whether it is Y.
type Key = (usize, bool);

/// An axis with a curve.
struct Curve {
    scale: Scale,
    coefficients: Vec<f64>,
    without: Vec<Option<Vec<f64>>>,
    /// Of [`JUDGED_ORDER`]: what wild groups are searched for under.
    judged: Vec<f64>,
    all: Sums,
    stretches: Vec<Sums>,
}

/// Fits some files by polynomials of one order.
///
/// # Errors
/// [`EngineError`], when a query fails: then no file of these is fitted.
pub async fn fit(
    engine: &Engine,
    place: &Place,
    files: &[&Found],
    order: usize,
    allow_narrow: bool,
) -> Result<Vec<Fitted>, EngineError> {
    let extents = extent::query(engine, place, files).await?;
    let moments = moments::query(engine, place, files, &extents).await?;
    let options = FitOptions { model: Model::Poly(order), allow_narrow, ..FitOptions::default() };
    let mut judgements: Vec<Judgement> = vec![Judgement::default(); files.len()];
    let mut curves: HashMap<Key, Curve> = HashMap::new();
    for (file, found) in files.iter().enumerate() {
        for axis in Axis::BOTH {
            let key = (file, axis == Axis::Y);
            let mut own = Judgement::default();
            let extent = extents.get(&key);
            complete(found, extent.map(|it| it.groups), moments.get(&key).map(Moments::groups))?;
            let survey = survey(extent, moments.get(&key));
            judge_survey(&mut own, axis.name(), &survey, found.info.ramp_groups(), &options);
            if let (false, Some(extent), Some(moments)) = (own.rejected(), extent, moments.get(&key)) {
                match curve(extent, moments, order) {
                    Some(curve) => _ = curves.insert(key, curve),
                    None => own.add(Reason::new(
                        ReasonKind::TooFewGroups,
                        format!("{}: the temperatures do not settle {} coefficients", axis.name(), order + 1),
                    )),
                }
            }
            merge(&mut judgements[file], own, allow_narrow);
        }
    }
    let left = residual::query(engine, place, files, &extents, &curves, order).await?;
    let mut fitted = Vec::with_capacity(files.len());
    for (file, mut judgement) in judgements.into_iter().enumerate() {
        let mut axes = Vec::new();
        for axis in Axis::BOTH {
            let key = (file, axis == Axis::Y);
            if let (Some(curve), Some(extent), Some(left)) = (curves.get(&key), extents.get(&key), left.get(&key)) {
                complete(files[file], Some(extent.groups), Some(left.survey.count))?;
                judge_residual(&mut judgement, axis.name(), &left.survey);
                axes.extend(row(axis, curve, extent, left, order));
            }
        }
        let inconsistent =
            [false, true].iter().filter_map(|y| extents.get(&(file, *y))).map(|it| it.inconsistent).sum();
        fitted.push(Fitted { judgement, axes, inconsistent });
    }
    Ok(fitted)
}

/// Reads all groups of one recording, to see whether that can be done.
///
/// # Errors
/// [`EngineError`], when it cannot.
pub async fn look(engine: &Engine, place: &Place, file: &Found) -> Result<(), EngineError> {
    extent::query(engine, place, &[file]).await.map(|_| ())
}

/// Whether a pass has seen the same groups as the first: a result that lost some must not pass for one.
fn complete(found: &Found, expected: Option<u64>, groups: Option<u64>) -> Result<(), EngineError> {
    let (expected, groups) = (expected.unwrap_or(0), groups.unwrap_or(0));
    if expected == groups {
        return Ok(());
    }
    Err(EngineError::Lost { file: found.file.clone(), expected, found: groups })
}

/// Puts an axis's reasons to the unit's.
fn merge(judgement: &mut Judgement, own: Judgement, allow_narrow: bool) {
    for reason in own.reasons {
        judgement.add_as(verdict_of(&reason, allow_narrow), reason);
    }
}

fn survey(extent: Option<&Extent>, moments: Option<&Moments>) -> AxisSurvey {
    let mut survey = AxisSurvey::of(&RampMeans::default());
    if let (Some(extent), Some(moments)) = (extent, moments) {
        survey.span = extent.span;
        survey.saturated = extent.saturated;
        survey.taps = Some(extent.taps);
        survey.folds = moments.folds;
    }
    survey
}

fn curve(extent: &Extent, moments: &Moments, order: usize) -> Option<Curve> {
    let scale = extent.scale()?;
    let mut all = Sums::empty(JUDGED_ORDER);
    moments.sums.iter().for_each(|sums| all.add(sums));
    let judged = all.solve();
    let all = all.truncated(order);
    let stretches: Vec<Sums> = moments.sums.iter().map(|sums| sums.truncated(order)).collect();
    let coefficients = all.solve()?;
    let without = (0..FOLDS)
        .map(|left_out| {
            let mut rest = Sums::empty(order);
            stretches.iter().enumerate().filter(|(own, _)| *own != left_out).for_each(|(_, sums)| rest.add(sums));
            rest.solve()
        })
        .collect();
    // Where the groups do not settle so many coefficients, the curve itself is judged by.
    let padded = || coefficients.iter().copied().chain(std::iter::repeat(0.0)).take(JUDGED_ORDER + 1).collect();
    let judged = judged.unwrap_or_else(padded);
    Some(Curve { scale, coefficients, without, judged, all, stretches })
}

/// Coefficients in counts: the level is added to the constant.
fn absolute(coefficients: &[f64], level: f64) -> Vec<f64> {
    let mut coefficients = coefficients.to_vec();
    coefficients[0] += level;
    coefficients
}

fn row(axis: Axis, curve: &Curve, extent: &Extent, left: &Left, order: usize) -> Option<AxisRow> {
    let polynomial = Polynomial::new(curve.scale, &absolute(&curve.coefficients, extent.level()))?;
    let valid = ValidRange::new(extent.temperature.0, extent.temperature.1)?;
    let groups = left.survey.count;
    let freedom = groups.saturating_sub(order as u64 + 1).max(1);
    let variance = left.squares / freedom as f64;
    let inverse = curve.all.inverse()?;
    let covariance = inverse.iter().map(|row| row.iter().map(|entry| entry * variance).collect()).collect();
    let in_sample = ResidualStatistics { rms: (left.squares / groups as f64).sqrt(), pp: left.extremes.1 - left.extremes.0 };
    let used = || curve.stretches.iter().zip(&curve.without).filter(|(sums, _)| sums.groups > 0);
    let complete = used().all(|(_, without)| without.is_some());
    let held_out = complete.then(|| ResidualStatistics {
        rms: (left.held_out_squares / groups as f64).sqrt(),
        pp: left.held_out_extremes.1 - left.held_out_extremes.0,
    });
    let candidate = Candidate {
        model: Model::Poly(order).to_string(),
        in_sample_rms: in_sample.rms,
        held_out_rms: held_out.map(|spread| spread.rms),
        held_out_excess_standard_error: held_out.map(|_| 0.0),
        deployed_rms: None,
        ends_rms: None,
        by_direction_rms: None,
        shrinkage_weight: None,
        chosen: true,
    };
    let statistics = FitStatistics {
        residual_over: ResidualOver::Groups,
        residuals: groups,
        samples_used: extent.samples,
        in_sample,
        held_out,
        held_out_folds: FOLDS as u64,
        covariance,
        candidates: vec![candidate],
        nested: None,
    };
    let drift = Drift { shape: Shape::Polynomial(polynomial), valid };
    let model = DriftModel { drift, history: None, time_drift: None };
    let fit = DriftFit { model, static_cubic: None, band: Vec::new(), statistics };
    let calibration = AxisCalibration::of_fit(fit, RateUnit::Counts);
    Some(AxisRow { axis: axis.name().to_owned(), calibration })
}

/// A column of a result as f64; an engine may give a sum as any kind of number.
pub(crate) fn column(batch: &RecordBatch, name: &str) -> Result<Vec<f64>, EngineError> {
    let missing = |what: String| EngineError::Query(datafusion::common::DataFusionError::Internal(what));
    let column = batch.column_by_name(name).ok_or_else(|| missing(format!("no column {name} in the result")))?;
    let column = cast(column, &DataType::Float64).map_err(|error| missing(error.to_string()))?;
    let column = column.as_primitive::<Float64Type>();
    Ok(column.iter().map(|value| value.unwrap_or(f64::NAN)).collect())
}

/// The axis of each row of a result.
// Places and counts are far below 2^53.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn keys(batch: &RecordBatch) -> Result<Vec<Key>, EngineError> {
    let (file, y) = (column(batch, "file")?, column(batch, "y")?);
    Ok(file.iter().zip(&y).map(|(file, y)| (*file as usize, *y > 0.5)).collect())
}

/// Counts in a result are far below 2^53.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(crate) fn count(value: f64) -> u64 {
    value as u64
}
