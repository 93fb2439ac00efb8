//! When a chamber has arrived where it was sent, and how long it has been held there. Pure: temperatures and times in.

use zerorate_core::units::{Celsius, Kelvins, Seconds};

use crate::instruments::InstrumentError;

/// A chamber is where it was sent when its air is this close.
pub(crate) const AT_SET_POINT: Kelvins = Kelvins(0.5);
/// A chamber that is held stays nearer than this: its regulation's ripple and overshoot are half of it.
const STRAYED: Kelvins = Kelvins(2.0);
/// A chamber slower than this on the way to a soak has failed: twenty hours a hundred kelvins.
const SLOWEST_KELVINS_PER_SECOND: f64 = 100.0 / 72_000.0;

/// When it is first told where a chamber on its way is.
const FIRST_TOLD: Seconds = Seconds(600.0);
/// How often it is told after that.
const TOLD_AGAIN: Seconds = Seconds(1800.0);
/// A chamber that comes no nearer for so long stands: the slowest that has not failed goes 2.5 K in it.
const STANDS: Seconds = Seconds(1800.0);

/// The way to a set point.
pub(crate) struct Way {
    to: Celsius,
    kelvins: Option<f64>,
    waited: Seconds,
    next_told: Seconds,
    /// The nearest that it has come, to half a kelvin, and when.
    nearest: (f64, Seconds),
}

/// What became of a chamber on its way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Gone {
    /// It is there.
    Arrived,
    /// It is not.
    On,
    /// It is not, and has not been for a while: a sentence of where it is and how long it is waited for.
    Told(String),
    /// It does not come nearer: a sentence that warns.
    Stands(String),
}

impl Way {
    /// The way that begins where the air is first seen.
    pub fn to(to: Celsius) -> Self {
        let nearest = (f64::INFINITY, Seconds(0.0));
        Self { to, kelvins: None, waited: Seconds(0.0), next_told: FIRST_TOLD, nearest }
    }

    /// Where the chamber has got, now that its air is there and so much time has gone by since it was last seen. A chamber
    /// that is away (NaN) is nowhere, and its time does not count.
    ///
    /// # Errors
    /// [`InstrumentError::NotReached`] of one that has had time enough.
    pub fn goes_on(&mut self, air: Celsius, since: Seconds) -> Result<Gone, InstrumentError> {
        let left = (air - self.to).0.abs();
        if left.is_nan() {
            return Ok(Gone::On);
        }
        if left <= AT_SET_POINT.0 {
            return Ok(Gone::Arrived);
        }
        let kelvins = *self.kelvins.get_or_insert(left);
        self.waited = self.waited + since;
        let most_s = 3600.0 + kelvins / SLOWEST_KELVINS_PER_SECOND;
        if self.waited.0 > most_s {
            let waited_min = self.waited.0 / 60.0;
            return Err(InstrumentError::NotReached { set_point_c: self.to.0, air_c: air.0, waited_min });
        }
        if left < self.nearest.0 - AT_SET_POINT.0 {
            self.nearest = (left, self.waited);
        }
        let waits = format!(
            "it is waited for until it is within {} K, for {:.0} min more at most",
            AT_SET_POINT.0,
            (most_s - self.waited.0) / 60.0
        );
        let stands = self.waited - self.nearest.1;
        if stands.0 >= STANDS.0 {
            self.nearest = (left, self.waited);
            self.next_told = self.waited + TOLD_AGAIN;
            return Ok(Gone::Stands(format!(
                "the chamber comes no nearer to {} C: for {:.0} min its air has been at {:.1} C, {left:.1} K off. See whether it runs, its door and its limits; {waits}",
                self.to.0,
                stands.0 / 60.0,
                air.0
            )));
        }
        if self.waited.0 >= self.next_told.0 {
            self.next_told = self.waited + TOLD_AGAIN;
            return Ok(Gone::Told(format!(
                "the chamber is on its way to {} C, its air at {:.1} C, {left:.1} K off, after {:.0} min; {waits}",
                self.to.0,
                air.0,
                self.waited.0 / 60.0
            )));
        }
        Ok(Gone::On)
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
            assert_eq!(way.goes_on(Celsius(air), STEP).unwrap() == Gone::Arrived, arrived, "{air}");
        }
    }

    /// A hundred kelvins in twenty hours, and an hour.
    #[test]
    fn a_chamber_that_does_not_come_there_has_failed() {
        let mut way = Way::to(Celsius(60.0));
        let hour = Seconds(3600.0);
        assert!((0..21).all(|_| way.goes_on(Celsius(-40.0), hour).unwrap() != Gone::Arrived));
        assert!(way.goes_on(Celsius(-40.0), hour).unwrap_err().to_string().contains("-40"));
    }

    /// What is told of a way to -40 C, by its minute; the air is a function of the minutes.
    fn told(air: impl Fn(f64) -> f64, minutes: u32) -> Vec<(u32, Gone)> {
        let mut way = Way::to(Celsius(-40.0));
        let told =
            (1..=minutes).map(|minute| (minute, way.goes_on(Celsius(air(f64::from(minute))), Seconds(60.0)).unwrap()));
        told.filter(|(_, gone)| !matches!(gone, Gone::On | Gone::Arrived)).collect()
    }

    #[test]
    fn who_waits_is_told_for_what_how_far_off_it_is_and_how_long_it_is_waited_for() {
        // From 20 C at half a kelvin a minute: two hours. The first is seen at 19.5 C: 59.5 K, 714 min and an hour.
        let told = told(|minute| 20.0 - 0.5 * minute, 125);
        let minutes: Vec<u32> = told.iter().map(|(minute, _)| *minute).collect();
        assert_eq!(minutes, [10, 40, 70, 100]);
        let Gone::Told(first) = &told[0].1 else { panic!("{told:?}") };
        for part in ["to -40 C", "at 15.0 C, 55.0 K off, after 10 min", "within 0.5 K", "for 764 min more at most"] {
            assert!(first.contains(part), "{part} is missing from: {first}");
        }
    }

    #[test]
    fn a_chamber_that_stands_is_told_after_half_an_hour_and_one_that_creeps_as_slowly_as_it_may_is_not() {
        // It goes for a quarter of an hour, and then ripples by 0.2 K.
        let stands = |minute: f64| f64::max(20.0 - 2.0 * minute, -10.0) + 0.2 * (2.0 * minute).sin();
        let told_of = told(stands, 80);
        let warned: Vec<(u32, &String)> = told_of
            .iter()
            .filter_map(|(minute, gone)| if let Gone::Stands(text) = gone { Some((*minute, text)) } else { None })
            .collect();
        let [(44..=46, text), (74..=76, _)] = warned[..] else { panic!("{told_of:?}") };
        assert!(text.contains("comes no nearer to -40 C: for 30 min") && text.contains(" K off"), "{text}");
        // A hundred kelvins in twenty hours.
        let creeps = told(|minute| 20.0 - minute / 12.0, 600);
        assert!(creeps.iter().all(|(_, gone)| matches!(gone, Gone::Told(_))), "{creeps:?}");
    }

    #[test]
    fn a_soak_is_of_the_time_in_which_the_chamber_was_there() {
        let mut hold = Hold::at(Celsius(60.0), Seconds(25.0));
        let airs = [60.3, f64::NAN, 59.0, 60.0];
        assert_eq!(airs.map(|air| hold.held(Celsius(air), STEP)), [Held::On, Held::On, Held::On, Held::Enough]);
        assert_eq!(Hold::at(Celsius(60.0), STEP).held(Celsius(62.5), STEP), Held::Strayed);
    }
}
