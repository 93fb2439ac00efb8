//! From the coefficients, given the data, to the model that is deployed.

use nalgebra::{Cholesky, DMatrix, DVector};
use zerorate_core::drift::{Drift, History, Memory, Shape, Table, Term, ValidRange};

use super::averages::Averages;
use super::columns::{Columns, Kind};
use super::marginal::Evaluated;
use super::start_up::START_SECONDS;
use crate::model_fit::{CUBIC, ModelFit, rows};
use crate::nearest::nearest;
use crate::predict::{DriftModel, StartUp, TimeDrift};

/// The model of some coefficients. Memories, a start-up or a drift in time whose effect is less than its own standard error
/// are left out, and the others are what they are without them.
pub(super) fn model(columns: &Columns, averages: &Averages, evaluated: &Evaluated) -> Option<ModelFit> {
    let curve = columns.curve();
    let spare = spare(columns, averages, evaluated);
    let counts = |kind: Kind| !spare.contains(&kind);
    let (coefficients, covariance) = without(columns, &spare, evaluated)?;
    let beta = coefficients * averages.spread;
    let knots = &columns.shapes * beta.rows(0, curve);
    let knots: Vec<f64> = knots.iter().map(|knot| knot + averages.level).collect();
    let shape = Table::new(columns.table, &knots).map(Shape::Table)?;
    let terms = terms(columns, averages, &beta, &counts);
    let history = History::new(shape.clone(), &terms);
    let time_drift = time_drift(columns, averages, &beta, &counts);
    let cubic = nearest(|temperature| shape.evaluate(temperature), columns.seen, CUBIC)
        .map(|cubic| Drift { shape: Shape::Polynomial(cubic), valid: columns.seen });
    let valid = ValidRange::new(columns.table.temperature(-1.0), columns.table.temperature(1.0))?;
    let model = DriftModel { drift: Drift { shape, valid }, history, time_drift };
    let covariance: DMatrix<f64> = &columns.shapes
        * covariance.view((0, 0), (curve, curve))
        * columns.shapes.transpose()
        * averages.spread.powi(2);
    Some(ModelFit { model, cubic, covariance: rows(&covariance) })
}

/// The memories that are deployed, each with its share of what all come to over the rows; none of nothing.
fn terms(columns: &Columns, averages: &Averages, beta: &DVector<f64>, counts: &impl Fn(Kind) -> bool) -> Vec<Term> {
    let of_column = |place: usize| if counts(columns.kinds[place]) { beta[place] } else { 0.0 };
    let effect = |place: usize| of_column(place).abs() * averages.rows.row(place).norm();
    let spread = columns.before.as_ref().map_or(f64::NAN, |before| before.spread);
    let term = |(memory, &what): (usize, &Memory)| {
        let (adds, behind) = columns.of_memory(memory);
        Term {
            memory: what,
            weight: of_column(adds) / columns.amplitude(),
            behind: behind.map_or(0.0, |behind| of_column(behind) / spread),
            share: effect(adds) + behind.map_or(0.0, effect),
        }
    };
    let terms: Vec<Term> = columns.memories.iter().enumerate().map(term).filter(|term| term.share > 0.0).collect();
    let all: f64 = terms.iter().map(|term| term.share).sum();
    terms.into_iter().map(|term| Term { share: term.share / all, ..term }).collect()
}

/// What belongs to the recording alone; `None` where it is nothing.
fn time_drift(
    columns: &Columns,
    averages: &Averages,
    beta: &DVector<f64>,
    counts: &impl Fn(Kind) -> bool,
) -> Option<TimeDrift> {
    let of_kind = |kind: Kind| {
        let own = columns.kinds.iter().zip(beta).filter(move |(own, _)| **own == kind && counts(kind));
        own.map(|(_, beta)| *beta)
    };
    let part = |(rate, time_constant_s): (f64, &f64)| StartUp { rate, time_constant_s: *time_constant_s };
    let start_up: Vec<StartUp> = of_kind(Kind::Start).zip(&START_SECONDS).map(part).collect();
    let per_second = of_kind(Kind::Time).next().map(|along| along / columns.middle_s);
    let drift = TimeDrift {
        start_up,
        seen_from_s: averages.soonest_s,
        ..TimeDrift::straight(per_second.unwrap_or(0.0), columns.middle_s)
    };
    (per_second.is_some() || !drift.start_up.is_empty()).then_some(drift)
}

/// The kinds that may be left out.
const SPARE: [Kind; 5] = [Kind::Plays, Kind::Lags, Kind::Behind, Kind::Start, Kind::Time];

/// The kinds whose effect over the rows is less than its own standard error, both root mean square.
fn spare(columns: &Columns, averages: &Averages, evaluated: &Evaluated) -> Vec<Kind> {
    let is_spare = |kind: &Kind| {
        let own = places(columns, |other| other == *kind);
        let rows = averages.rows.select_rows(&own);
        let effect = rows.tr_mul(&evaluated.coefficients.select_rows(&own));
        let covariance = evaluated.covariance.select_rows(&own).select_columns(&own);
        effect.norm_squared() < rows.component_mul(&(covariance * &rows)).sum()
    };
    SPARE.into_iter().filter(is_spare).collect()
}

/// The places of the columns of some kinds.
fn places(columns: &Columns, wanted: impl Fn(Kind) -> bool) -> Vec<usize> {
    (0..columns.kinds.len()).filter(|&place| wanted(columns.kinds[place])).collect()
}

/// Coefficients and covariance where those of some kinds are known to be nothing.
fn without(columns: &Columns, kinds: &[Kind], evaluated: &Evaluated) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let (mut coefficients, mut covariance) = (evaluated.coefficients.clone(), evaluated.covariance.clone());
    let out = places(columns, |kind| kinds.contains(&kind));
    if !out.is_empty() {
        let across = covariance.select_columns(&out);
        let gain = Cholesky::new(across.select_rows(&out))?.solve(&across.transpose());
        coefficients -= gain.tr_mul(&coefficients.select_rows(&out));
        covariance -= &across * gain;
    }
    Some((coefficients, covariance))
}
