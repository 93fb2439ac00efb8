//! A chamber's profile for boards that log by themselves: ramps, soaks and cycles, a line of TOML each.

mod drive;

use std::fmt;
use std::path::Path;

use serde::Deserialize;
use zerorate_cal::source::in_quotes;
use zerorate_core::units::Celsius;
// What its times are of, for who plans with them.
pub use zerorate_core::units::Seconds;

pub use drive::{Pace, Watcher, drive};

/// Cycles beyond this are a slip of the keyboard: a year of them.
const MOST_STEPS: usize = 10_000;

/// Why a profile cannot be run.
#[derive(Debug, thiserror::Error)]
#[error("{name}: {reason}")]
pub struct ProfileError {
    name: String,
    reason: String,
}

/// One thing that the chamber does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// Goes there as fast as it can, and is held there.
    Soak {
        /// Where.
        at: Celsius,
        /// How long, once it is there.
        hold: Seconds,
    },
    /// Is led there at a rate, from where it was sent before.
    Ramp {
        /// Where.
        to: Celsius,
        /// How fast, kelvins a minute.
        k_per_min: f64,
    },
}

impl Step {
    /// Where it ends.
    #[must_use]
    pub const fn ends(self) -> Celsius {
        match self {
            Self::Soak { at, .. } => at,
            Self::Ramp { to, .. } => to,
        }
    }

    /// How long it takes about, begun at a temperature, in a chamber that goes at a rate where it is not led.
    #[must_use]
    pub fn takes(self, from: Celsius, chamber_k_per_min: f64) -> Seconds {
        let way = |k_per_min: f64| 60.0 * (self.ends() - from).0.abs() / k_per_min;
        match self {
            Self::Soak { hold, .. } => Seconds(way(chamber_k_per_min) + hold.0),
            Self::Ramp { k_per_min, .. } => Seconds(way(k_per_min)),
        }
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Soak { at, hold } => write!(f, "{} C held {} min", at.0, hold.0 / 60.0),
            Self::Ramp { to, k_per_min } => write!(f, "to {} C at {k_per_min} K/min", to.0),
        }
    }
}

/// What a chamber does, in order: cycles are their ramps and soaks.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// The steps.
    pub steps: Vec<Step>,
    /// As it was written.
    pub text: String,
}

/// A profile as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    steps: Vec<WrittenStep>,
}

/// Any of the three: which, the first key says.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct WrittenStep {
    soak_c: Option<f64>,
    ramp_c: Option<f64>,
    cycles: Option<u32>,
    between_c: Option<[f64; 2]>,
    k_per_min: Option<f64>,
    minutes: Option<f64>,
}

impl Profile {
    /// The limits of no chamber, for a profile that is only looked at.
    pub const ANYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    /// A profile to begin with, as text.
    pub const EXAMPLE: &'static str = "\
# What the chamber does, in order, a line each.
steps = [
    # As fast as it can to -20 C, and held there for an hour.
    { soak_c = -20, minutes = 60 },
    # Led to 60 C. Slowly, so that the sensor follows: the calibration is of this.
    { ramp_c = 60, k_per_min = 0.7 },
    { soak_c = 60, minutes = 30 },
    # And back: what is not the same on both ways is hysteresis.
    { ramp_c = -20, k_per_min = 0.7 },
    # To and fro three times, led, each end held for 20 minutes.
    { cycles = 3, between_c = [-20, 60], k_per_min = 1, minutes = 20 },
    { soak_c = 23, minutes = 10 },
]
";

    /// Reads a profile; no step may leave the chamber's limits, degrees C.
    ///
    /// # Errors
    /// [`ProfileError`].
    pub fn read(path: &Path, limits_c: [f64; 2]) -> Result<Self, ProfileError> {
        let name = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&name, text, limits_c),
            Err(error) => Err(ProfileError { name, reason: error.to_string() }),
        }
    }

    /// The same of a text, which messages call by a name.
    ///
    /// # Errors
    /// [`ProfileError`].
    pub fn parse(name: &str, text: String, limits_c: [f64; 2]) -> Result<Self, ProfileError> {
        let refused = |reason: String| ProfileError { name: name.to_owned(), reason };
        let written: Written = toml::from_str(&text).map_err(|error| refused(in_quotes(&error.to_string())))?;
        let mut steps = Vec::new();
        for (place, step) in written.steps.iter().enumerate() {
            let line = |reason: String| refused(format!("step {}: {reason}", place + 1));
            let own = step.steps().map_err(line)?;
            let outside = own.iter().map(|step| step.ends().0).find(|c| !(limits_c[0]..=limits_c[1]).contains(c));
            if let Some(outside) = outside {
                let [least, most] = limits_c;
                return Err(line(format!(
                    "{outside} C is outside of the chamber's limits, {least} to {most} C (chamber.limits_c)"
                )));
            }
            steps.extend(own);
            if steps.len() > MOST_STEPS {
                return Err(line(format!("more than {MOST_STEPS} ramps and soaks")));
            }
        }
        if steps.is_empty() {
            return Err(refused("it has no steps".to_owned()));
        }
        Ok(Self { steps, text })
    }

    /// How long each step takes about.
    #[must_use]
    pub fn times(&self, from: Celsius, chamber_k_per_min: f64) -> Vec<Seconds> {
        let mut at = from;
        let time = |step: &Step| step.takes(std::mem::replace(&mut at, step.ends()), chamber_k_per_min);
        self.steps.iter().map(time).collect()
    }
}

impl WrittenStep {
    /// What it stands for.
    fn steps(&self) -> Result<Vec<Step>, String> {
        let held = || {
            let minutes = self.minutes.ok_or("say how long it is held: minutes = 30")?;
            let is_right = minutes >= 0.0 && minutes.is_finite();
            is_right.then_some(Seconds(60.0 * minutes)).ok_or(format!("minutes = {minutes} is no time"))
        };
        let rate = || {
            let rate = self.k_per_min.ok_or("say how fast it goes: k_per_min = 0.7")?;
            let is_right = rate > 0.0 && rate.is_finite();
            is_right.then_some(rate).ok_or(format!("k_per_min = {rate} is no rate: both up and down it is above 0"))
        };
        let unused = |is_given: bool, key: &str, of: &str| match is_given {
            true => Err(format!("{key} means nothing in {of}")),
            false => Ok(()),
        };
        let ramp = |c: f64, k_per_min| Step::Ramp { to: Celsius(c), k_per_min };
        let soak = |c: f64, hold| Step::Soak { at: Celsius(c), hold };
        match (self.soak_c, self.ramp_c, self.cycles) {
            (Some(at), None, None) => {
                unused(self.k_per_min.is_some(), "k_per_min", "a soak, to which the chamber goes by itself: a ramp before it leads it there")?;
                unused(self.between_c.is_some(), "between_c", "a soak")?;
                Ok(vec![soak(at, held()?)])
            }
            (None, Some(to), None) => {
                unused(self.minutes.is_some(), "minutes", "a ramp, whose time comes of k_per_min: a soak after it holds the chamber")?;
                unused(self.between_c.is_some(), "between_c", "a ramp")?;
                Ok(vec![ramp(to, rate()?)])
            }
            (None, None, Some(cycles)) => {
                let [from, to] = self.between_c.ok_or("say between what: between_c = [-20, 60]")?;
                let (hold, rate) = (held()?, rate()?);
                let cycle = [ramp(from, rate), soak(from, hold), ramp(to, rate), soak(to, hold)];
                Ok((0..(cycles as usize).min(MOST_STEPS)).flat_map(|_| cycle).collect())
            }
            _ => Err("it is one of a soak (soak_c = -20, minutes = 60), a ramp (ramp_c = 60, k_per_min = 0.7), and cycles (cycles = 3, between_c = [-20, 60], k_per_min = 1, minutes = 20)".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Profile, String> {
        Profile::parse("night.toml", text.to_owned(), [-40.0, 85.0]).map_err(|error| error.to_string())
    }

    #[test]
    fn the_example_is_a_profile() {
        let profile = parsed(Profile::EXAMPLE).unwrap();
        assert_eq!(profile.steps.len(), 4 + 12 + 1);
        let told: Vec<String> = profile.steps[..2].iter().map(ToString::to_string).collect();
        assert_eq!(told, ["-20 C held 60 min", "to 60 C at 0.7 K/min"]);
        // By hand: 43 K at 2 K/min and an hour; 80 K at 0.7.
        let times = profile.times(Celsius(23.0), 2.0);
        assert!((times[0].0 - (21.5 * 60.0 + 3600.0)).abs() < 1e-9 && (times[1].0 - 80.0 / 0.7 * 60.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_no_step_is_refused_by_its_place_and_says_how_it_is_written() {
        for (steps, told) in [
            ("{ soak_c = 20 }", "step 1: say how long"),
            (
                "{ soak_c = 20, minutes = 1 }, { ramp_c = 90, k_per_min = 1 }",
                "step 2: 90 C is outside of the chamber's limits",
            ),
            ("{ ramp_c = 60 }", "how fast"),
            ("{ ramp_c = 60, k_per_min = -1 }", "is no rate"),
            ("{ ramp_c = 60, k_per_min = 1, minutes = 5 }", "minutes means nothing in a ramp"),
            ("{ soak_c = 60, k_per_min = 1, minutes = 5 }", "means nothing in a soak"),
            ("{ soak_c = nan, minutes = 5 }", "outside"),
            ("{ minutes = 5 }", "it is one of a soak"),
            ("{ soak_c = 1, ramp_c = 2 }", "it is one of a soak"),
            ("{ cycles = 3, k_per_min = 1, minutes = 20 }", "between what"),
            ("{ cycles = 4000000000, between_c = [0, 1], k_per_min = 1, minutes = 20 }", "more than 10000"),
            ("{ soak = 60 }", "unknown field"),
            ("", "no steps"),
        ] {
            let refused = parsed(&format!("steps = [{steps}]")).unwrap_err();
            assert!(refused.contains("night.toml") && refused.contains(told), "{steps}: {refused}");
        }
    }
}
