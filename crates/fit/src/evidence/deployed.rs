//! From the coefficients, given the data, to the model that is deployed.

use nalgebra::{DMatrix, DVector, DVectorView};
use zerorate_core::drift::{Drift, History, Memory, Scale, Shape, Table, Term, ValidRange};

use super::averages::Averages;
use super::columns::{Columns, Kind, START_SECONDS};
use super::marginal::Evaluated;
use crate::least_squares::{Basis, Fit};
use crate::model_fit::ModelFit;
use crate::predict::{DriftModel, StartUp, TimeDrift};

/// Points between the ends of what was measured at which the cubic follows the curve.
const POINTS: usize = 200;

/// The model of some coefficients. A memory, or a drift in time, that moves what is predicted by less than its own standard
/// error is left out.
pub(super) fn model(columns: &Columns, averages: &Averages, evaluated: &Evaluated) -> Option<ModelFit> {
    let curve = columns.curve();
    let beta = &evaluated.coefficients * averages.spread;
    let knots = &columns.shapes * beta.rows(0, curve);
    let knots: Vec<f64> = knots.iter().map(|knot| knot + averages.level).collect();
    let shape = Table::new(columns.table, &knots).map(Shape::Table)?;
    let counts = counting(columns, averages, evaluated);
    let kept = (columns.memories.iter().zip(curve..)).filter(|(_, place)| counts(columns.kinds[*place])).map(
        |(&memory, place)| Kept {
            memory,
            weight: beta[place],
            effect: beta[place].abs() * averages.rows.row(place).norm(),
        },
    );
    let kept: Vec<Kept> = kept.collect();
    let total: f64 = kept.iter().map(|kept| kept.effect).sum();
    let term = |kept: &Kept| Term {
        memory: kept.memory,
        weight: kept.weight / columns.amplitude(),
        share: kept.effect / total,
    };
    let history = History::new(shape.clone(), &kept.iter().map(term).collect::<Vec<Term>>());
    let time_drift = time_drift(columns, &beta, &counts);
    let cubic = cubic(&shape, columns.measured);
    let valid = ValidRange::new(columns.table.temperature(-1.0), columns.table.temperature(1.0))?;
    let model = DriftModel { drift: Drift { shape, valid }, history, time_drift };
    let covariance: DMatrix<f64> = &columns.shapes
        * evaluated.covariance.view((0, 0), (curve, curve))
        * columns.shapes.transpose()
        * averages.spread.powi(2);
    let covariance = covariance.row_iter().map(|row| row.iter().copied().collect()).collect();
    Some(ModelFit { model, cubic, covariance })
}

/// A memory that is deployed.
struct Kept {
    memory: Memory,
    /// Of its column.
    weight: f64,
    /// What it comes to over the rows, against the others.
    effect: f64,
}

/// What belongs to the recording alone; `None` where it is nothing.
fn time_drift(columns: &Columns, beta: &DVector<f64>, counts: &impl Fn(Kind) -> bool) -> Option<TimeDrift> {
    let of_kind =
        |kind: Kind| columns.kinds.iter().zip(beta).filter(move |(own, _)| **own == kind).map(|(_, beta)| *beta);
    let straight = columns.time.filter(|_| counts(Kind::Time)).map(|(first, last)| {
        let along: f64 = of_kind(Kind::Time).sum();
        TimeDrift::straight(2.0 * along / (last - first), f64::midpoint(first, last))
    });
    let part = |(rate, time_constant_s): (f64, &f64)| StartUp { rate, time_constant_s: *time_constant_s };
    let start_up: Vec<StartUp> = of_kind(Kind::Start).zip(&START_SECONDS).map(part).collect();
    if start_up.is_empty() || !counts(Kind::Start) {
        return straight;
    }
    Some(TimeDrift { start_up, ..straight.unwrap_or(TimeDrift::straight(0.0, 0.0)) })
}

/// Whether a kind of column moves what is predicted by more than its standard error, both root mean square over the rows.
fn counting(columns: &Columns, averages: &Averages, evaluated: &Evaluated) -> impl Fn(Kind) -> bool {
    let width = columns.kinds.len();
    let rows = averages.rows.rows(0, width);
    // The prediction is of the curve and the memories; the recording's own is no part of it.
    let told = columns.curve() + columns.memories.len();
    let predicting = rows.rows(0, told);
    let spread = evaluated.covariance.view((0, 0), (told, told)) * predicting;
    let square = predicting.component_mul(&spread).sum();
    let moved: Vec<(Kind, f64)> = [Kind::Plays, Kind::Lags, Kind::Time, Kind::Start]
        .map(|kind| {
            let own = |i: usize, row: DVectorView<'_, f64>| {
                if columns.kinds[i] == kind { evaluated.coefficients[i] * row[i] } else { 0.0 }
            };
            let by = |row: DVectorView<'_, f64>| (0..width).map(|i| own(i, row)).sum::<f64>().powi(2);
            (kind, (0..rows.ncols()).map(|row| by(averages.rows.column(row))).sum::<f64>())
        })
        .into();
    move |kind| moved.iter().any(|(own, moved)| *own == kind && *moved > square)
}

/// The cubic that is nearest to a curve over what was measured, every temperature alike: of a next run nobody knows how long
/// it stays where, and the rows of this one are uneven.
fn cubic(shape: &Shape, measured: ValidRange) -> Option<Drift> {
    let scale = Scale::spanning(measured.min(), measured.max())?;
    let mut fit = Fit::new(scale, Basis::Powers(3));
    for point in 0..=POINTS {
        let temperature = scale.temperature(2.0 * point as f64 / POINTS as f64 - 1.0);
        fit.push(temperature, shape.evaluate(temperature));
    }
    Some(Drift { shape: fit.finish().ok()?.shape()?, valid: measured })
}
