//! One axis as the host composes it, in f64: what its part of a record is rounded from.

use super::{AxisRecord, DeviceRecord, UnitSerial};
use crate::board::BoardNumbers;
use crate::compensate::{AxisLaw, EdgeTable, HistoryNumbers, LawNumbers, LawRefused, LowPass, Mode, StaticLaw};
use crate::drift::{Drift, History};
use crate::trim::Trim;
use crate::units::{Axis, TemperatureScale};

impl DeviceRecord {
    /// The record of a unit, from the models of its axes, X then Y.
    ///
    /// # Errors
    /// [`LawRefused`] and the axis, when its law is none that a device would run.
    pub fn new(
        unit: UnitSerial,
        temperature_scale: TemperatureScale,
        board: BoardNumbers,
        axes: &[AxisModel; 2],
    ) -> Result<Self, (Axis, LawRefused)> {
        let record = |axis: Axis| axes[axis.index()].record(temperature_scale).map_err(|refused| (axis, refused));
        Ok(Self { unit, temperature_scale, board, axes: [record(Axis::X)?, record(Axis::Y)?] })
    }
}

/// The models of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisModel {
    /// Zero-rate output at the middle tap over temperature, counts.
    pub drift: Drift,
    /// The trim part's model.
    pub trim: Trim,
    /// Dead band, taps.
    pub dead_band: f64,
    /// The circuit's low-pass at the board's sampling.
    pub low_pass: LowPass,
    /// What the axis does when the board starts.
    pub start_up_mode: Mode,
    /// The law solved for its edges; `None` where it has none and only the digital mode can run.
    pub edges: Option<EdgeTable>,
    /// What the drift remembers of its temperatures; `None` where it is a function of temperature alone. With one,
    /// `drift` is the curve for when the history is unknown, and the law of mode trim.
    pub history: Option<HistoryModel>,
}

/// A history and the time step that it runs by.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryModel {
    /// The terms and their curve, in counts.
    pub history: History,
    /// The time from group to group, seconds.
    pub group_period_s: f64,
}

impl AxisModel {
    /// The law in f64.
    #[must_use]
    pub fn static_law(&self, temperature_scale: TemperatureScale) -> StaticLaw {
        StaticLaw { drift: self.drift.clone(), trim: self.trim.clone(), dead_band: self.dead_band, temperature_scale }
    }

    /// The axis's part of a record: its integers held against these models, and accepted as a device would accept them.
    ///
    /// # Errors
    /// [`LawRefused`], when the numbers do not fit or the table of edges disagrees with them.
    pub fn record(&self, temperature_scale: TemperatureScale) -> Result<AxisRecord, LawRefused> {
        let law = self.static_law(temperature_scale);
        let mut numbers = LawNumbers::new(&law, self.edges.as_ref(), self.low_pass)?;
        if let Some(HistoryModel { history, group_period_s }) = &self.history {
            let centre = law.trim.line.centre();
            let history = HistoryNumbers::new(history, &law.drift, centre, temperature_scale, *group_period_s)?;
            numbers.history = Some(history);
        }
        AxisLaw::from_numbers(&numbers)?;
        Ok(AxisRecord { law: numbers, start_up_mode: self.start_up_mode })
    }
}
