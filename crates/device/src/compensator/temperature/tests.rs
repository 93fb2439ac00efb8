use super::*;
use TemperatureCheck::{Believed, Jumped, Saturated, Stuck};

const PAPER: Believable = Believable { board: BoardNumbers::PAPER, timing: Timing::PAPER, missed: 0 };

impl TemperatureWatch {
    /// A group of an axis that has no other beside it.
    fn check(&mut self, sums: &GroupSums, believable: Believable) -> Checked {
        let own = self.look(sums, believable);
        self.conclude(own, false, false)
    }
}

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
        let (check, code) = watch.check(sums, PAPER);
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
    watch.check(&about(9000), PAPER);
    assert_eq!(watch.clone().check(&about(9500), PAPER).0, Jumped);
    assert_eq!(watch.check(&about(9500), Believable { missed: 4, ..PAPER }).0, Believed);
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
        groups.iter().map(|sums| watch.check(sums, other).0).collect::<std::vec::Vec<_>>()
    };
    // 3 K in a group and a half are too many, 2 K a second are not; the middle of 14 bits is no end.
    assert_eq!(check(&[noisy(30_000, 10), noisy(30_300, 10)]), [Believed, Believed]);
    assert_eq!(check(&[noisy(30_000, 10), noisy(30_500, 10)]), [Believed, Jumped]);
    assert_eq!(check(&[noisy(16_383, 10), noisy(65_515, 10)]), [Believed, Saturated]);
    // A scatter of 1.6 counts is a converter's, where the sensor's is 8; of 300 it is a glitch.
    assert_eq!(check(&[noisy(30_000, 2); 3]), [Believed, Stuck, Stuck]);
    assert_eq!(check(&[noisy(30_000, 370)]), [Jumped]);
}

/// Both axes of a board, a group after the other: X's readings, then Y's.
fn both(groups: impl IntoIterator<Item = [GroupSums; 2]>) -> std::vec::Vec<[(TemperatureCheck, u16); 2]> {
    let mut watches = [TemperatureWatch::default(), TemperatureWatch::default()];
    let checked = groups.into_iter().map(|sums| check(watches.each_mut(), &sums, PAPER));
    checked.map(|both| both.map(|(check, code)| (check, code.unwrap().0 / 4))).collect()
}

#[test]
fn where_one_sensor_stands_with_its_noise_and_the_other_moves_neither_is_believed_until_it_moves() {
    // Y warms by 3 K in thirty groups, and X does not.
    let mut groups: std::vec::Vec<_> = (0..40).map(|k| [about(9000 + k % 2), about(9100 + 4 * k)]).collect();
    // X moves again, and goes on: Y is followed at once. In a soak both stand.
    groups.extend((0..1000).map(|_| [about(9010), about(9260)]));
    let seen = both(groups);
    let checks = |range: core::ops::Range<usize>, expected: [TemperatureCheck; 2]| {
        seen[range].iter().all(|&[x, y]| [x.0, y.0] == expected)
    };
    assert!(checks(0..26, [Believed; 2]) && checks(26..40, [Stuck, Jumped]), "{:?}", &seen[20..40]);
    assert!(seen[28..40].iter().all(|&[x, y]| x.1 <= 9001 && y.1 < 9100 + 4 * 28), "both are held");
    assert!(checks(40..1040, [Believed; 2]), "{:?}", &seen[40..50]);
    assert_eq!(seen[1039].map(|(_, code)| code), [9010, 9260]);
}

#[test]
fn a_sensor_that_stands_without_its_noise_is_blamed_alone() {
    let groups = (0..100).map(|k| [if k < 10 { about(9000) } else { flat(9000) }, about(9000 + 4 * k)]);
    let seen = both(groups);
    assert!(seen[12..].iter().all(|&[x, y]| x == (Stuck, 9000) && y.0 == Believed), "{seen:?}");
    assert_eq!(seen[99][1].1, 9396);
}

#[test]
fn a_sensor_that_jumps_and_stays_does_not_put_the_blame_on_the_one_that_stands() {
    let groups = (0..20).map(|k| [about(9000 + k % 2), about(if k < 5 { 9100 } else { 9400 })]);
    let seen = both(groups);
    assert!(seen.iter().all(|&[x, _]| x.0 == Believed), "{seen:?}");
    let of_y: std::vec::Vec<_> = seen[4..9].iter().map(|&[_, y]| y).collect();
    assert_eq!(of_y, [(Believed, 9100), (Jumped, 9100), (Jumped, 9100), (Believed, 9400), (Believed, 9400)]);
}

#[test]
fn a_sensor_that_runs_away_and_comes_back_is_believed_when_it_is_back() {
    let away = |k: u16| 9100 + 10 * if k < 30 { k.saturating_sub(5) } else { 55_u16.saturating_sub(k) };
    let seen = both((0..80).map(|k| [about(9000), about(away(k))]));
    assert!(seen[20..40].iter().all(|&[x, y]| (x.0, y.0) == (Stuck, Jumped)), "{seen:?}");
    assert!(seen.iter().all(|&[_, y]| y.1 < 9100 + 34 * 3 + 20), "Y is not followed further than that");
    assert!(seen[60..].iter().all(|&both| both == [(Believed, 9000), (Believed, 9100)]), "{:?}", &seen[55..]);
    // The same where it jumps back.
    let back = both((0..80).map(|k| [about(9000), about(if k < 40 { away(k.min(29)) } else { 9100 })]));
    assert!(back[39].map(|(check, _)| check) == [Stuck, Jumped] && back[60..] == seen[60..], "{back:?}");
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
