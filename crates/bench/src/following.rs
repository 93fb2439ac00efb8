//! Whether a board lies in the chamber: whether its own temperature follows the chamber's air. Pure: times and temperatures in.
//!
//! Nobody knows how slowly an honest board follows, nor where it was when it was first seen: it may come out of a box, or be warm
//! from a run before. So it is held against a bank of boards that follow as slowly as any may, each begun at another temperature: each of them
//! must have moved by something by now, and the least of these is what every board must have moved by. No reading is compared
//! with an air's: a sensor's zero may be off by any number of degrees, and a board under power is warmer than its air.

use zerorate_core::units::{Celsius, Kelvins, Seconds};

/// What the boards of the bank need to follow, unless they are soaked for longer: the hour of the paper's soak, after which
/// "everything inside is at one temperature" (docs/paper.md, S6).
const SLOWEST: Seconds = Seconds(3600.0);
/// They need it in so many stages, housing, board and package, each a time constant behind the one about it: so they begin later
/// than a board of one stage that is as slow.
const STAGES: usize = 3;
/// The bank begins at temperatures from one to the other in steps of the third: no chamber's air is beyond, and a board that began
/// between two of them has moved by a kelvin less than its neighbours at most.
const BEGUN_AT_C: (i16, i16, usize) = (-100, 200, 2);
/// What the least of the bank has moved by before anything is said: what a room does in an hour, a kelvin, is its share.
const LEAST: Kelvins = Kelvins(4.0);
/// A board that has moved by less than this share of the bank's least does not follow. Boards of one stage move by as much that have a
/// time constant of three hours, and by half of the least with two hours: no soak would warm them.
const SHARE: f64 = 0.25;
/// The bank's stages move on in steps of this at most, a twentieth of their time constant.
const STEP: Seconds = Seconds(60.0);

/// From where to where something was seen, degrees C.
#[derive(Debug, Clone, Copy)]
struct Extent(f64, f64);

impl Extent {
    const NONE: Self = Self(f64::INFINITY, f64::NEG_INFINITY);

    fn see(&mut self, c: f64) {
        *self = Self(self.0.min(c), self.1.max(c));
    }

    fn span(self) -> f64 {
        (self.1 - self.0).max(0.0)
    }
}

/// A board that does not follow: how far its reading has moved, the air, and the slowest of the bank, in so many minutes.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the board does not follow the chamber: in {minutes:.0} min the chamber's air has moved by {air_k:.0} K and the board's own temperature by {board_k:.1} K, where even the slowest that its soak would warm has moved by {slowest_k:.0} K. See whether the board lies in this chamber, and whether the air that the chamber tells is its own; if both is so, whether the board's temperature sensors are wired, and board.counts_per_celsius is theirs"
)]
pub struct LeftBehind {
    board_k: f64,
    air_k: f64,
    slowest_k: f64,
    minutes: f64,
}

/// A board that is watched from its first group on.
pub(crate) struct Following {
    slowest: Seconds,
    /// The stages of each of the bank, and where its last has been.
    bank: Vec<([f64; STAGES], Extent)>,
    air: Extent,
    /// The two axes' own readings.
    board: [Extent; 2],
    /// When it was first seen, and last.
    seen: Option<(Seconds, Seconds)>,
}

impl Following {
    /// A board that is soaked for so long before its ramps.
    pub fn new(soak: Seconds) -> Self {
        let (first, last, step) = BEGUN_AT_C;
        let bank = (first..=last).step_by(step).map(|c| ([f64::from(c); STAGES], Extent::NONE)).collect();
        Self { slowest: Seconds(soak.0.max(SLOWEST.0)), bank, air: Extent::NONE, board: [Extent::NONE; 2], seen: None }
    }

    /// Where the air is (NaN: nobody knows, and the time since does not count), and what the two axes read, in degrees by the set-up's scale.
    pub fn see(&mut self, time: Seconds, air: Celsius, board: [Celsius; 2]) -> Option<LeftBehind> {
        let (first, last) = self.seen.unwrap_or((time, time));
        self.seen = Some((first, time));
        for (extent, reading) in self.board.iter_mut().zip(board) {
            extent.see(reading.0);
        }
        if air.0.is_nan() {
            return None;
        }
        self.air.see(air.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a run's steps
        let steps = ((time - last).0 / STEP.0).ceil().max(0.0) as u32;
        let fades = -((last - time).0 / f64::from(steps.max(1)) * STAGES as f64 / self.slowest.0).exp_m1();
        let mut slowest_k = f64::INFINITY;
        for (stages, extent) in &mut self.bank {
            extent.see(stages[STAGES - 1]);
            for _ in 0..steps {
                stages.iter_mut().fold(air.0, |about, at| {
                    *at += (about - *at) * fades;
                    *at
                });
                extent.see(stages[STAGES - 1]);
            }
            slowest_k = slowest_k.min(extent.span());
        }
        // One sensor that moves is enough: what the other has is not that the board lies elsewhere.
        let board_k = self.board[0].span().max(self.board[1].span());
        let is_left = slowest_k >= LEAST.0 && board_k < SHARE * slowest_k;
        is_left.then(|| LeftBehind { board_k, air_k: self.air.span(), slowest_k, minutes: (time - first).0 / 60.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 1.5;

    /// The air of a run: from 25 to -40 C at a rate, an hour there, to +60 C, an hour there. Kelvins a minute; time in seconds.
    fn air(time_s: f64, k_per_min: f64) -> f64 {
        let rate = k_per_min / 60.0;
        let there = 65.0 / rate + 3600.0;
        if time_s < there { (25.0 - rate * time_s).max(-40.0) } else { (rate * (time_s - there) - 40.0).min(60.0) }
    }

    /// When a board is said not to follow, seconds; and how far it had moved then. `board` makes the next temperature of the last, of the
    /// air and of the time.
    fn said(k_per_min: f64, begun_c: f64, mut board: impl FnMut(f64, f64) -> f64) -> Option<(f64, LeftBehind)> {
        let mut following = Following::new(Seconds(3600.0));
        let groups = (0..).map(|group| f64::from(group) * PERIOD_S);
        let until = 165.0 / k_per_min * 60.0 + 7200.0;
        let mut first = Some(begun_c);
        groups.take_while(|time_s| *time_s < until).find_map(|time_s| {
            let air = air(time_s, k_per_min);
            let reading = first.take().unwrap_or_else(|| board(time_s, air));
            // A sensor whose zero is 12 K off, and one that does not move.
            let left = following.see(Seconds(time_s), Celsius(air), [Celsius(reading + 12.0), Celsius(0.0)])?;
            Some((time_s, left))
        })
    }

    /// Stages one behind the other, each of a time constant, all begun at one temperature: Euler's steps of a group.
    fn stages(begun_c: f64, time_constants_s: &[f64]) -> impl FnMut(f64, f64) -> f64 {
        let mut at: Vec<(f64, f64)> =
            time_constants_s.iter().map(|time_constant_s| (begun_c, *time_constant_s)).collect();
        move |_, air| {
            at.iter_mut().fold(air, |before, (at, time_constant_s)| {
                *at += (before - *at) * PERIOD_S / *time_constant_s;
                *at
            })
        }
    }

    #[test]
    fn no_board_that_follows_is_said_to_lie_elsewhere_however_slow_and_wherever_it_began() {
        let boards: [&[f64]; 7] =
            [&[2.0], &[150.0, 25.0], &[1800.0], &[7200.0], &[900.0; 4], &[1200.0; 3], &[2400.0; 2]];
        for k_per_min in [0.5, 1.0, 2.5, 5.0, 15.0] {
            for begun_c in [-60.0, -40.0, -30.0, -20.0, -8.0, 0.0, 25.0, 60.0, 110.0] {
                for board in boards {
                    let said = said(k_per_min, begun_c, stages(begun_c, board));
                    assert!(said.is_none(), "{board:?} s from {begun_c} C at {k_per_min} K/min: {said:?}");
                }
            }
        }
    }

    #[test]
    fn a_board_that_lies_in_the_room_is_seen_before_its_first_soak_has_ended() {
        // A room that goes up and down by 0.4 K in an hour and a half. The chamber is at its cold end after 26 minutes, and held for an hour.
        let room = |time_s: f64, _: f64| 22.0 + 0.4 * (time_s / 900.0).sin();
        let (time_s, left) = said(2.5, 22.0, room).unwrap();
        assert!((26.0 * 60.0..86.0 * 60.0).contains(&time_s), "{time_s}");
        assert!(
            (left.air_k - 65.0).abs() < 1e-9 && left.board_k < 1.0 && (left.minutes * 60.0 - time_s).abs() < 1e-6,
            "{left:?}"
        );
        // One that has just been switched on and warms by five kelvins is seen in the ramp's hour.
        let warms = |time_s: f64, _: f64| 22.0 + 5.0 * (1.0 - (-time_s / 300.0).exp());
        let (time_s, _) = said(2.5, 22.0, warms).unwrap();
        assert!(time_s < (86.0 + 60.0) * 60.0, "{time_s}");
    }

    #[test]
    fn a_chamber_that_stays_or_is_not_seen_says_nothing_of_a_board() {
        let mut following = Following::new(Seconds(60.0));
        for time_s in (0..200_000).step_by(10).map(f64::from) {
            let air = if time_s < 1000.0 { 25.1 } else { f64::NAN };
            assert_eq!(following.see(Seconds(time_s), Celsius(air), [Celsius(35.0); 2]), None);
        }
    }
}
