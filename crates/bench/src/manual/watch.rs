//! What a chamber that cannot be asked is doing, from the device's own temperature reading.
//!
//! Pure: time and readings in, what was seen out. Times are those of groups, not of the wall clock.

use std::collections::VecDeque;

use zerorate_core::units::{Celsius, Counts, Seconds};

use crate::setup::soaks::FASTEST_K_PER_MIN;

/// A reading that has moved by this has begun to move: thirty times the noise of a group's mean.
const BEGUN_K: f64 = 0.3;
/// A set point nearer than this asks for no movement that could be seen to fail.
const NEAR_K: f64 = 2.0;
/// How long a person may take before they are reminded.
const FOLLOW_S: f64 = 300.0;
/// How long a reading may go on the wrong way after a chamber was turned round.
const TURN_S: f64 = 150.0;
/// A chamber that has arrived moves less than this, kelvins a minute: its regulation's ripple is half of it.
const ARRIVED_K_PER_MIN: f64 = 0.3;
/// A gyro that is as warm as the chamber moves less than this.
const SETTLED_K_PER_MIN: f64 = 0.15;
/// A ramp so many times faster than planned leaves the gyros' insides behind.
const TOO_FAST: f64 = 3.0;

/// Temperature readings in degrees C: anchored where the temperature is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadingScale {
    /// Counts a degree.
    pub counts_per_celsius: f64,
    /// A reading and its temperature.
    pub anchor: (Counts, Celsius),
}

impl ReadingScale {
    /// A reading in degrees C.
    #[must_use]
    pub fn celsius(&self, reading: Counts) -> Celsius {
        let (counts, at) = self.anchor;
        Celsius(at.0 + (reading - counts).0 / self.counts_per_celsius)
    }
}

/// What was seen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Seen {
    /// Nothing new.
    Nothing,
    /// Something does not follow; a sentence that says what, and what to look at.
    Warning(String),
    /// The ramp has begun.
    Begun,
    /// The soak has settled, or the ramp has ended at its set point.
    Settled,
}

/// The slope of the last readings.
#[derive(Debug, Clone)]
struct Slope {
    span_s: f64,
    readings: VecDeque<(f64, f64)>,
}

impl Slope {
    fn over(span_s: f64) -> Self {
        Self { span_s, readings: VecDeque::new() }
    }

    /// Kelvins a minute; `None` until the span is full. The later half's mean less the earlier one's: noise averages out.
    fn push(&mut self, t_s: f64, c: f64) -> Option<f64> {
        self.readings.push_back((t_s, c));
        let mut full = false;
        while self.readings.front().is_some_and(|&(first, _)| t_s - first > self.span_s) {
            self.readings.pop_front();
            full = true;
        }
        let half = self.readings.len() / 2;
        if !full || half == 0 {
            return None;
        }
        let mean = |part: &mut dyn Iterator<Item = &(f64, f64)>| {
            let (n, t, c) = part.fold((0.0, 0.0, 0.0), |(n, t, c), &(at, of)| (n + 1.0, t + at, c + of));
            (t / n, c / n)
        };
        let (t0, c0) = mean(&mut self.readings.iter().take(half));
        let (t1, c1) = mean(&mut self.readings.iter().skip(half));
        Some((c1 - c0) / (t1 - t0) * 60.0)
    }
}

/// The way to a set point and the time there.
#[derive(Debug, Clone)]
pub struct SoakWatch {
    /// How far the chamber was sent, kelvins.
    sent: f64,
    target: Celsius,
    hold: Seconds,
    slope: Slope,
    start: Option<f64>,
    arrived_s: Option<f64>,
    remind_s: f64,
    said_wrong_way: bool,
}

impl SoakWatch {
    /// A soak at `target` of a chamber that was at `from`, held for `hold` once it is reached, seen every `period`.
    #[must_use]
    pub fn new(from: Celsius, target: Celsius, hold: Seconds, period: Seconds) -> Self {
        let span_s = (hold.0 / 4.0).clamp(10.0 * period.0, 600.0);
        Self {
            sent: (target - from).0.abs(),
            target,
            hold,
            slope: Slope::over(span_s),
            start: None,
            arrived_s: None,
            remind_s: FOLLOW_S,
            said_wrong_way: false,
        }
    }

    /// A reading.
    pub fn see(&mut self, time: Seconds, reading: Celsius) -> Seen {
        let (t_s, c) = (time.0, reading.0);
        let start = *self.start.get_or_insert(c);
        let way = self.target.0 - start;
        let moved = (c - start) * way.signum();
        let slope = self.slope.push(t_s, c);
        // The readings' scale may be off by more than a chamber that was sent where it was has to go.
        let least = way.abs().min(self.sent);
        let is_far = least > NEAR_K;
        if is_far && moved < -NEAR_K && !self.said_wrong_way {
            self.said_wrong_way = true;
            return Seen::Warning(format!(
                "the reading goes the wrong way: {} C, and the chamber is to be at {}; check its set point",
                about(c),
                about(self.target.0)
            ));
        }
        self.said_wrong_way &= moved < 0.0;
        if is_far && moved.abs() < 1.0 && t_s > self.remind_s {
            self.remind_s = t_s + FOLLOW_S;
            return Seen::Warning(format!(
                "nothing has moved for {:.0} minutes: is the chamber on, and set to {} C?",
                t_s / 60.0,
                about(self.target.0)
            ));
        }
        let Some(slope) = slope.map(f64::abs) else { return Seen::Nothing };
        // Half the way at least: a chamber that has not set off stands still too.
        if slope > ARRIVED_K_PER_MIN || (is_far && moved < 0.5 * least) {
            self.arrived_s = None;
            return Seen::Nothing;
        }
        let arrived_s = *self.arrived_s.get_or_insert(t_s);
        if t_s - arrived_s >= self.hold.0 && slope < SETTLED_K_PER_MIN { Seen::Settled } else { Seen::Nothing }
    }

    /// What is odd about where it has settled, if anything is.
    #[must_use]
    pub fn oddity(&self, reading: Celsius) -> Option<String> {
        let way = self.start.map_or(0.0, |start| (self.target.0 - start).abs());
        let off = (reading - self.target).0;
        (off.abs() > f64::max(5.0, 0.2 * way)).then(|| {
            format!(
                "the reading has settled at about {} C by board.counts_per_celsius of the set-up, the chamber was to be at {}: check its set point, or that number",
                about(reading.0),
                about(self.target.0)
            )
        })
    }
}

/// A ramp.
#[derive(Debug, Clone)]
pub struct RampWatch {
    target: Celsius,
    way: f64,
    fastest: f64,
    rate: Slope,
    settling: Slope,
    extreme: Option<f64>,
    first: Option<f64>,
    begun: bool,
    remind_s: f64,
    said: [bool; 3],
}

impl RampWatch {
    /// A ramp from `from` to `target` that is planned to take `planned`, seen every `period`.
    #[must_use]
    pub fn new(from: Celsius, target: Celsius, planned: Seconds, period: Seconds) -> Self {
        let way = (target - from).0;
        let nominal = way.abs() / (planned.0 / 60.0);
        Self {
            target,
            way,
            fastest: f64::max(TOO_FAST * nominal, FASTEST_K_PER_MIN),
            rate: Slope::over(20.0 * period.0),
            settling: Slope::over((planned.0 / 6.0).clamp(20.0 * period.0, 600.0)),
            extreme: None,
            first: None,
            begun: false,
            remind_s: FOLLOW_S,
            said: [false; 3],
        }
    }

    /// A reading.
    pub fn see(&mut self, time: Seconds, reading: Celsius) -> Seen {
        let (t_s, c) = (time.0, reading.0);
        let way = self.way;
        let ahead = |of: f64| (c - of) * way.signum();
        let first = *self.first.get_or_insert(c);
        let rate = self.rate.push(t_s, c);
        if !self.begun {
            // What is left of the soak's settling goes the other way: the ramp begins at the turn.
            let extreme = self.extreme.filter(|&extreme| ahead(extreme) >= 0.0).unwrap_or(c);
            self.extreme = Some(extreme);
            if ahead(extreme) > BEGUN_K {
                self.begun = true;
                return Seen::Begun;
            }
            // The gyros' insides go on for a while where the ramp before was going.
            let goes_away = rate.is_some_and(|rate| rate * way.signum() < -ARRIVED_K_PER_MIN);
            if t_s > TURN_S && goes_away && ahead(first) < -NEAR_K && self.once(0) {
                return Seen::Warning(format!(
                    "the reading goes the wrong way: {} C, and the chamber is to go to {}; check its set point",
                    about(c),
                    about(self.target.0)
                ));
            }
            if t_s > self.remind_s {
                self.remind_s = t_s + FOLLOW_S;
                return Seen::Warning(format!(
                    "no ramp after {:.0} minutes: is the chamber on, and set to {} C?",
                    t_s / 60.0,
                    about(self.target.0)
                ));
            }
            return Seen::Nothing;
        }
        if rate.is_some_and(|rate| rate.abs() > self.fastest) && self.once(1) {
            return Seen::Warning(format!(
                "the ramp is too fast, {:.1} K a minute: over {:.1} the gyros' insides fall behind; limit the chamber's rate",
                rate.map_or(0.0, f64::abs),
                self.fastest
            ));
        }
        let extreme = self.extreme.unwrap_or(first);
        let still = self.settling.push(t_s, c).is_some_and(|slope| slope.abs() < SETTLED_K_PER_MIN / 3.0);
        if !still {
            return Seen::Nothing;
        }
        if ahead(extreme) > 0.8 * self.way.abs() {
            return Seen::Settled;
        }
        if self.once(2) {
            return Seen::Warning(format!(
                "the ramp stands still at about {} C, short of {}: check the chamber",
                about(c),
                about(self.target.0)
            ));
        }
        Seen::Nothing
    }

    fn once(&mut self, which: usize) -> bool {
        !std::mem::replace(&mut self.said[which], true)
    }
}

fn about(c: f64) -> String {
    format!("{c:+.0}")
}

#[cfg(test)]
mod tests;
