//! How every run begins: the board anew, and at rest.

use zerorate_core::compensate::Mode;
use zerorate_core::units::{Axis, Taps};
use zerorate_core::wire::{Identity, Request};

use super::Session;
use crate::error::BenchError;
use crate::instruments::Cycled;

impl Session<'_> {
    /// Power off and on, acquisition stopped, both axes uncompensated at the middle tap. A board that holds a calibration
    /// goes to work with it as soon as power comes, and would compensate what a run is to show.
    ///
    /// # Errors
    /// [`BenchError`], among them [`BenchError::NotAtRest`].
    pub fn begin(&mut self) -> Result<(), BenchError> {
        match self.bench.power.cycle()? {
            Cycled::Done => {
                self.bench.device.restarted();
                self.bench.device.identify()?;
            }
            Cycled::Asked => self.await_power()?,
            Cycled::LeftOn => {
                self.bench.device.identify()?;
            }
        }
        // First of all: modes and taps then hold at once, and no group of the board's own gets among a run's.
        self.bench.device.order(Request::SetAcquisition { run: false })?;
        self.bench.device.discard_groups();
        for axis in Axis::BOTH {
            self.bench.device.order(Request::SetMode { axis, mode: Mode::Off })?;
        }
        let middle = self.setup.middle();
        self.bench.device.set_taps([middle, middle])?;
        at_rest(&self.bench.device.identify()?, middle)
    }
}

/// Holds a board to what it was told, before a ramp of hours rests on it.
fn at_rest(board: &Identity, middle: Taps) -> Result<(), BenchError> {
    for (axis, (mode, tap)) in Axis::BOTH.into_iter().zip(board.modes.into_iter().zip(board.taps)) {
        if (mode, tap) != (Mode::Off, middle) {
            return Err(BenchError::NotAtRest { axis, mode, tap, middle });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use zerorate_core::units::GroupNumber;
    use zerorate_core::wire::{CalibrationState, ResetCause, WIRE_VERSION};

    use super::*;

    #[test]
    fn a_board_that_goes_on_compensating_or_is_at_another_tap_is_refused() {
        let board = Identity {
            wire_version: WIRE_VERSION,
            unit: Default::default(),
            firmware: [0, 1, 0],
            samples_per_group: 500,
            sample_period_us: 3000,
            calibration: CalibrationState::InUse,
            group: GroupNumber(0),
            running: false,
            taps: [Taps::MIDDLE; 2],
            modes: [Mode::Off; 2],
            reset: ResetCause::Power,
        };
        assert!(at_rest(&board, Taps::MIDDLE).is_ok());
        let refused = |board| at_rest(&board, Taps::MIDDLE).unwrap_err().to_string();
        let told = refused(Identity { modes: [Mode::Off, Mode::Hybrid], ..board.clone() });
        assert!(told.contains("axis y") && told.contains("mode hybrid"), "{told}");
        let told = refused(Identity { taps: [Taps::LAST, Taps::MIDDLE], ..board });
        assert!(told.contains("axis x") && told.contains("tap 1023"), "{told}");
    }
}
