//! A board's first set-up: the middle tap becomes that of power-up.

use std::time::Duration;

use serde::Serialize;
use zerorate_core::units::Axis;
use zerorate_core::wire::Request;

use super::{Board, LiveGroup, Taps};
use crate::client::ClientError;
use crate::setup::SetUp;

/// Stores that the potentiometer's non-volatile registers bear (MAX5494 data sheet).
pub const MOST_STORES: u32 = 50_000;
/// Groups averaged to compare readings: the noise of such a mean is far below a tap's 31 counts.
const GROUPS: u32 = 4;
/// Further apart than this before and after a power cycle the wiper is not where it was: half a tap, counts. Gyros come
/// back up to a few counts off.
const HALF_A_TAP: f64 = 16.0;

/// What was checked after a store.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FirstTime {
    /// The tap that was stored.
    pub tap: u16,
    /// Whether the board carried the stores out without an SPI error.
    pub store_answered: bool,
    /// Readings of X and Y with the wiper at that tap, counts.
    pub before_counts: [f64; 2],
    /// The same after a power cycle; `None` where there was none.
    pub after_counts: Option<[f64; 2]>,
}

impl FirstTime {
    /// Whether everything that was checked is as it should be.
    #[must_use]
    pub fn passed(&self) -> bool {
        let apart = |after: [f64; 2]| after.iter().zip(self.before_counts).any(|(a, b)| (a - b).abs() > HALF_A_TAP);
        self.store_answered && !self.after_counts.is_some_and(apart)
    }
}

impl Board {
    /// Writes both wipers to a tap, stores it for power-up, and reads the board at that tap.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn store_power_up_tap(&mut self, tap: Taps, setup: &SetUp) -> Result<FirstTime, ClientError> {
        let errors = self.faults()?.trim_errors;
        self.set_mode(&Axis::BOTH, super::Mode::Off, None)?;
        self.set_tap(&Axis::BOTH, tap, None)?;
        self.device.order(Request::StorePowerUpTap)?;
        let store_answered = self.faults()?.trim_errors == errors;
        let before_counts = self.readings(setup)?;
        Ok(FirstTime { tap: tap.get(), store_answered, before_counts, after_counts: None })
    }

    /// Waits until the board was switched off and on, and reads it again at the tap that it starts with. A board that has
    /// gone to work with a calibration is put back there.
    ///
    /// # Errors
    /// [`ClientError::NoRestart`], or whatever `look` says.
    pub fn check_after_power_cycle<E: From<ClientError>>(
        &mut self,
        found: &mut FirstTime,
        setup: &SetUp,
        patience: Duration,
        look: impl FnMut() -> Result<(), E>,
    ) -> Result<(), E> {
        self.identity = self.device.await_restart(patience, look)?;
        self.started = false;
        if let Some(tap) = Taps::new(found.tap).filter(|_| self.identity.running) {
            self.set_mode(&Axis::BOTH, super::Mode::Off, None)?;
            self.set_tap(&Axis::BOTH, tap, None)?;
        }
        found.after_counts = Some(self.readings(setup)?);
        Ok(())
    }

    fn readings(&mut self, setup: &SetUp) -> Result<[f64; 2], ClientError> {
        self.watch()?;
        let mut sums = [0.0; 2];
        // The first may have begun before the wiper was written.
        self.device.next_group()?;
        for _ in 0..GROUPS {
            let group = LiveGroup::of(&self.device.next_group()?, setup);
            sums.iter_mut().zip(&group.axes).for_each(|(sum, axis)| *sum += axis.zro_counts);
        }
        self.leave()?;
        Ok(sums.map(|sum| sum / f64::from(GROUPS)))
    }
}
