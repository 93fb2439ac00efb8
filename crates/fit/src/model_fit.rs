//! A model fitted, with what a calibration keeps beside it.

use zerorate_core::drift::Drift;

use crate::predict::DriftModel;

/// A model of the drift, fitted to some groups.
pub(crate) struct ModelFit {
    pub model: DriftModel,
    /// The best static cubic of the same groups; `None` where they do not settle one.
    pub cubic: Option<Drift>,
    /// Of the static curve's scaled coefficients (of a table: of its knots), rate units squared.
    pub covariance: Vec<Vec<f64>>,
}
