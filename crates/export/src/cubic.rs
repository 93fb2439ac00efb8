//! The best cubic of temperature that there is of an axis, and what it costs.

use serde::Serialize;
use zerorate_core::drift::{Drift, Scale, Shape};

use zerorate_fit::model::Model;
use zerorate_fit::nearest::nearest;

use zerorate_cal::calibration::AxisCalibration;

/// The order of the autopilots' curves.
pub(super) const ORDER: usize = 3;

/// Points of a range at which a cubic is held against a curve.
const POINTS: u32 = 1001;

/// A cubic of temperature, and the range over which it holds. Beyond it the temperature is clamped.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cubic {
    /// The temperature at which `d` is zero.
    pub reference: f64,
    /// Coefficients of 1, d, d^2, d^3 with `d = T - reference`.
    pub coefficients: [f64; ORDER + 1],
    /// The least and the greatest temperature.
    pub range: [f64; 2],
}

/// What a cubic costs against the model that was chosen, in the axis's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Loss {
    /// Held-out rms of the chosen model, as deployed where that is known; `None` where it is not.
    pub chosen_rms: Option<f64>,
    /// Held-out rms of a cubic, by the same measure; `None` where it is not known.
    pub cubic_rms: Option<f64>,
    /// How far the cubic is from the chosen static curve, at most over the range.
    pub furthest: f64,
    /// Whether both are of a whole log, as a device has it that takes its zero once; else of each held-out fold by itself, which is
    /// less.
    pub over_whole_log: bool,
    /// The two of held-out folds, each with a zero of its own, by which the model was chosen; `None` where it was not, or where the
    /// others are these.
    #[serde(skip)]
    pub chosen_by: Option<(f64, f64)>,
}

impl Cubic {
    /// The cubic of an axis: the calibration's own where it has one, the curve itself where it is no more than a cubic,
    /// else the cubic that is nearest to the curve over what was measured by least squares.
    pub(super) fn of(axis: &AxisCalibration) -> Self {
        let own = axis.fit.static_cubic.as_ref().map(|cubic| cubic.drift.clone());
        Self::of_drift(&own.unwrap_or_else(|| axis.measured_drift()))
    }

    fn of_drift(drift: &Drift) -> Self {
        let range = [drift.valid.min(), drift.valid.max()];
        let middle = f64::midpoint(range[0], range[1]);
        let polynomial = match &drift.shape {
            Shape::Polynomial(polynomial) if polynomial.order() <= ORDER => Some(polynomial.clone()),
            _ => nearest(|temperature| drift.evaluate(temperature).0, drift.valid, ORDER),
        };
        let raw = polynomial.map(|polynomial| shifted(polynomial.coefficients(), polynomial.scale(), middle));
        let mut coefficients = [0.0; ORDER + 1];
        coefficients.iter_mut().zip(raw.iter().flatten()).for_each(|(place, value)| *place = *value);
        Self { reference: middle, coefficients, range }
    }

    /// The same curve about another reference temperature.
    pub(super) fn about(&self, reference: f64) -> Self {
        let unit = Scale::new(self.reference, 1.0).unwrap_or_else(|| unreachable!("1 is above zero"));
        let moved = shifted(&self.coefficients, unit, reference);
        let mut coefficients = [0.0; ORDER + 1];
        coefficients.iter_mut().zip(&moved).for_each(|(place, value)| *place = *value);
        Self { reference, coefficients, range: self.range }
    }

    /// The same in another unit.
    pub(super) fn times(mut self, factor: f64) -> Self {
        self.coefficients.iter_mut().for_each(|c| *c *= factor);
        self
    }

    /// The same without its constant: the drift from its reference temperature on.
    pub(super) fn without_constant(mut self) -> Self {
        self.coefficients[0] = 0.0;
        self
    }

    /// The cubic at a temperature, clamped to its range.
    #[must_use]
    pub fn evaluate(&self, temperature: f64) -> f64 {
        let d = temperature.clamp(self.range[0], self.range[1]) - self.reference;
        self.coefficients.iter().rev().fold(0.0, |sum, c| sum * d + c)
    }
}

/// The coefficients in `T - reference` of a polynomial in `(T - centre) / half_span`.
fn shifted(coefficients: &[f64], scale: Scale, reference: f64) -> Vec<f64> {
    // x = offset + factor d
    let (offset, factor) = (scale.x(reference), 1.0 / scale.half_span());
    let mut result: Vec<f64> = Vec::new();
    for c in coefficients.iter().rev() {
        let mut carried = 0.0;
        for slot in &mut result {
            let grown = *slot * offset + carried;
            carried = *slot * factor;
            *slot = grown;
        }
        result.push(carried);
        result[0] += c;
    }
    result
}

fn temperatures(min: f64, max: f64) -> impl Iterator<Item = f64> {
    (0..POINTS).map(move |i| min + (max - min) * f64::from(i) / f64::from(POINTS - 1))
}

impl Loss {
    /// What `cubic` costs an axis.
    pub(super) fn of(axis: &AxisCalibration, cubic: &Cubic) -> Self {
        let fit = &axis.fit.statistics;
        let candidate = |model: Model| {
            let name = model.to_string();
            fit.candidates.iter().find(|candidate| candidate.model == name)?.held_out_rms
        };
        // What is deployed is compared, where a choice was nested: the history known, no drift in time.
        let whole = axis.fit.static_cubic.as_ref().and_then(|cubic| fit.deployed.zip(cubic.deployed));
        let whole = whole.map(|(chosen, cubic)| (chosen.rms, cubic.rms));
        let by_folds = fit.nested.and_then(|nested| nested.deployed_warm.zip(nested.cubic_deployed));
        let chosen_by = by_folds.filter(|_| whole.is_some() && fit.candidates.len() > 1);
        let deployed = whole.or(by_folds);
        let held_out = || fit.held_out.map(|residual| residual.rms);
        let own = || axis.fit.static_cubic.as_ref()?.held_out.map(|residual| residual.rms);
        // A curve that is a cubic or less loses nothing; of the others the candidates tell.
        let simple = axis.fit.model.history.is_none() && matches!(axis.model(), Model::Poly(order) if order <= ORDER);
        let (chosen_rms, cubic_rms) = match deployed {
            Some((chosen, cubic)) => (Some(chosen), Some(cubic)),
            None if simple => (held_out(), held_out()),
            None => (held_out(), own().or_else(|| candidate(Model::Poly(ORDER)))),
        };
        let [min, max] = cubic.range;
        let furthest = temperatures(min, max)
            .map(|temperature| (cubic.evaluate(temperature) - axis.drift().evaluate(temperature).0).abs())
            .fold(0.0, f64::max);
        Self { chosen_rms, cubic_rms, furthest, over_whole_log: whole.is_some(), chosen_by }
    }

    /// The same in another unit.
    pub(super) fn times(self, factor: f64) -> Self {
        let scaled = |value: Option<f64>| value.map(|value| value * factor);
        Self {
            chosen_rms: scaled(self.chosen_rms),
            cubic_rms: scaled(self.cubic_rms),
            furthest: self.furthest * factor,
            chosen_by: self.chosen_by.map(|(chosen, cubic)| (chosen * factor, cubic * factor)),
            ..self
        }
    }
}
