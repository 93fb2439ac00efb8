//! A model fitted, with what a calibration keeps beside it.

use nalgebra::DMatrix;
use zerorate_core::drift::Drift;

use crate::predict::DriftModel;

/// The order of the static curve that is kept beside a model: the autopilots'.
pub(crate) const CUBIC: usize = 3;

/// A model of the drift, fitted to some groups.
#[derive(Debug, Clone)]
pub(crate) struct ModelFit {
    pub model: DriftModel,
    /// The best static cubic of the same groups; `None` where they do not settle one.
    pub cubic: Option<Drift>,
    /// Of the static curve's scaled coefficients (of a table: of its knots), rate units squared.
    pub covariance: Vec<Vec<f64>>,
}

/// A covariance as it is kept: its rows.
pub(crate) fn rows(covariance: &DMatrix<f64>) -> Vec<Vec<f64>> {
    covariance.row_iter().map(|row| row.iter().copied().collect()).collect()
}
