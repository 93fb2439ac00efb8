//! How drift and trim stand in the file: flat, with units in the names, checked on the way in.

use serde::{Deserialize, Serialize};
use zerorate_core::compensate::{LowPass, Mode};
use zerorate_core::drift::{Drift, Polynomial, Scale, Shape, Table, ValidRange};
use zerorate_core::trim::{MAX_TAP_OFFSETS, TapEffects, Trim, TrimLine};
use zerorate_core::units::{Counts, Taps};

use super::axis::{AxisCalibration, FitStatistics, TrimCalibration};
use super::model::{BandPoint, HistoryForm, StaticCubic, TimeDrift};
use crate::log::Sensor;
use crate::table::RateUnit;
use crate::trim_fit::TrimEstimate;

/// How far the two forms of a polynomial may differ in a coefficient, of the larger of the two: rounding of a few
/// further operations, in another program's order.
const AGREEMENT: f64 = 1e-6;

/// An axis as it stands in the file.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct AxisForm {
    model: String,
    drift: DriftForm,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    history: Option<HistoryForm>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    time_drift: Option<TimeDrift>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    static_cubic: Option<StaticCubic>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    band: Vec<BandPoint>,
    rate_unit: RateUnit,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sensor: Option<Sensor>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reference_temperature: Option<f64>,
    fit: Option<FitStatistics>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    trim: Option<TrimCalibration>,
    #[serde(default)]
    warnings: Vec<String>,
}

/// A drift as it stands in the file: a polynomial has `scaled_coefficients`, a table has `knots`.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct DriftForm {
    /// The scaled variable is `(T - temperature_centre) / temperature_half_span`.
    temperature_centre: f64,
    temperature_half_span: f64,
    /// Least and greatest temperature calibrated; outside, the curve is held at the nearer end.
    valid_temperature: [f64; 2],
    /// Coefficients of 1, x, x^2, ... of the scaled variable, in the rate's unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    scaled_coefficients: Option<Vec<f64>>,
    /// Coefficients of 1, T, T^2, ... of the temperature itself, as papers print them; the scaled ones are used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    raw_coefficients: Option<Vec<f64>>,
    /// The temperatures of the knots, for readers; they follow from centre and half span.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    knot_temperatures: Option<Vec<f64>>,
    /// The curve at the knots, coldest first, in the rate's unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    knots: Option<Vec<f64>>,
}

impl From<AxisCalibration> for AxisForm {
    fn from(axis: AxisCalibration) -> Self {
        Self {
            model: axis.model().to_string(),
            drift: DriftForm::from(&axis.drift),
            history: axis.history.as_ref().map(|history| HistoryForm::of(history, &axis.drift)),
            time_drift: axis.time_drift,
            static_cubic: axis.static_cubic,
            band: axis.band,
            rate_unit: axis.rate_unit,
            sensor: axis.sensor,
            reference_temperature: axis.reference_temperature,
            fit: axis.fit,
            trim: axis.trim,
            warnings: axis.warnings,
        }
    }
}

impl TryFrom<AxisForm> for AxisCalibration {
    type Error = String;
    fn try_from(form: AxisForm) -> Result<Self, String> {
        let axis = Self {
            drift: form.drift.checked()?,
            history: form.history.as_ref().map(HistoryForm::checked).transpose()?,
            time_drift: form.time_drift,
            static_cubic: form.static_cubic,
            band: form.band,
            rate_unit: form.rate_unit,
            sensor: form.sensor,
            reference_temperature: form.reference_temperature,
            fit: form.fit,
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

impl From<&Drift> for DriftForm {
    fn from(drift: &Drift) -> Self {
        let scale = match &drift.shape {
            Shape::Polynomial(polynomial) => polynomial.scale(),
            Shape::Table(table) => table.scale(),
        };
        let mut form = Self {
            temperature_centre: scale.centre(),
            temperature_half_span: scale.half_span(),
            valid_temperature: [drift.valid.min(), drift.valid.max()],
            scaled_coefficients: None,
            raw_coefficients: None,
            knot_temperatures: None,
            knots: None,
        };
        match &drift.shape {
            Shape::Polynomial(polynomial) => {
                form.scaled_coefficients = Some(polynomial.coefficients().to_vec());
                form.raw_coefficients = Some(polynomial.raw_coefficients().to_vec());
            }
            Shape::Table(table) => {
                let temperature = |index| table.knot_temperature(index);
                form.knot_temperatures = Some((0..table.knots().len()).map(temperature).collect());
                form.knots = Some(table.knots().to_vec());
            }
        }
        form
    }
}

impl DriftForm {
    pub(super) fn checked(&self) -> Result<Drift, String> {
        let scale = Scale::new(self.temperature_centre, self.temperature_half_span)
            .ok_or("temperature_half_span must be above zero")?;
        let [min, max] = self.valid_temperature;
        let valid = ValidRange::new(min, max).ok_or("valid_temperature must be two temperatures in ascending order")?;
        let shape = match (&self.scaled_coefficients, &self.knots) {
            (Some(coefficients), None) => Shape::Polynomial(self.polynomial(scale, coefficients)?),
            (None, Some(knots)) => Shape::Table(Table::new(scale, knots).ok_or("a table has 2 to 33 knots")?),
            _ => return Err("a drift has either scaled_coefficients or knots".to_owned()),
        };
        Ok(Drift { shape, valid })
    }

    /// The polynomial, if the raw coefficients (where they stand in the file) say the same: whoever changed one form by
    /// hand is told that there are two.
    fn polynomial(&self, scale: Scale, coefficients: &[f64]) -> Result<Polynomial, String> {
        let polynomial = Polynomial::new(scale, coefficients).ok_or("a polynomial has 2 to 6 scaled_coefficients")?;
        if let Some(raw) = &self.raw_coefficients {
            let own = polynomial.raw_coefficients();
            let agree = |(a, b): (&f64, &f64)| (a - b).abs() <= AGREEMENT * a.abs().max(b.abs());
            if raw.len() != own.len() || !raw.iter().zip(&own).all(agree) {
                return Err("raw_coefficients and scaled_coefficients are not the same polynomial".to_owned());
            }
        }
        Ok(polynomial)
    }
}

/// A trim model as it stands in the file.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct TrimForm {
    line: LineForm,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    tap_effects: Option<EffectsForm>,
    dead_band_taps: f64,
    low_pass: LowPass,
    start_up_mode: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    line_by_own_readings: Option<TrimEstimate>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    line_by_the_papers_formula: Option<TrimEstimate>,
}

/// `N - N0 = a (V - V0) + b` (eq. 2).
#[derive(Clone, Serialize, Deserialize)]
struct LineForm {
    slope_taps_per_count: f64,
    intercept_taps: f64,
    centre_counts: f64,
    middle_tap: Taps,
}

/// What each tap adds to the reading at the middle tap.
#[derive(Clone, Serialize, Deserialize)]
struct EffectsForm {
    first_tap: Taps,
    effects_counts: Vec<f64>,
}

impl From<TrimCalibration> for TrimForm {
    fn from(calibration: TrimCalibration) -> Self {
        let TrimCalibration { trim: Trim { line, measured }, better, paper, dead_band_taps, low_pass, start_up_mode } =
            calibration;
        Self {
            line: LineForm {
                slope_taps_per_count: line.slope_taps_per_count(),
                intercept_taps: line.intercept_taps(),
                centre_counts: line.centre().0,
                middle_tap: line.middle(),
            },
            tap_effects: measured.map(|measured| EffectsForm {
                first_tap: measured.first(),
                effects_counts: measured.effects().iter().map(|effect| effect.0).collect(),
            }),
            dead_band_taps,
            low_pass,
            start_up_mode: start_up_mode.name().to_owned(),
            line_by_own_readings: better,
            line_by_the_papers_formula: paper,
        }
    }
}

impl TryFrom<TrimForm> for TrimCalibration {
    type Error = String;
    fn try_from(form: TrimForm) -> Result<Self, String> {
        let LineForm { slope_taps_per_count, intercept_taps, centre_counts, middle_tap } = form.line;
        let line = TrimLine::new(slope_taps_per_count, intercept_taps, Counts(centre_counts), middle_tap)
            .ok_or("a trim line has a slope_taps_per_count below zero")?;
        Ok(Self {
            trim: Trim { line, measured: form.tap_effects.map(EffectsForm::checked).transpose()? },
            better: form.line_by_own_readings,
            paper: form.line_by_the_papers_formula,
            dead_band_taps: form.dead_band_taps,
            low_pass: form.low_pass,
            start_up_mode: mode(&form.start_up_mode)?,
        })
    }
}

impl EffectsForm {
    fn checked(self) -> Result<TapEffects, String> {
        let found = self.effects_counts.len();
        let room = usize::from(Taps::LAST.get() - self.first_tap.get()) + 1;
        if found > room.min(MAX_TAP_OFFSETS) {
            return Err(format!(
                "{found} tap effects from tap {} on: a model holds {MAX_TAP_OFFSETS}, and tap {} is the last",
                self.first_tap.get(),
                Taps::LAST.get()
            ));
        }
        let effects: Vec<Counts> = self.effects_counts.into_iter().map(Counts).collect();
        let unsound = || "the tap effects must be at least one, finite, and rise from tap to tap".to_owned();
        TapEffects::new(self.first_tap, &effects).ok_or_else(unsound)
    }
}

fn mode(name: &str) -> Result<Mode, String> {
    let known = [Mode::Off, Mode::Trim, Mode::Digital, Mode::Hybrid].into_iter().find(|mode| mode.name() == name);
    known.ok_or_else(|| format!("'{name}' is no start_up_mode: off, trim, digital or hybrid"))
}
