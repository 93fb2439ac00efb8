//! Whether a group's temperature is to be believed.
//!
//! The law moves the wiper by the temperature alone, so a broken temperature reading would throw the tap. What is not
//! believed leaves tap and correction where the last believed temperature put them.

use zerorate_core::board::BoardNumbers;
use zerorate_core::group::GroupSums;
use zerorate_core::units::TemperatureCode;
use zerorate_core::wire::{FaultCounts, TemperatureCheck};

use crate::acquisition::Timing;

/// The fastest that a temperature moves, kelvins a second. The quickest real thing is the package behind air that jumps by
/// 100 K, 0.7 K/s by its time constant of 150 s; a chamber ramps at 2.5 K a minute.
const FASTEST_K_PER_S: u32 = 2;
/// What noise may add to it between two groups, in thirds of a sample's noise: 32 counts where that is 3. It is seven times the
/// rms difference of two groups of a single sample. Of the paper's 500 it is far more than enough.
const NOISE_THIRDS: u32 = 32;
/// Samples of a group scatter no more than this many times their noise. More is a glitch within the group.
const SCATTER_NOISES: u32 = 32;
/// Samples that scatter less than this part of their noise come of no sensor, but of a converter's last bit.
const STILL_PART: u32 = 4;
/// A jump that stays for so many groups is believed: the first is held, the second, and the third moves. At the paper's
/// rate that is 4.5 s, in which the fastest chamber moves 0.2 K: less than a hundredth of a tap, and nothing against a
/// thrown one.
const BELIEVED_AFTER: u8 = 3;
/// So many samples that stand still are stuck: two of the paper's groups. (A sensor quieter than a quarter of what its record
/// says may stand still by right; then holding its tap is the same as following it.)
const STUCK_SAMPLES: u32 = 1000;
/// A group's mean moves by so much with the last bit of a converter alone, counts.
const LAST_BIT_COUNTS: u32 = 1;
/// An axis that has not moved while the other moved by so many kelvins is stuck, however its last bits move: both gyros
/// stand on one board, and the paper finds their temperatures alike.
const OTHER_MOVES_K: u32 = 3;
/// It has not moved: so many thousandths of a kelvin, a count of the paper's board. A count it may always move.
const STANDS_MK: u32 = 30;

/// Steps of 1/256.
const Q8: u32 = 8;

/// What there is to believe by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Believable {
    /// The converter, and the sensors' scale and noise.
    pub(super) board: BoardNumbers,
    /// How long a group takes.
    pub(super) timing: Timing,
}

impl Believable {
    /// How far a temperature moves at most from one group to the next, with so many missed between them.
    fn furthest_codes(&self, missed: u32) -> u64 {
        let noise = (u64::from(self.board.temperature_noise_q8) * u64::from(NOISE_THIRDS) / 3) >> Q8;
        (noise + self.fastest_counts(u64::from(missed) + 1)) * u64::from(self.board.codes_per_count)
    }

    /// How far it moves in so many groups.
    fn fastest_counts(&self, groups: u64) -> u64 {
        let counts_per_s_q8 = u64::from(FASTEST_K_PER_S) * u64::from(self.board.counts_per_kelvin_q8);
        (groups.saturating_mul(self.timing.period_us()).saturating_mul(counts_per_s_q8) >> Q8) / 1_000_000
    }

    /// How far samples of a group scatter at most, by their noise or by the fastest ramp, 1/256 count rms.
    fn scatter_q8(&self) -> u32 {
        // Evenly spread over what is passed they scatter by 0.29 of it.
        let ramp = u32::try_from(self.fastest_counts(1) << Q8).unwrap_or(u32::MAX) / 2;
        (SCATTER_NOISES * self.board.temperature_noise_q8).max(ramp)
    }

    /// Kelvins in codes.
    fn codes(&self, thousandths: u32) -> u64 {
        let counts_q8 = u64::from(self.board.counts_per_kelvin_q8) * u64::from(thousandths) / 1000;
        (counts_q8 * u64::from(self.board.codes_per_count)) >> Q8
    }

    /// A converter's last bit in codes.
    const fn last_bit(&self) -> u64 {
        LAST_BIT_COUNTS as u64 * self.board.codes_per_count as u64
    }
}

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
        believable: Believable,
    ) -> (TemperatureCheck, Option<TemperatureCode>) {
        let Some(code) = sums.temperature_code(believable.board.codes_per_count) else {
            return (TemperatureCheck::Believed, self.believed);
        };
        let left_behind = self.is_left_behind(code, other, believable);
        let check = match self.judge(code, sums, missed, believable) {
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

    fn judge(
        &mut self,
        code: TemperatureCode,
        sums: &GroupSums,
        missed: u32,
        believable: Believable,
    ) -> TemperatureCheck {
        if sums.is_temperature_saturated(believable.board.full_scale) {
            return TemperatureCheck::Saturated;
        }
        if self.is_stuck(code, sums, believable) {
            return TemperatureCheck::Stuck;
        }
        if sums.temperature_scatters(believable.scatter_q8()) {
            return TemperatureCheck::Jumped;
        }
        let limit = believable.furthest_codes(missed);
        let near = |other: TemperatureCode| distance(code, other) <= limit;
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

    fn is_stuck(&mut self, code: TemperatureCode, sums: &GroupSums, believable: Believable) -> bool {
        let (since, samples) = match self.still {
            Some((still, samples)) if distance(still, code) <= believable.last_bit() => (still, samples),
            _ => (code, 0),
        };
        let is_still = !sums.temperature_scatters(believable.board.temperature_noise_q8 / STILL_PART);
        self.still = is_still.then(|| (since, samples.saturating_add(sums.n)));
        self.still.is_some_and(|(_, samples)| samples >= STUCK_SAMPLES)
    }

    /// Whether the axis stands still while the other moves.
    fn is_left_behind(
        &mut self,
        code: TemperatureCode,
        other: Option<TemperatureCode>,
        believable: Believable,
    ) -> bool {
        let Some(other) = other else { return false };
        let [own_then, other_then] = *self.moved.get_or_insert([code, other]);
        // Two codes within one count of each other, and one more, are told apart by rounding alone.
        let stands = believable.codes(STANDS_MK).max(believable.last_bit()) + believable.last_bit();
        if distance(code, own_then) >= stands {
            self.moved = Some([code, other]);
            return false;
        }
        distance(other, other_then) >= believable.codes(1000 * OTHER_MOVES_K)
    }
}

fn distance(a: TemperatureCode, b: TemperatureCode) -> u64 {
    u64::from(a.0.abs_diff(b.0))
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

    const PAPER: Believable = Believable { board: BoardNumbers::PAPER, timing: Timing::PAPER };

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
            let (check, code) = watch.check(sums, None, 0, PAPER);
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
        watch.check(&about(9000), None, 0, PAPER);
        assert_eq!(watch.clone().check(&about(9500), None, 0, PAPER).0, Jumped);
        assert_eq!(watch.check(&about(9500), None, 4, PAPER).0, Believed);
    }

    #[test]
    fn a_reading_that_does_not_move_is_stuck_from_its_second_group_on() {
        let stuck = checks(&[about(9000), flat(9000), flat(9000), flat(9000), about(9000)]);
        assert_eq!(stuck.map_checks(), [Believed, Believed, Stuck, Stuck, Believed]);
    }

    #[test]
    fn a_sensor_that_stands_still_is_stuck_though_the_converters_last_bit_goes_on_moving() {
        let last_bit = |counts: u16| {
            let mut sums = GroupSums::default();
            (0..500).for_each(|k: u16| sums.push(counts + (k * 7 % 11 + k / 100) % 2, 8200));
            sums
        };
        let stuck = checks(&[about(9000), last_bit(9000), last_bit(9000), last_bit(9001), about(9000)]);
        assert_eq!(stuck.map_checks(), [Believed, Believed, Stuck, Stuck, Believed]);
    }

    /// 16 bits, 100 counts a kelvin, 8 counts of noise: what is much on the paper's board is little there.
    #[test]
    fn another_board_is_judged_by_its_own_numbers() {
        let board = BoardNumbers::new(16, 100.0, 8.0).unwrap();
        let other = Believable { board, ..PAPER };
        let noisy = |counts: u16, wide: u16| {
            let mut sums = GroupSums::default();
            (0..500).for_each(|k: u16| sums.push(counts + k % 3 * wide, 40_000));
            sums
        };
        let check = |groups: &[GroupSums]| {
            let mut watch = TemperatureWatch::default();
            groups.iter().map(|sums| watch.check(sums, None, 0, other).0).collect::<std::vec::Vec<_>>()
        };
        // 3 K in a group and a half are too many, 2 K a second are not; the middle of 14 bits is no end.
        assert_eq!(check(&[noisy(30_000, 10), noisy(30_300, 10)]), [Believed, Believed]);
        assert_eq!(check(&[noisy(30_000, 10), noisy(30_500, 10)]), [Believed, Jumped]);
        assert_eq!(check(&[noisy(16_383, 10), noisy(65_515, 10)]), [Believed, Saturated]);
        // A scatter of 1.6 counts is a converter's, where the sensor's is 8; of 300 it is a glitch.
        assert_eq!(check(&[noisy(30_000, 2); 3]), [Believed, Stuck, Stuck]);
        assert_eq!(check(&[noisy(30_000, 370)]), [Jumped]);
    }

    #[test]
    fn a_sensor_that_stands_while_the_other_moves_is_stuck_whatever_its_last_bits_do() {
        let mut watch = TemperatureWatch::default();
        let mut check = |own: u16, other: u16| watch.check(&about(own), Some(TemperatureCode(4 * other)), 0, PAPER).0;
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
