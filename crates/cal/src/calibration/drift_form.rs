//! How a drift stands in the file: flat, with units in the names, checked on the way in.

use serde::{Deserialize, Serialize};
use zerorate_core::drift::{Drift, History, Memory, Polynomial, Scale, Shape, Table, Term, ValidRange};
use zerorate_fit::drift_fit::StaticCubic;
use zerorate_fit::residual::ResidualStatistics;

/// How far the two forms of a polynomial may differ in a coefficient, of the larger of the two: rounding of a few
/// further operations, in another program's order.
const AGREEMENT: f64 = 1e-6;

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

/// The static cubic as it stands in the file.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct StaticCubicForm {
    drift: DriftForm,
    in_sample: ResidualStatistics,
    held_out: Option<ResidualStatistics>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    deployed: Option<ResidualStatistics>,
}

impl From<StaticCubic> for StaticCubicForm {
    fn from(cubic: StaticCubic) -> Self {
        let StaticCubic { drift, in_sample, held_out, deployed } = cubic;
        Self { drift: DriftForm::from(&drift), in_sample, held_out, deployed }
    }
}

impl StaticCubicForm {
    pub(super) fn checked(&self) -> Result<StaticCubic, String> {
        let &Self { ref drift, in_sample, held_out, deployed } = self;
        Ok(StaticCubic { drift: drift.checked()?, in_sample, held_out, deployed })
    }
}

/// A history as it stands in the file.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct HistoryForm {
    /// The static part once the history is known, with the axis's valid range.
    curve: DriftForm,
    terms: Vec<TermForm>,
}

/// One term: `weight (m - T)`, and the curve taken at `T + behind (m - T)`.
#[derive(Clone, Serialize, Deserialize)]
struct TermForm {
    #[serde(flatten)]
    memory: MemoryForm,
    /// Rate units per unit of temperature.
    weight: f64,
    /// How much of what drifts is where the memory is; none before schema 3.
    #[serde(default)]
    behind: f64,
    /// How much of the history rests on it; all terms together 1.
    share: f64,
}

#[derive(Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
enum MemoryForm {
    /// Temperature units.
    Play { half_width: f64 },
    /// Seconds.
    Lag { time_constant_s: f64 },
}

impl HistoryForm {
    pub(super) fn of(history: &History, drift: &Drift) -> Self {
        let curve = Drift { shape: history.curve().clone(), valid: drift.valid };
        let term = |term: &Term| TermForm {
            memory: match term.memory {
                Memory::Play { half_width } => MemoryForm::Play { half_width },
                Memory::Lag { time_constant_s } => MemoryForm::Lag { time_constant_s },
            },
            weight: term.weight,
            behind: term.behind,
            share: term.share,
        };
        Self { curve: DriftForm::from(&curve), terms: history.terms().iter().map(term).collect() }
    }

    pub(super) fn checked(&self) -> Result<History, String> {
        let term = |form: &TermForm| Term {
            memory: match form.memory {
                MemoryForm::Play { half_width } => Memory::Play { half_width },
                MemoryForm::Lag { time_constant_s } => Memory::Lag { time_constant_s },
            },
            weight: form.weight,
            behind: form.behind,
            share: form.share,
        };
        let terms: Vec<Term> = self.terms.iter().map(term).collect();
        History::new(self.curve.checked()?.shape, &terms).ok_or_else(|| {
            "a history has 1 to 6 terms, each with a half_width or time_constant_s above zero and a finite weight \
             and behind, and shares that add up to 1"
                .to_owned()
        })
    }
}
