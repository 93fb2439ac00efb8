//! One axis of a calibration, and how it stands in the file.

use std::f64::consts::SQRT_2;
use std::ops::Range;

use serde::{Deserialize, Serialize};
use zerorate_core::drift::{Drift, ValidRange};
use zerorate_fit::drift_fit::{BandPoint, DriftFit, FitStatistics};
use zerorate_fit::folds::TELLING;
use zerorate_fit::model::Model;
use zerorate_fit::predict::{DriftModel, TimeDrift};
use zerorate_fit::residual::ResidualStatistics;

use super::drift_form::{DriftForm, HistoryForm, StaticCubicForm};
use super::trim::TrimCalibration;
use crate::log::Sensor;
use crate::units::{RateScale, RateUnit, WrittenRate};

/// More left than uncorrected is told from chance by so many standard errors.
const SIGMAS: f64 = 2.0;

/// A hysteresis of one cycle is left of each fold twice, for the others have its other side, and its zero is as far off again:
/// of folds as of a zeroed run that is two times the root of two of what is left in-sample. Noise alone is left by less, and what
/// is left by more was fitted to noise.
const RETURNING: Range<f64> = 2.0..3.5;

/// Places at which two curves are compared.
const COMPARED_AT: u32 = 200;

/// One axis: its drift, how well it was fitted, and its trim where it has one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "AxisForm", into = "AxisForm")]
pub struct AxisCalibration {
    /// Zero-rate output over temperature, in `rate_unit` and the calibration's temperature unit.
    pub fit: DriftFit,
    /// The unit of the drift and of every residual: counts on the analogue board.
    pub rate_unit: RateUnit,
    /// The sensor, where the log tells of sensors.
    pub sensor: Option<Sensor>,
    /// Where the drift is 0 by definition, in the calibration's temperature unit: an accelerometer at rest shows its
    /// constant and gravity together. `None` where the constant is part of the drift.
    pub reference_temperature: Option<f64>,
    /// The trim part's model; `None` without one.
    pub trim: Option<TrimCalibration>,
    /// What to look at, a sentence each.
    pub warnings: Vec<String>,
}

impl AxisCalibration {
    /// What a fit says of an axis, and nothing else.
    #[must_use]
    pub fn of_fit(fit: DriftFit, rate_unit: RateUnit) -> Self {
        Self { fit, rate_unit, sensor: None, reference_temperature: None, trim: None, warnings: Vec::new() }
    }

    /// The curve; with a history, the one for when that is not known.
    #[must_use]
    pub fn drift(&self) -> &Drift {
        &self.fit.model.drift
    }

    /// The drift as a curve without a history, over what was measured and no further
    /// ([`DriftFit::measured_drift`](zerorate_fit::drift_fit::DriftFit::measured_drift)).
    #[must_use]
    pub fn measured_drift(&self) -> Drift {
        self.fit.measured_drift()
    }

    /// How far its curve is from another's at most, over the temperatures that both were fitted to, in its rate unit; `None` where
    /// they have none in common.
    #[must_use]
    pub fn distance_from(&self, other: &Self) -> Option<f64> {
        let (own, other) = (self.measured_drift(), other.measured_drift());
        let (from, to) = (own.valid.min().max(other.valid.min()), own.valid.max().min(other.valid.max()));
        let places = (0..=COMPARED_AT).map(|place| from + (to - from) * f64::from(place) / f64::from(COMPARED_AT));
        let apart = places.map(|temperature| (own.evaluate(temperature).0 - other.evaluate(temperature).0).abs());
        (from <= to).then(|| apart.fold(0.0, f64::max))
    }

    /// What is to be known of an axis whose calibration leaves a device more than it had: its folds are of this log, and the
    /// next log is no easier. `None` where it helps, and where nobody knows. Rates are told in the unit that is asked for, if any is.
    #[must_use]
    pub fn no_gain(&self, name: &str, asked: Option<WrittenRate>) -> Option<String> {
        let statistics = &self.fit.statistics;
        let left = statistics.deployed.map(|left| (left, statistics.in_sample.rms));
        let by_folds = left.and_then(|left| self.no_gain_by_folds(name, &self.fit.chosen_model(), left, asked));
        by_folds.or_else(|| self.no_gain_by_logs(name, asked))
    }

    /// The same of a device that takes the static cubic off, as an autopilot does: it may help where the model does not, and the
    /// other way round.
    #[must_use]
    pub fn no_gain_of_cubic(&self, name: &str, asked: Option<WrittenRate>) -> Option<String> {
        let Some(cubic) = &self.fit.static_cubic else { return self.no_gain(name, asked) };
        let left = cubic.deployed.map(|left| (left, cubic.in_sample.rms));
        let by_folds = left.and_then(|left| self.no_gain_by_folds(name, "this cubic", left, asked));
        let model = self.fit.chosen_model();
        let of_the_model = |told| format!("{told}. That is of {model}; what a cubic does there is not known");
        by_folds.or_else(|| self.no_gain_by_logs(name, asked).map(of_the_model))
    }

    /// `left` is what is left by what the device takes off, held out as deployed, and the rms of its fit.
    fn no_gain_by_folds(
        &self,
        name: &str,
        taken_off: &str,
        (left, in_sample): (ResidualStatistics, f64),
        asked: Option<WrittenRate>,
    ) -> Option<String> {
        let uncorrected = self.fit.statistics.uncorrected?.rms;
        let deployed = left.rms;
        // So little more may be chance; that it does not help is none.
        let telling = ((TELLING - 1.0) * uncorrected).max(SIGMAS * left.rms_standard_error.unwrap_or(0.0));
        let may_return = RETURNING.contains(&(deployed / in_sample)) && SQRT_2 * in_sample < uncorrected;
        let what = match deployed {
            _ if deployed < uncorrected => return None,
            _ if may_return => {
                "whether it helps on a next run this log does not tell, for what it leaves may be a hysteresis that returns: fit two runs"
            }
            _ if deployed <= uncorrected + telling => "it does not help on a log like this one",
            _ => "do not use it",
        };
        let scale = RateScale::of(self.rate_unit, &[deployed, uncorrected], asked);
        Some(format!(
            "{name}: a device that takes {taken_off} off has {} rms left of data that were not fitted, and {} without it: {what}",
            scale.told(deployed),
            scale.number(uncorrected)
        ))
    }

    /// The same by whole logs, each of them as a fit of the others leaves it: what was fitted is to the next run what the
    /// others are to each.
    fn no_gain_by_logs(&self, name: &str, asked: Option<WrittenRate>) -> Option<String> {
        let by_log = &self.fit.statistics.by_log;
        let logs: Vec<(f64, f64)> =
            by_log.iter().filter_map(|log| Some((log.by_the_others?, log.uncorrected))).collect();
        if logs.is_empty() || logs.len() < by_log.len() || logs.iter().any(|(left, uncorrected)| left < uncorrected) {
            return None;
        }
        let rms = |of: fn(&(f64, f64)) -> f64| {
            (logs.iter().map(|log| of(log).powi(2)).sum::<f64>() / logs.len() as f64).sqrt()
        };
        let (left, uncorrected) = (rms(|log| log.0), rms(|log| log.1));
        let scale = RateScale::of(self.rate_unit, &[left, uncorrected], asked);
        Some(format!(
            "{name}: of none of the logs is less left by a fit of the others, {} rms of all together for {} without it: it does \
             not help on a log that was not fitted, or not at its temperatures",
            scale.told(left),
            scale.number(uncorrected)
        ))
    }

    /// The drift's shape and size.
    #[must_use]
    pub fn model(&self) -> Model {
        Model::of_shape(&self.drift().shape)
    }
}

/// An axis as it stands in the file.
#[derive(Clone, Serialize, Deserialize)]
struct AxisForm {
    model: String,
    drift: DriftForm,
    /// Files before it have but how far the curve is believed, `drift.valid_temperature`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    measured_temperature: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    history: Option<HistoryForm>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    time_drift: Option<TimeDrift>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    static_cubic: Option<StaticCubicForm>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    band: Vec<BandPoint>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    next_run_band: Vec<BandPoint>,
    rate_unit: RateUnit,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sensor: Option<Sensor>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reference_temperature: Option<f64>,
    /// Schema 1 could do without.
    #[serde(default)]
    fit: Option<FitStatistics>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    trim: Option<TrimCalibration>,
    #[serde(default)]
    warnings: Vec<String>,
}

impl From<AxisCalibration> for AxisForm {
    fn from(axis: AxisCalibration) -> Self {
        let name = axis.model().to_string();
        let DriftFit { model, measured, static_cubic, band, next_run_band, statistics } = axis.fit;
        let DriftModel { drift, history, time_drift } = model;
        Self {
            model: name,
            history: history.as_ref().map(|history| HistoryForm::of(history, &drift)),
            drift: DriftForm::from(&drift),
            measured_temperature: Some([measured.min(), measured.max()]),
            time_drift,
            static_cubic: static_cubic.map(StaticCubicForm::from),
            band,
            next_run_band,
            rate_unit: axis.rate_unit,
            sensor: axis.sensor,
            reference_temperature: axis.reference_temperature,
            fit: Some(statistics),
            trim: axis.trim,
            warnings: axis.warnings,
        }
    }
}

impl TryFrom<AxisForm> for AxisCalibration {
    type Error = String;
    fn try_from(form: AxisForm) -> Result<Self, String> {
        let model = DriftModel {
            drift: form.drift.checked()?,
            history: form.history.as_ref().map(HistoryForm::checked).transpose()?,
            time_drift: form.time_drift,
        };
        let measured = form.measured_temperature.map(|[min, max]| {
            ValidRange::new(min, max).ok_or("measured_temperature must be two temperatures in ascending order")
        });
        let measured = measured.transpose()?.unwrap_or(model.drift.valid);
        let static_cubic = form.static_cubic.as_ref().map(StaticCubicForm::checked).transpose()?;
        let axis = Self {
            fit: DriftFit {
                model,
                measured,
                static_cubic,
                band: form.band,
                next_run_band: form.next_run_band,
                statistics: form.fit.unwrap_or_else(FitStatistics::unknown),
            },
            rate_unit: form.rate_unit,
            sensor: form.sensor,
            reference_temperature: form.reference_temperature,
            trim: form.trim,
            warnings: form.warnings,
        };
        let model = axis.model().to_string();
        if model != form.model {
            return Err(format!("the axis says model {}, and its drift is {model}", form.model));
        }
        Ok(axis)
    }
}
