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
/// Taps by which the wiper is moved away, so that a recall has something to bring back.
const AWAY: u16 = 8;

/// What was checked after a store.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FirstTime {
    /// The tap that was stored.
    pub tap: u16,
    /// Whether the board carried the stores out without an SPI error.
    pub store_answered: bool,
    /// Readings of X and Y with the wiper at that tap, counts.
    pub before_counts: [f64; 2],
    /// With the wiper moved away, and recalled from the potentiometer's own memory.
    pub recalled: Recalled,
    /// The same after a power cycle; `None` where there was none.
    pub after_power_up: Option<Recalled>,
    /// Further apart than this the wiper is not where it was. Gyros come back up to a few counts off.
    #[serde(skip)]
    half_a_tap_counts: f64,
}

/// Readings of X and Y, counts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Recalled {
    /// With the wipers eight taps away.
    pub away_counts: [f64; 2],
    /// With the wipers where the potentiometer's memory has them.
    pub recalled_counts: [f64; 2],
}

impl FirstTime {
    /// What is not as it should be; nothing if all is.
    #[must_use]
    pub fn fault(&self) -> Option<&'static str> {
        let apart =
            |a: [f64; 2], b: [f64; 2]| a.into_iter().zip(b).map(|(a, b)| (a - b).abs() > self.half_a_tap_counts);
        let of = |recalled: &Recalled| {
            let is_back = !apart(recalled.recalled_counts, self.before_counts).any(|apart| apart);
            let moved = apart(recalled.away_counts, self.before_counts).all(|apart| apart);
            match (moved, is_back) {
                (false, _) => Some(
                    "the readings do not follow the wiper, so nothing shows where it is: check gyros, circuit and the potentiometer's SPI",
                ),
                (true, false) => Some(
                    "recalled from its own memory the wiper is more than half a tap from where it was stored: the potentiometer does not keep its tap; do this again, or change the part",
                ),
                (true, true) => None,
            }
        };
        if !self.store_answered {
            return Some(
                "the board counted an SPI error meanwhile: check the potentiometer's wiring, then do this again",
            );
        }
        [Some(&self.recalled), self.after_power_up.as_ref()].into_iter().flatten().find_map(of)
    }
}

impl Board {
    /// Writes both wipers to a tap, stores it for power-up, moves them away and has the potentiometer recall it. Then
    /// the board goes on in the modes in which it was met.
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
        let recalled = self.recall(tap, setup)?;
        self.go_on()?;
        let half_a_tap_counts = setup.nominal_counts_per_tap() / 2.0;
        let tap = tap.get();
        Ok(FirstTime { tap, store_answered, before_counts, recalled, after_power_up: None, half_a_tap_counts })
    }

    /// Waits until the board was switched off and on, and has the potentiometer recall its tap once more: a board that starts
    /// writes its wipers itself, so what it reads then says nothing of that memory.
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
        self.set_mode(&Axis::BOTH, super::Mode::Off, None)?;
        found.after_power_up = Some(self.recall(Taps::new(found.tap).unwrap_or(Taps::MIDDLE), setup)?);
        self.go_on()?;
        Ok(())
    }

    /// Puts the axes back in the modes in which the board was met: what it was at goes on.
    pub(super) fn go_on(&mut self) -> Result<(), ClientError> {
        for (axis, mode) in Axis::BOTH.into_iter().zip(self.identity.modes) {
            self.set_mode(&[axis], mode, None)?;
        }
        Ok(())
    }

    /// Moves the wipers away from a tap and has the potentiometer bring them back; then they are written to it.
    fn recall(&mut self, tap: Taps, setup: &SetUp) -> Result<Recalled, ClientError> {
        let away = Taps::new(tap.get() + AWAY).or_else(|| Taps::new(tap.get() - AWAY)).unwrap_or(tap);
        self.set_tap(&Axis::BOTH, away, None)?;
        let away_counts = self.readings(setup)?;
        self.device.order(Request::RecallPowerUpTap)?;
        let recalled_counts = self.readings(setup)?;
        self.set_tap(&Axis::BOTH, tap, None)?;
        Ok(Recalled { away_counts, recalled_counts })
    }

    pub(super) fn readings(&mut self, setup: &SetUp) -> Result<[f64; 2], ClientError> {
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
