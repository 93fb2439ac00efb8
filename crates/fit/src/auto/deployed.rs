//! From a solution over columns to the model that is deployed.

use zerorate_core::drift::{History, Polynomial, Shape, Table, Term};

use super::candidates::Spec;
use super::features::{Features, powers_of_legendre};
use crate::model::Model;
use crate::predict::TimeDrift;

/// The curve of some coefficients over the columns of its model, `mean` added.
pub(super) fn curve(features: &Features, model: Model, beta: &[f64], mean: f64) -> Option<Shape> {
    if let Model::Table(_) = model {
        let knots: Vec<f64> = beta.iter().map(|knot| knot + mean).collect();
        return Table::new(features.scale, &knots).map(Shape::Table);
    }
    let mut powers = powers_of_legendre(beta);
    powers[0] += mean;
    Polynomial::new(features.scale, &powers).map(Shape::Polynomial)
}

/// The history of a solution; `None` where all its weights are nothing.
pub(super) fn history(features: &Features, spec: &Spec, beta: &[f64], mean: f64) -> Option<History> {
    let weights = &beta[spec.curve()..spec.curve() + spec.memories.len()];
    // The size of a term's effect: its weight times what `m - T` comes to, the columns being of the order of one.
    let total: f64 = weights.iter().map(|weight| weight.abs()).sum();
    let terms: Vec<Term> = spec
        .memories
        .iter()
        .zip(weights)
        .map(|(&place, weight)| {
            let memory = features.memories[place];
            Term { memory, weight: weight / features.amplitude(memory), share: weight.abs() / total }
        })
        .collect();
    History::new(curve(features, spec.model, &beta[..spec.curve()], mean)?, &terms)
}

/// The drift in time of a solution.
pub(super) fn time_drift(features: &Features, spec: &Spec, beta: &[f64]) -> Option<TimeDrift> {
    let (first, last) = features.time.filter(|_| spec.terms.time)?;
    Some(TimeDrift { per_second: 2.0 * beta.last()? / (last - first), origin_s: f64::midpoint(first, last) })
}
