//! What a run is going to do, and how long it takes, before it begins.
//!
//! Times are of the chamber and the board; how fast a chamber goes and a person answers is assumed. A chamber is taken to
//! need the planned time of a ramp for the whole way of it, and a part of that for a part of the way.

use std::fmt;

use zerorate_core::compensate::Mode;
use zerorate_core::units::{Axis, Seconds};

use crate::setup::{GROUPS_A_SOAK, ROOM_SOAK, SetUp};

/// Settings of the wiper at each voltage of the trim experiment: the middle tap, and two or three tries of the search.
const SETTINGS_A_POINT: f64 = 4.0;
/// Taps of a working range: a drift of 440 counts needs 14, a large one a hundred.
const TAPS_SWEPT: f64 = 40.0;

/// A part of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The ramp that is fitted.
    FullTemperature,
    /// The trim experiment.
    TrimExperiment,
    /// A compensation test.
    Test(Mode, Axis),
    /// The soaks to compare with.
    Soaks,
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FullTemperature => f.write_str("full-temperature test"),
            Self::TrimExperiment => f.write_str("trim experiment"),
            Self::Test(mode, axis) => {
                write!(f, "compensation test, {} {}", axis.name().to_uppercase(), mode.name())
            }
            Self::Soaks => f.write_str("soaks to compare with"),
        }
    }
}

impl Part {
    /// What the chamber does in it, in words: temperatures, times, and how fast its ramps are, kelvins a minute.
    #[must_use]
    pub fn chamber(self, setup: &SetUp, rate: f64) -> String {
        let chamber = &setup.chamber;
        let (cold, hot, room) = (chamber.cold_c, chamber.hot_c, chamber.room_c);
        let held = chamber.soak_s / 60.0;
        let back = format!(", back at {rate:.1} K/min");
        let ramp = |goes_back| {
            let back = if goes_back { back.as_str() } else { "" };
            format!("{cold} C held {held:.0} min, to {hot} C at {rate:.1} K/min{back}")
        };
        match self {
            Self::FullTemperature => ramp(chamber.cooling_ramp),
            Self::TrimExperiment => format!("{room} C held {:.0} min, and on", ROOM_SOAK.0 / 60.0),
            Self::Test(_, axis) => ramp(axis == Axis::X),
            Self::Soaks => {
                let soaks: Vec<String> = setup.soaks().iter().map(|soak| soak.0.to_string()).collect();
                let each = if soaks.len() > 1 { "each " } else { "" };
                format!("{} C, {each}held {held:.0} min", soaks.join(", "))
            }
        }
    }
}

/// The parts of a run in their order, each with the time that it takes.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The parts.
    pub parts: Vec<(Part, Seconds)>,
}

impl Plan {
    /// The plan of a whole run by a set-up.
    #[must_use]
    pub fn of(setup: &SetUp) -> Self {
        let chamber = &setup.chamber;
        let period_s = setup.group_period().0;
        let ramp_s = f64::from(chamber.ramp_groups) * period_s;
        let way_s = |from: f64, to: f64| ramp_s * ((to - from) / (chamber.hot_c - chamber.cold_c)).abs();
        let cold_s = chamber.soak_s + f64::from(chamber.soak_groups) * period_s;
        let mut at = chamber.room_c;
        let mut parts = Vec::new();
        let mut add = |part, soak_c: f64, held_s: f64, ends_c: f64| {
            let way = way_s(at, soak_c);
            at = ends_c;
            parts.push((part, Seconds(way + held_s)));
        };

        let (cold, hot, room) = (chamber.cold_c, chamber.hot_c, chamber.room_c);
        let (ramps, end) = if chamber.cooling_ramp { (2.0, cold) } else { (1.0, hot) };
        add(Part::FullTemperature, cold, cold_s + ramps * ramp_s, end);
        let settings = f64::from(setup.trim.points) * SETTINGS_A_POINT + TAPS_SWEPT;
        // A group goes by until a wiper has settled.
        let experiment_s = settings * f64::from(setup.trim.groups_per_point + 1) * period_s;
        add(Part::TrimExperiment, room, ROOM_SOAK.0 + experiment_s, room);
        for mode in [Mode::Trim, Mode::Hybrid] {
            add(Part::Test(mode, Axis::X), cold, cold_s + 2.0 * ramp_s, cold);
            add(Part::Test(mode, Axis::Y), cold, cold_s + ramp_s, hot);
        }
        let (mut soaks_s, mut from) = (0.0, hot);
        let soaks = setup.soaks();
        for soak in &soaks {
            soaks_s += way_s(from, soak.0) + chamber.soak_s + f64::from(GROUPS_A_SOAK) * period_s;
            from = soak.0;
        }
        if !soaks.is_empty() {
            parts.push((Part::Soaks, Seconds(soaks_s)));
        }
        Self { parts }
    }

    /// The same where some of it was carried through before: `left` is how much of a part is still to do, 0 to 1. A part that
    /// is done takes no time.
    #[must_use]
    pub fn less_what_is_done(mut self, left: impl Fn(Part) -> f64) -> Self {
        self.parts.iter_mut().for_each(|(part, time)| *time = Seconds(time.0 * left(*part)));
        self
    }

    /// The parts from a place on that are still to do.
    #[must_use]
    pub fn left_from(&self, place: usize) -> usize {
        self.parts.iter().skip(place).filter(|(_, time)| time.0 > 0.0).count()
    }

    /// Where a part stands in it.
    #[must_use]
    pub fn place(&self, part: Part) -> Option<usize> {
        self.parts.iter().position(|(own, _)| *own == part)
    }

    /// The time from the beginning of a part to the end of the last.
    #[must_use]
    pub fn time_from(&self, place: usize) -> Seconds {
        Seconds(self.parts.iter().skip(place).map(|(_, time)| time.0).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_run_has_seven_parts_and_without_soaks_six() {
        let plan = Plan::of(&SetUp::paper());
        assert_eq!(plan.parts.len(), 7);
        // 25 to -40 C is 0.65 of the way: 39 minutes; an hour's soak, 20 groups, an hour's ramp.
        assert!((plan.parts[0].1.0 - (2340.0 + 3600.0 + 30.0 + 3600.0)).abs() < 1e-6, "{plan:?}");
        let without = SetUp::parse("[chamber]\nsoaks_c = []\n", "x").unwrap();
        let without = Plan::of(&without);
        assert_eq!((without.parts.len(), without.place(Part::Soaks)), (6, None));
        assert!(plan.time_from(0).0 > without.time_from(0).0 + 11.0 * 3600.0);
        let resumed = plan.clone().less_what_is_done(|part| match part {
            Part::FullTemperature | Part::TrimExperiment => 0.0,
            Part::Soaks => 0.5,
            Part::Test(..) => 1.0,
        });
        assert_eq!((resumed.parts.len(), resumed.left_from(0)), (7, 5));
        let [first, second, .., soaks] = &plan.parts[..] else { panic!() };
        let gone = first.1.0 + second.1.0 + 0.5 * soaks.1.0;
        assert!((plan.time_from(0).0 - resumed.time_from(0).0 - gone).abs() < 1e-6);
        let last = without.place(Part::Test(Mode::Hybrid, Axis::Y)).unwrap();
        assert!((without.time_from(last).0 - without.parts[5].1.0).abs() < 1e-9);
    }
}
