//! From a board's calibration to the record that its device takes.

use thiserror::Error;
use zerorate_core::board::BoardNumbers;
use zerorate_core::record::{AxisModel, DeviceRecord};
use zerorate_core::units::{Axis, TemperatureScale};

use super::{Calibration, Kind};
use crate::compose::{ComposeError, DigitalOnly, compose, compose_axis};
use crate::units::RateUnit;

/// A device record, and which of its axes can only run the digital mode.
#[derive(Debug, Clone, PartialEq)]
pub struct MadeRecord {
    /// The record.
    pub record: DeviceRecord,
    /// What it was made of, X then Y.
    pub models: [AxisModel; 2],
    /// The axes whose wiper cannot follow, and why.
    pub digital_only: Vec<(Axis, DigitalOnly)>,
}

/// Why a calibration makes no device record.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NoDeviceRecord {
    /// It is the calibration of a log.
    #[error("this is the calibration of a log: only an analogue board's makes a device record")]
    NotABoard,
    /// The unit's serial is missing.
    #[error("the calibration names no unit (unit_serial): a device takes only its own record; calibrate with a serial")]
    NoSerial,
    /// The temperature's code is missing.
    #[error("the calibration does not say what a temperature code stands for (temperature_scale)")]
    NoTemperatureScale,
    /// No board is like it.
    #[error(
        "the calibration's board makes no sense (board): a converter has 8 to 16 bits, and counts a kelvin and noise are above 0"
    )]
    NoSuchBoard,
    /// An axis has a history, and nothing says what time it runs by.
    #[error(
        "axis {axis} has a history, and the calibration does not say the time from group to group (group_period_s)"
    )]
    NoGroupPeriod {
        /// The axis's name.
        axis: &'static str,
    },
    /// An axis is missing.
    #[error("the calibration has no axis {axis}: a board has x and y")]
    NoAxis {
        /// The axis's name.
        axis: &'static str,
    },
    /// An axis has no trim model.
    #[error("axis {axis} has no trim model: run the trim experiment")]
    NoTrim {
        /// The axis's name.
        axis: &'static str,
    },
    /// An axis is not in counts.
    #[error("axis {axis} is in {unit}: a device works in counts")]
    NotInCounts {
        /// The axis's name.
        axis: &'static str,
        /// Its unit.
        unit: RateUnit,
    },
    /// An axis cannot be composed.
    #[error("axis {axis}: {reason}")]
    Axis {
        /// The axis's name.
        axis: &'static str,
        /// Why.
        reason: ComposeError,
    },
    /// The axes cannot be put together.
    #[error(transparent)]
    Record(#[from] ComposeError),
}

impl Calibration {
    /// The record for the board's device: eq. (6) solved for each axis.
    ///
    /// # Errors
    /// [`NoDeviceRecord`], when it is no board's calibration, something is missing, or a law cannot be composed.
    pub fn to_device_record(&self) -> Result<MadeRecord, NoDeviceRecord> {
        if self.kind != Kind::AnalogueBoard {
            return Err(NoDeviceRecord::NotABoard);
        }
        let serial = self.unit_serial.as_deref().ok_or(NoDeviceRecord::NoSerial)?;
        let scale = self.temperature_scale.ok_or(NoDeviceRecord::NoTemperatureScale)?;
        let board = match &self.board {
            None => BoardNumbers::PAPER,
            Some(scale) => scale.numbers().ok_or(NoDeviceRecord::NoSuchBoard)?,
        };
        let mut digital_only = Vec::new();
        let mut axis = |axis| self.axis_model(axis, scale, &mut digital_only);
        let models = [axis(Axis::X)?, axis(Axis::Y)?];
        Ok(MadeRecord { record: compose(serial, scale, board, &models)?, models, digital_only })
    }

    fn axis_model(
        &self,
        axis: Axis,
        scale: TemperatureScale,
        digital_only: &mut Vec<(Axis, DigitalOnly)>,
    ) -> Result<AxisModel, NoDeviceRecord> {
        let name = axis.name();
        let calibration = self.axes.get(name).ok_or(NoDeviceRecord::NoAxis { axis: name })?;
        if calibration.rate_unit != RateUnit::Counts {
            return Err(NoDeviceRecord::NotInCounts { axis: name, unit: calibration.rate_unit });
        }
        let trim = calibration.trim.clone().ok_or(NoDeviceRecord::NoTrim { axis: name })?;
        let composed = compose_axis(
            calibration.drift().clone(),
            trim.trim,
            trim.dead_band_taps,
            trim.low_pass,
            trim.start_up_mode,
            scale,
        )
        .map_err(|reason| NoDeviceRecord::Axis { axis: name, reason })?;
        digital_only.extend(composed.digital_only.map(|why| (axis, why)));
        match (&calibration.fit.model.history, self.group_period_s) {
            (None, _) => Ok(composed.model),
            (Some(_), None) => Err(NoDeviceRecord::NoGroupPeriod { axis: name }),
            (history, Some(period_s)) => Ok(composed.with_history(history.clone(), period_s).model),
        }
    }
}
