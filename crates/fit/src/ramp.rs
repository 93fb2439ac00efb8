//! The drift of one axis from the group means of a recording (S7; paper, 2.2, eq. 1).

use thiserror::Error;
use zerorate_core::drift::{Scale, ValidRange};

use crate::choose::{FoldFits, FoldResiduals};
use crate::drift_fit::{DriftFit, ResidualOver};
use crate::least_squares::FitError;
use crate::model::Model;

/// Why there is no drift.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum DriftFitError {
    /// Not one reading a temperature.
    #[error("{temperatures} temperatures and {readings} readings: each group must have one of both")]
    Lengths {
        /// Temperatures given.
        temperatures: usize,
        /// Readings given.
        readings: usize,
    },
    /// A mean is no number.
    #[error("group {place} of the recording has no number for its {what}: it was empty or lost; leave such groups out")]
    NotFinite {
        /// The group's place in the slices, from 0.
        place: usize,
        /// `"temperature"` or `"reading"`.
        what: &'static str,
    },
    /// The temperature never changes.
    #[error(
        "the temperature stays at {temperature:.2} in all groups: its sensor is stuck, or the chamber did not heat"
    )]
    Stuck {
        /// The temperature, in its own unit.
        temperature: f64,
    },
    /// The groups do not settle the model.
    #[error(transparent)]
    Fit(#[from] FitError),
}

/// Fits the drift of one axis to group means by ordinary least squares: temperatures and readings at the middle tap, in the
/// order in which the groups were taken, each in its own unit (counts on the analogue board). The curve's range is the
/// span of the groups' temperatures; whether it is wide enough for a calibration is for the caller to say.
///
/// # Errors
/// [`DriftFitError`], when a mean is not a number, or the groups do not settle the model.
pub fn fit_drift(temperatures: &[f64], readings: &[f64], model: Model) -> Result<DriftFit, DriftFitError> {
    let (scale, valid) = span(temperatures, readings, model)?;
    let groups = temperatures.len() as u64;
    let mut fits = FoldFits::new(scale, model, groups);
    fits.push_rows(0, temperatures, readings);
    let choice = fits.choose(model)?;
    let mut residuals = FoldResiduals::new(&choice, groups);
    for (row, (temperature, reading)) in (0..groups).zip(temperatures.iter().zip(readings)) {
        residuals.push(row, *temperature, *reading);
    }
    Ok(choice.finish(valid, ResidualOver::Groups, residuals.statistics()))
}

/// The scale and the valid range of group means, once it is known that a model could be fitted to them.
///
/// # Errors
/// As [`fit_drift`].
pub fn span(temperatures: &[f64], readings: &[f64], model: Model) -> Result<(Scale, ValidRange), DriftFitError> {
    if temperatures.len() != readings.len() {
        return Err(DriftFitError::Lengths { temperatures: temperatures.len(), readings: readings.len() });
    }
    for (values, what) in [(temperatures, "temperature"), (readings, "reading")] {
        if let Some(place) = values.iter().position(|value| !value.is_finite()) {
            return Err(DriftFitError::NotFinite { place, what });
        }
    }
    let (groups, coefficients) = (temperatures.len() as u64, model.least_coefficients());
    if groups < coefficients as u64 {
        return Err(FitError::TooFewRows { rows: groups, coefficients }.into());
    }
    let min = temperatures.iter().copied().fold(f64::INFINITY, f64::min);
    let max = temperatures.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let stuck = DriftFitError::Stuck { temperature: min };
    Scale::spanning(min, max).zip(ValidRange::new(min, max)).ok_or(stuck)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's X axis (eq. 1), heating, with a noise of +-1 count.
    fn paper_x() -> (Vec<f64>, Vec<f64>) {
        (0..2400_i32)
            .map(|group| {
                let t = 8500.0 + 3400.0 * f64::from(group) / 2399.0;
                let noise = f64::from((group * 7919) % 1000) / 500.0 - 1.0;
                (t, 13_435.7 - 0.894_782 * t + 0.375_298e-4 * t * t + noise)
            })
            .unzip()
    }

    #[test]
    fn the_papers_curve_is_found_again_with_its_span() {
        let (temperatures, readings) = paper_x();
        let fit = fit_drift(&temperatures, &readings, Model::Auto).unwrap();
        assert_eq!(fit.chosen_model(), "poly:2");
        assert_eq!((fit.model.drift.valid.min(), fit.model.drift.valid.max()), (8500.0, 11_900.0));
        assert!((fit.model.drift.evaluate(10_200.0).0 - 8213.52).abs() < 0.1);
        let (in_sample, held_out) = (fit.statistics.in_sample, fit.statistics.held_out);
        // Uniform over two counts: 2 / sqrt(12).
        assert!((in_sample.rms - 0.577).abs() < 0.01 && (held_out.unwrap().rms - 0.577).abs() < 0.01);
        assert!(in_sample.pp <= 2.1 && fit.statistics.residuals == 2400);
        assert!((in_sample.rms - fit.statistics.candidates[1].in_sample_rms).abs() < 1e-9);
    }

    #[test]
    fn a_table_asked_for_is_fitted() {
        let (temperatures, readings) = paper_x();
        let fit = fit_drift(&temperatures, &readings, Model::Table(16)).unwrap();
        assert_eq!(fit.chosen_model(), "table:16");
        assert!(
            (fit.model.drift.evaluate(9000.0).0
                - fit_drift(&temperatures, &readings, Model::Poly(2)).unwrap().model.drift.evaluate(9000.0).0)
                .abs()
                < 0.5
        );
    }

    #[test]
    fn groups_that_cannot_be_fitted_are_refused_with_what_is_wrong() {
        let refused = |t: &[f64], v: &[f64]| fit_drift(t, v, Model::Poly(2)).unwrap_err();
        assert_eq!(refused(&[1.0], &[]), DriftFitError::Lengths { temperatures: 1, readings: 0 });
        assert_eq!(refused(&[1.0, 2.0], &[1.0, f64::NAN]), DriftFitError::NotFinite { place: 1, what: "reading" });
        assert_eq!(refused(&[9000.0; 9], &[8200.0; 9]), DriftFitError::Stuck { temperature: 9000.0 });
        assert!(matches!(refused(&[1.0, 2.0], &[1.0, 2.0]), DriftFitError::Fit(FitError::TooFewRows { .. })));
        assert!(matches!(refused(&[], &[]), DriftFitError::Fit(FitError::TooFewRows { .. })));
    }
}
