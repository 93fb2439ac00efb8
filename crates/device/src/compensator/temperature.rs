//! Whether a group's temperature is to be believed.
//!
//! The law moves the wiper by the temperature alone, so a broken temperature reading would throw the tap. What is not
//! believed leaves tap and correction where the last believed temperature put them.

use zerorate_core::group::{CODES_PER_COUNT, GroupSums};
use zerorate_core::units::TemperatureCode;
use zerorate_core::wire::{FaultCounts, TemperatureCheck};

use crate::acquisition::{FULL_SCALE, Timing};

/// The fastest that a temperature moves, counts a second: 2 K/s at the board's 34 counts a kelvin. The quickest real
/// thing is the package behind air that jumps by 100 K, 0.7 K/s by its time constant of 150 s; a chamber ramps at 2.5 K a
/// minute.
const FASTEST_COUNTS_PER_S: u64 = 68;
/// What noise may add to it between two groups, counts: one sample has 3 counts rms, and this is seven times the rms
/// difference of two groups of a single one. Of the paper's 500 it is far more than enough.
const NOISE_COUNTS: u64 = 32;
/// Samples of a group scatter no more than this, counts rms: thirty times the noise. More is a glitch within the group.
const SCATTER_COUNTS_RMS: u32 = 96;
/// A jump that stays for so many groups is believed: the first is held, the second, and the third moves. At the paper's
/// rate that is 4.5 s, in which the fastest chamber moves 0.2 K: less than a hundredth of a tap, and nothing against a
/// thrown one.
const BELIEVED_AFTER: u8 = 3;
/// So many samples without a count's change are stuck: two of the paper's groups. With noise of 3 counts rms not even ten
/// equal ones happen. (A sensor quieter than a tenth of a count may stand still by right; then holding its tap is the
/// same as following it.)
const STUCK_SAMPLES: u32 = 1000;

/// An axis that has not moved by a count while the other moved by 3 K is stuck, however its last bits move: both gyros
/// stand on one board, and the paper finds their temperatures alike.
const STANDS_COUNTS: u32 = 1;
const OTHER_MOVES_COUNTS: u32 = 102;

/// What is known of one axis's temperature.
#[derive(Debug, Clone, Default)]
pub(super) struct TemperatureWatch {
    believed: Option<TemperatureCode>,
    /// A temperature that was jumped to, and for how many groups.
    jumped: Option<(TemperatureCode, u8)>,
    /// A temperature that does not move, and for how many samples.
    still: Option<(TemperatureCode, u32)>,
    /// Where the axis last moved from, and the other axis's temperature then.
    moved: Option<[TemperatureCode; 2]>,
}

impl TemperatureWatch {
    /// The temperature that was believed last; `None` where none was yet.
    pub(super) const fn believed(&self) -> Option<TemperatureCode> {
        self.believed
    }

    /// Looks at a group that comes after so many missed ones, the other axis's temperature beside it: what is to be thought
    /// of its temperature, and the code that the law is to take; `None` where none was believed yet.
    pub(super) fn check(
        &mut self,
        sums: &GroupSums,
        other: Option<TemperatureCode>,
        missed: u32,
        timing: Timing,
    ) -> (TemperatureCheck, Option<TemperatureCode>) {
        let Some(code) = sums.temperature_code() else { return (TemperatureCheck::Believed, self.believed) };
        let left_behind = self.is_left_behind(code, other);
        let check = match self.judge(code, sums, missed, timing) {
            TemperatureCheck::Believed if left_behind => TemperatureCheck::Stuck,
            check => check,
        };
        match check {
            TemperatureCheck::Believed => (self.believed, self.jumped) = (Some(code), None),
            TemperatureCheck::Jumped => {}
            TemperatureCheck::Stuck | TemperatureCheck::Saturated => self.jumped = None,
        }
        (check, self.believed)
    }

    fn judge(&mut self, code: TemperatureCode, sums: &GroupSums, missed: u32, timing: Timing) -> TemperatureCheck {
        if sums.is_temperature_saturated(FULL_SCALE) {
            return TemperatureCheck::Saturated;
        }
        if self.is_stuck(code, sums) {
            return TemperatureCheck::Stuck;
        }
        if sums.temperature_scatters(SCATTER_COUNTS_RMS) {
            return TemperatureCheck::Jumped;
        }
        let limit = limit_codes(missed, timing);
        let near = |other: TemperatureCode| u64::from(code.0.abs_diff(other.0)) <= limit;
        if self.believed.is_none_or(near) {
            return TemperatureCheck::Believed;
        }
        let groups = match self.jumped {
            Some((other, groups)) if near(other) => groups + 1,
            _ => 1,
        };
        self.jumped = Some((code, groups));
        if groups < BELIEVED_AFTER { TemperatureCheck::Jumped } else { TemperatureCheck::Believed }
    }

    fn is_stuck(&mut self, code: TemperatureCode, sums: &GroupSums) -> bool {
        let samples = match self.still {
            Some((still, samples)) if still == code => samples,
            _ => 0,
        };
        self.still = (!sums.temperature_scatters(0)).then(|| (code, samples.saturating_add(sums.n)));
        self.still.is_some_and(|(_, samples)| samples >= STUCK_SAMPLES)
    }

    /// Whether the axis stands still while the other moves.
    fn is_left_behind(&mut self, code: TemperatureCode, other: Option<TemperatureCode>) -> bool {
        let Some(other) = other else { return false };
        let counts = |a: TemperatureCode, b: TemperatureCode| u32::from(a.0.abs_diff(b.0)) / CODES_PER_COUNT;
        let [own_then, other_then] = *self.moved.get_or_insert([code, other]);
        if counts(code, own_then) > STANDS_COUNTS {
            self.moved = Some([code, other]);
            return false;
        }
        counts(other, other_then) >= OTHER_MOVES_COUNTS
    }
}

/// How far a temperature moves at most from one group to the next, with so many missed between them.
fn limit_codes(missed: u32, timing: Timing) -> u64 {
    let counts =
        NOISE_COUNTS + (u64::from(missed) + 1).saturating_mul(timing.period_us() * FASTEST_COUNTS_PER_S) / 1_000_000;
    counts * u64::from(CODES_PER_COUNT)
}

/// Counts what was thought of a temperature.
pub(super) const fn count(check: TemperatureCheck, faults: &mut FaultCounts) {
    let counter = match check {
        TemperatureCheck::Believed => return,
        TemperatureCheck::Stuck => &mut faults.temperature_stuck,
        TemperatureCheck::Jumped => &mut faults.temperature_jumped,
        TemperatureCheck::Saturated => &mut faults.temperature_saturated,
    };
    *counter = counter.saturating_add(1);
}

#[cfg(test)]
mod tests {
    use super::*;
    use TemperatureCheck::{Believed, Jumped, Saturated, Stuck};

    /// A group of 500 samples about a temperature, with the sensor's noise.
    fn about(counts: u16) -> GroupSums {
        let mut sums = GroupSums::default();
        (0..500).for_each(|k: u16| sums.push(counts + k % 7 - 3, 8200));
        sums
    }

    fn flat(counts: u16) -> GroupSums {
        let mut sums = GroupSums::default();
        (0..500).for_each(|_| sums.push(counts, 8200));
        sums
    }

    fn checks(groups: &[GroupSums]) -> std::vec::Vec<(TemperatureCheck, Option<u16>)> {
        let mut watch = TemperatureWatch::default();
        let check = |sums| {
            let (check, code) = watch.check(sums, None, 0, Timing::PAPER);
            (check, code.map(|code| code.0 / 4))
        };
        groups.iter().map(check).collect()
    }

    #[test]
    fn one_bad_group_is_held_and_a_jump_that_stays_is_believed_at_the_third() {
        let bad = checks(&[about(9000), about(11_000), about(9001)]);
        assert_eq!(bad, [(Believed, Some(9000)), (Jumped, Some(9000)), (Believed, Some(9001))]);
        let stays = checks(&[about(9000), about(11_000), about(11_002), about(11_004), about(11_006)]);
        assert_eq!(stays[1..4], [(Jumped, Some(9000)), (Jumped, Some(9000)), (Believed, Some(11_004))]);
        assert_eq!(stays[4], (Believed, Some(11_006)));
        let jumping = checks(&[about(9000), about(11_000), about(5000), about(11_000), about(5000), about(13_000)]);
        assert!(jumping[1..].iter().all(|&held| held == (Jumped, Some(9000))), "{jumping:?}");
    }

    #[test]
    fn the_fastest_real_change_is_followed_and_lost_groups_allow_for_more() {
        // 2 K/s: 102 counts a group.
        let ramp: std::vec::Vec<_> = (0..20).map(|k| about(9000 + 102 * k)).collect();
        assert!(checks(&ramp).iter().all(|(check, _)| *check == Believed));
        let mut watch = TemperatureWatch::default();
        watch.check(&about(9000), None, 0, Timing::PAPER);
        assert_eq!(watch.clone().check(&about(9500), None, 0, Timing::PAPER).0, Jumped);
        assert_eq!(watch.check(&about(9500), None, 4, Timing::PAPER).0, Believed);
    }

    #[test]
    fn a_reading_that_does_not_move_is_stuck_from_its_second_group_on() {
        let stuck = checks(&[about(9000), flat(9000), flat(9000), flat(9000), about(9000)]);
        assert_eq!(stuck.map_checks(), [Believed, Believed, Stuck, Stuck, Believed]);
    }

    #[test]
    fn a_sensor_that_stands_while_the_other_moves_is_stuck_whatever_its_last_bits_do() {
        let mut watch = TemperatureWatch::default();
        let mut check =
            |own: u16, other: u16| watch.check(&about(own), Some(TemperatureCode(4 * other)), 0, Timing::PAPER).0;
        // Y warms by 3 K in thirty groups, and X does not; then it goes on.
        let stands: std::vec::Vec<_> = (0..40).map(|k| check(9000 + k % 2, 9100 + 4 * k)).collect();
        assert!(
            stands[..25].iter().all(|check| *check == Believed) && stands[27..].iter().all(|check| *check == Stuck)
        );
        assert_eq!(check(9010, 9260), Believed, "it moves again");
        // In a soak both stand.
        assert!((0..1000).all(|_| check(9010, 9260) == Believed));
    }

    #[test]
    fn a_reading_at_an_end_of_the_converter_is_never_believed_however_long_it_stays() {
        for end in [flat(0), flat(16_383)] {
            let mut groups = std::vec![about(9000)];
            groups.extend([end; 10]);
            let seen = checks(&groups);
            assert!(seen[1..].iter().all(|&held| held == (Saturated, Some(9000))), "{seen:?}");
        }
        assert_eq!(checks(&[flat(0)]), [(Saturated, None)], "nor as the first");
    }

    #[test]
    fn a_glitch_within_a_group_is_seen_by_its_scatter() {
        let mut glitch = about(9000);
        (0..25).for_each(|_| glitch.push(16_000, 8200));
        assert_eq!(checks(&[glitch, about(9000)])[0], (Jumped, None), "as the first group too");
        assert_eq!(checks(&[about(9000), glitch])[1], (Jumped, Some(9000)));
    }

    trait Checks {
        fn map_checks(&self) -> std::vec::Vec<TemperatureCheck>;
    }

    impl Checks for std::vec::Vec<(TemperatureCheck, Option<u16>)> {
        fn map_checks(&self) -> std::vec::Vec<TemperatureCheck> {
            self.iter().map(|(check, _)| *check).collect()
        }
    }
}
