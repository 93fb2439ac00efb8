//! When a chamber has arrived where it was sent, and how long it has been held there. Pure: temperatures and times in.

use zerorate_core::units::{Celsius, Kelvins, Seconds};

use crate::instruments::InstrumentError;

/// A chamber is where it was sent when its air is this close.
pub(crate) const AT_SET_POINT: Kelvins = Kelvins(0.5);
/// A chamber that is held stays nearer than this: its regulation's ripple and overshoot are half of it.
const STRAYED: Kelvins = Kelvins(2.0);
/// A chamber slower than this on the way to a soak has failed: twenty hours a hundred kelvins.
const SLOWEST_KELVINS_PER_SECOND: f64 = 100.0 / 72_000.0;

/// The way to a set point.
pub(crate) struct Way {
    to: Celsius,
    kelvins: Option<f64>,
    waited: Seconds,
}

impl Way {
    /// The way that begins where the air is first seen.
    pub fn to(to: Celsius) -> Self {
        Self { to, kelvins: None, waited: Seconds(0.0) }
    }

    /// Whether the chamber has arrived, now that its air is there and so much time has gone by since it was last seen. A chamber
    /// that is away (NaN) is nowhere, and its time does not count.
    ///
    /// # Errors
    /// [`InstrumentError::NotReached`] of one that has had time enough.
    pub fn has_ended(&mut self, air: Celsius, since: Seconds) -> Result<bool, InstrumentError> {
        let left = (air - self.to).0.abs();
        if left.is_nan() || left <= AT_SET_POINT.0 {
            return Ok(!left.is_nan());
        }
        let kelvins = *self.kelvins.get_or_insert(left);
        self.waited = self.waited + since;
        if self.waited.0 > 3600.0 + kelvins / SLOWEST_KELVINS_PER_SECOND {
            let waited_min = self.waited.0 / 60.0;
            return Err(InstrumentError::NotReached { set_point_c: self.to.0, air_c: air.0, waited_min });
        }
        Ok(false)
    }
}

/// How a soak goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Held {
    /// It was held long enough.
    Enough,
    /// It is to be held on.
    On,
    /// It has left its set point, and the soak begins anew once it is back.
    Strayed,
}

/// The time at a set point.
pub(crate) struct Hold {
    at: Celsius,
    left: Seconds,
}

impl Hold {
    /// So long at a set point.
    pub fn at(at: Celsius, time: Seconds) -> Self {
        Self { at, left: time }
    }

    /// The time that is left.
    pub fn left(&self) -> Seconds {
        self.left
    }

    /// The chamber was held for so long and its air is there now. Where nobody knows where it is (NaN), the time does not count.
    pub fn held(&mut self, air: Celsius, time: Seconds) -> Held {
        if (air - self.at).0.abs() > STRAYED.0 {
            return Held::Strayed;
        }
        if !air.0.is_nan() {
            self.left = Seconds(self.left.0 - time.0);
        }
        if self.left.0 > 0.0 { Held::On } else { Held::Enough }
    }

    /// What is said of one that has strayed.
    pub fn strayed(&self, air: Celsius) -> String {
        format!(
            "the chamber has left its set point of {} C and is at {:.1} C: the soak begins anew once it is back",
            self.at.0, air.0
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: Seconds = Seconds(10.0);

    #[test]
    fn a_chamber_has_arrived_within_half_a_kelvin_and_is_nowhere_while_it_is_away() {
        let mut way = Way::to(Celsius(-20.0));
        for (air, arrived) in [(20.0, false), (f64::NAN, false), (-19.4, false), (-19.6, true)] {
            assert_eq!(way.has_ended(Celsius(air), STEP).unwrap(), arrived, "{air}");
        }
    }

    /// A hundred kelvins in twenty hours, and an hour.
    #[test]
    fn a_chamber_that_does_not_come_there_has_failed() {
        let mut way = Way::to(Celsius(60.0));
        let hour = Seconds(3600.0);
        assert!((0..21).all(|_| !way.has_ended(Celsius(-40.0), hour).unwrap()));
        assert!(way.has_ended(Celsius(-40.0), hour).unwrap_err().to_string().contains("-40"));
    }

    #[test]
    fn a_soak_is_of_the_time_in_which_the_chamber_was_there() {
        let mut hold = Hold::at(Celsius(60.0), Seconds(25.0));
        let airs = [60.3, f64::NAN, 59.0, 60.0];
        assert_eq!(airs.map(|air| hold.held(Celsius(air), STEP)), [Held::On, Held::On, Held::On, Held::Enough]);
        assert_eq!(Hold::at(Celsius(60.0), STEP).held(Celsius(62.5), STEP), Held::Strayed);
    }
}
