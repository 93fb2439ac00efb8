//! Drift and trim composed to the law that the device runs (S9; paper, 2.4, eq. 6): `N = N0 + a (V(T) - V0) + b`.

mod chatter;

use std::fmt;

use thiserror::Error;
use zerorate_core::board::BoardNumbers;
use zerorate_core::compensate::{EdgeError, EdgeTable, LawRefused, LowPass, Mode, StaticLaw, Unrepresentable};
use zerorate_core::drift::{Drift, History};
use zerorate_core::record::{AxisModel, DeviceRecord, HistoryModel, MAX_RECORD_BYTES, UnitSerial};
use zerorate_core::trim::Trim;
use zerorate_core::units::TemperatureScale;

pub use chatter::{ChatterWarning, QUIET_SIGMAS, chatter_warning, steepest_slope, steepest_slope_taps};

/// The widest dead band, in taps. From half a tap on, a tap is held when its neighbour's neighbour is already nearer.
pub const WIDEST_DEAD_BAND_TAPS: f64 = 0.5;

/// Why a law cannot be composed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ComposeError {
    /// The dead band is no part of a tap.
    #[error("a dead band of {dead_band} taps: it must be 0 to {WIDEST_DEAD_BAND_TAPS}")]
    DeadBand {
        /// The dead band given, taps.
        dead_band: f64,
    },
    /// The low-pass is none.
    #[error(
        "a low-pass that leaves {missing_at_first} of a step at the first sample and {missing_per_sample} a sample: both must be parts of a step, 0 to 1; check cut-off and sample period"
    )]
    LowPass {
        /// [`LowPass::missing_at_first`].
        missing_at_first: f64,
        /// [`LowPass::missing_per_sample`].
        missing_per_sample: f64,
    },
    /// A temperature code stands for no temperature.
    #[error("a temperature code of {step} from {zero}: the step must be above zero and both finite")]
    TemperatureScale {
        /// The temperature at code 0.
        zero: f64,
        /// The temperature of one code.
        step: f64,
    },
    /// The law's numbers do not fit the device.
    #[error(transparent)]
    Unrepresentable(Unrepresentable),
    /// A device would refuse the law, though it was composed for one: a fault of this program.
    #[error("a device would refuse the law ({0}): please report this")]
    Inconsistent(LawRefused),
    /// An axis's law is refused.
    #[error("axis {axis}: {refused}")]
    Axis {
        /// The axis's name.
        axis: &'static str,
        /// Why.
        refused: LawRefused,
    },
    /// The unit's serial does not fit.
    #[error("the serial '{serial}' is longer than the {} bytes that a device record holds", UnitSerial::new().capacity())]
    SerialTooLong {
        /// The serial.
        serial: String,
    },
    /// The record is longer than a device takes.
    #[error("the device record is longer than {MAX_RECORD_BYTES} bytes: use a smaller drift model")]
    TooLong,
}

impl From<LawRefused> for ComposeError {
    fn from(refused: LawRefused) -> Self {
        match refused {
            LawRefused::Unrepresentable(reason) => Self::Unrepresentable(reason),
            LawRefused::Edges(_) | LawRefused::Senseless(_) => Self::Inconsistent(refused),
        }
    }
}

/// A law whose wiper cannot follow the temperature: the drift is subtracted in numbers alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DigitalOnly {
    /// Why there is no table of edges.
    pub reason: EdgeError,
    /// The mode that was asked for at start-up, where it moves the wiper and became `digital`.
    pub instead_of: Option<Mode>,
}

impl fmt::Display for DigitalOnly {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "only the digital mode can run, for the wiper cannot follow: {}", self.reason)?;
        match self.instead_of {
            Some(mode) => write!(f, "; the axis starts in mode digital instead of {}", mode.name()),
            None => Ok(()),
        }
    }
}

/// A composed axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Composed {
    /// What the axis's part of a device record is made of.
    pub model: AxisModel,
    /// Set where the wiper cannot follow: the model is without edges.
    pub digital_only: Option<DigitalOnly>,
}

impl Composed {
    /// The same law with what the drift remembers, which modes digital and hybrid follow; `group_period_s` is the time
    /// from group to group on the device, seconds. [`compose`] checks that the device would accept it.
    #[must_use]
    pub fn with_history(mut self, history: Option<History>, group_period_s: f64) -> Self {
        self.model.history = history.map(|history| HistoryModel { history, group_period_s });
        self
    }
}

/// Composes one axis: solves eq. (6) for its table of edges and checks that the device would accept the law.
///
/// `dead_band` is in taps: the wiper moves when the position is more than half a tap and this away from it. A drift
/// that needs more taps than the part has, or more edges than the table holds, is no error: the axis then runs the
/// digital mode, and says why.
///
/// # Errors
/// [`ComposeError`], when a parameter makes no sense or the numbers do not fit the device's integers.
pub fn compose_axis(
    drift: Drift,
    trim: Trim,
    dead_band: f64,
    low_pass: LowPass,
    start_up_mode: Mode,
    temperature_scale: TemperatureScale,
) -> Result<Composed, ComposeError> {
    check(dead_band, low_pass, temperature_scale)?;
    let law = StaticLaw { drift, trim, dead_band, temperature_scale };
    let (edges, reason) = match EdgeTable::solve(&law) {
        Ok(edges) => (Some(edges), None),
        Err(reason) => (None, Some(reason)),
    };
    let digital_only =
        reason.map(|reason| DigitalOnly { reason, instead_of: start_up_mode.moves_wiper().then_some(start_up_mode) });
    let starts = digital_only.and_then(|digital_only| digital_only.instead_of).map_or(start_up_mode, |_| Mode::Digital);
    let StaticLaw { drift, trim, .. } = law;
    let model = AxisModel { drift, trim, dead_band, low_pass, start_up_mode: starts, edges, history: None };
    model.record(temperature_scale)?;
    Ok(Composed { model, digital_only })
}

/// Puts two axes, X then Y, together to a unit's record, and checks that a device would take it.
///
/// # Errors
/// [`ComposeError`], when the serial or the record is too long, or a law is refused.
pub fn compose(
    unit_serial: &str,
    temperature_scale: TemperatureScale,
    board: BoardNumbers,
    axes: &[AxisModel; 2],
) -> Result<DeviceRecord, ComposeError> {
    let unit = UnitSerial::try_from(unit_serial)
        .map_err(|_| ComposeError::SerialTooLong { serial: unit_serial.to_owned() })?;
    let record = DeviceRecord::new(unit, temperature_scale, board, axes)
        .map_err(|(axis, refused)| ComposeError::Axis { axis: axis.name(), refused })?;
    record.encode(&mut [0; MAX_RECORD_BYTES]).map_err(|_| ComposeError::TooLong)?;
    Ok(record)
}

fn check(dead_band: f64, low_pass: LowPass, scale: TemperatureScale) -> Result<(), ComposeError> {
    if !(0.0..=WIDEST_DEAD_BAND_TAPS).contains(&dead_band) {
        return Err(ComposeError::DeadBand { dead_band });
    }
    let LowPass { missing_at_first, missing_per_sample } = low_pass;
    // At the first sample all of a step may be missing still: the wiper was written as it was taken.
    if !((0.0..=1.0).contains(&missing_at_first) && (0.0..1.0).contains(&missing_per_sample)) {
        return Err(ComposeError::LowPass { missing_at_first, missing_per_sample });
    }
    let TemperatureScale { zero, step } = scale;
    if !(zero.is_finite() && step.is_finite() && step > 0.0) {
        return Err(ComposeError::TemperatureScale { zero, step });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
