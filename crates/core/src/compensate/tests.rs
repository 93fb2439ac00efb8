//! The integer law against the f64 law, at every one of the 65 536 temperature codes.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // readings made into samples

use std::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::drift::{Coverage, Drift, Polynomial, Scale, Shape, Table, ValidRange};
use crate::group::GroupSums;
use crate::trim::{TapEffects, Trim, TrimLine};
use crate::units::{Counts, Taps, TemperatureCode, TemperatureScale};

fn codes() -> impl DoubleEndedIterator<Item = TemperatureCode> {
    (0..=u16::MAX).map(TemperatureCode)
}

fn law(shape: Shape, valid: (f64, f64), dead_band: f64) -> StaticLaw {
    let line = TrimLine::new(-0.031_990_6, 0.0, Counts(8200.0), Taps::MIDDLE).unwrap();
    StaticLaw {
        drift: Drift { shape, valid: ValidRange::new(valid.0, valid.1).unwrap() },
        trim: Trim { line, measured: None },
        dead_band,
        temperature_scale: TemperatureScale::QUARTER_COUNTS,
    }
}

/// Eq. (1), X, over a range of temperature counts.
fn paper_x(valid: (f64, f64), dead_band: f64) -> StaticLaw {
    let scale = Scale::spanning(valid.0, valid.1).unwrap();
    let raw = [13_435.7, -0.894_782, 0.375_298e-4];
    law(Shape::Polynomial(Polynomial::from_raw_coefficients(scale, &raw).unwrap()), valid, dead_band)
}

const WORKING: (f64, f64) = (8500.0, 11_900.0);
/// Past the vertex at 11 921 counts: the drift turns round.
const TURNING: (f64, f64) = (8500.0, 15_000.0);

/// The table says at every code what the f64 law says, with no dead band.
fn assert_table_is_the_law(law: &StaticLaw) {
    let table = EdgeTable::solve(law).unwrap();
    for code in codes() {
        let interval = table.intervals()[table.find(code)];
        assert_eq!(Some(interval.tap), law.tap(code), "at code {}", code.0);
    }
    table.check(law).unwrap();
}

/// The codes at which each of two walks switches tap, and to which.
fn switches(
    steps: impl Iterator<Item = TemperatureCode>,
    mut tap_at: impl FnMut(TemperatureCode) -> Taps,
) -> Vec<(u16, Taps)> {
    let mut last = None;
    let mut found = Vec::new();
    for code in steps {
        let tap = tap_at(code);
        if last.is_some_and(|before| before != tap) {
            found.push((code.0, tap));
        }
        last = Some(tap);
    }
    found
}

/// Swept up and down, each switch of the table is within one code of the f64 law's, to the same tap.
fn assert_sweeps_agree(law: &StaticLaw) {
    let table = EdgeTable::solve(law).unwrap();
    let sweep = || codes().chain(codes().rev());
    let mut interval = table.find(TemperatureCode(0));
    let by_table = switches(sweep(), |code| {
        interval = table.next(interval, code);
        table.intervals()[interval].tap
    });
    let mut tap = law.tap(TemperatureCode(0)).unwrap();
    let by_law = switches(sweep(), |code| {
        tap = law.next(tap, code);
        tap
    });
    assert_eq!(by_table.len(), by_law.len(), "as many switches");
    for (table, law) in by_table.iter().zip(&by_law) {
        assert_eq!(table.1, law.1, "to the same tap");
        assert!(table.0.abs_diff(law.0) <= 1, "table at {}, law at {}", table.0, law.0);
    }
}

/// What is to be subtracted from a reading taken at a temperature code and a tap: `V(T) + effect(N) - V0`.
fn correction(law: &StaticLaw, code: TemperatureCode, tap: Taps) -> f64 {
    (law.drift(code).0 + law.trim.effect(tap) - law.trim.line.centre()).0
}

/// The integer correction is within half a count of the f64 one at every code, at the law's own tap and at the middle.
fn assert_correction_is_close(law: &StaticLaw) {
    let axis = AxisLaw::new(law, None, LowPass::NONE).unwrap();
    for code in codes() {
        for tap in [law.tap(code).unwrap_or(Taps::MIDDLE), Taps::MIDDLE] {
            let error = axis.correction(code, tap).to_counts() - correction(law, code, tap);
            assert!(error.abs() <= 0.5, "off by {error} counts at code {}", code.0);
        }
    }
}

/// The same; but the ends are rounded to a code, and a drift that moves more than a count in one there is refused as too
/// coarse.
fn assert_correction_is_close_unless_steep_at_an_end(law: &StaticLaw) -> Result<(), TestCaseError> {
    match AxisLaw::new(law, None, LowPass::NONE) {
        Err(LawRefused::Unrepresentable(Unrepresentable::TooCoarse)) => {
            let slope_at = |t: f64| (law.drift.evaluate(t + 0.01).0 - law.drift.evaluate(t).0).abs() / 0.01;
            let steepest = slope_at(law.drift.valid.min()).max(slope_at(law.drift.valid.max() - 0.01));
            prop_assert!(steepest * law.temperature_scale.step > 0.9, "refused, with {steepest} counts a count");
        }
        _ => assert_correction_is_close(law),
    }
    Ok(())
}

/// Eq. (1), X, on a part whose taps are uneven by several counts, every one of them measured.
fn uneven(dead_band: f64) -> StaticLaw {
    let mut law = paper_x(WORKING, dead_band);
    let effects: Vec<Counts> =
        (-14..=8_i32).map(|k| Counts(31.26 * f64::from(k) + 3.0 * (f64::from(k) * 1.3).sin())).collect();
    law.trim.measured = TapEffects::new(Taps::new(497).unwrap(), &effects);
    assert!(law.trim.measured.is_some());
    law
}

#[test]
fn measured_taps_are_chosen_and_corrected_by_the_same_table_and_integers() {
    assert_table_is_the_law(&uneven(0.0));
    assert_sweeps_agree(&uneven(0.05));
    assert_sweeps_agree(&uneven(0.15));
    assert_correction_is_close(&uneven(0.05));
    // The tap is the one that brings the reading nearest to the centre, whatever the line says.
    let law = uneven(0.0);
    for code in (34_000..=47_600).map(TemperatureCode) {
        let left = |tap: Taps| correction(&law, code, tap).abs();
        let best = (490..=530).filter_map(Taps::new).min_by(|&a, &b| left(a).total_cmp(&left(b))).unwrap();
        let chosen = law.tap(code).unwrap();
        assert!(left(chosen) - left(best) < 1e-6, "at {}", code.0);
    }
}

#[test]
fn without_a_dead_band_the_table_is_the_law_at_every_code() {
    assert_table_is_the_law(&paper_x(WORKING, 0.0));
    assert_table_is_the_law(&paper_x(TURNING, 0.0));
}

#[test]
fn with_a_dead_band_every_switch_is_within_a_code_up_and_down() {
    for dead_band in [0.05, 0.15, 0.45] {
        assert_sweeps_agree(&paper_x(WORKING, dead_band));
        assert_sweeps_agree(&paper_x(TURNING, dead_band));
    }
}

#[test]
fn the_integer_correction_is_within_half_a_count_at_every_code() {
    assert_correction_is_close(&paper_x(WORKING, 0.0));
    assert_correction_is_close(&paper_x(TURNING, 0.0));
    // The whole of the scale, and a range of two codes.
    assert_correction_is_close(&paper_x((0.0, 16_383.75), 0.0));
    assert_correction_is_close(&paper_x((9000.0, 9000.25), 0.0));
}

/// docs/paper.md: the drift of about 440 counts is 14 taps.
#[test]
fn the_papers_drift_crosses_fourteen_taps() {
    let table = EdgeTable::solve(&paper_x(WORKING, 0.05)).unwrap();
    assert_eq!(table.intervals().len(), 15);
    assert!(table.intervals().windows(2).all(|w| w[1].tap.get() == w[0].tap.get() + 1));
}

#[test]
fn a_drift_that_turns_round_comes_back_to_its_taps() {
    let table = EdgeTable::solve(&paper_x(TURNING, 0.05)).unwrap();
    let taps: Vec<u16> = table.intervals().iter().map(|i| i.tap.get()).collect();
    let most = *taps.iter().max().unwrap();
    assert!(taps.first().unwrap() < &most && taps.last().unwrap() < &most, "{taps:?}");
}

/// A lobe that pokes into the dead band only must not move the wiper on its way past.
#[test]
fn a_turn_inside_the_dead_band_does_not_move_the_wiper() {
    let scale = Scale::spanning(8000.0, 12_000.0).unwrap();
    // Half a tap is 15.6 counts; the vertex reaches 17 counts, and the ends are at 0.
    let polynomial = Polynomial::new(scale, &[8217.0, 0.0, -17.0]).unwrap();
    let turning = law(Shape::Polynomial(polynomial), (8000.0, 12_000.0), 0.15);
    let table = EdgeTable::solve(&turning).unwrap();
    assert_eq!(table.intervals().len(), 3, "the nearest tap does change at the vertex");
    assert_eq!(table.intervals()[0].hold_up_to, u16::MAX);
    assert_sweeps_agree(&turning);
}

#[test]
fn a_law_beyond_the_part_or_the_table_is_refused_with_the_reason() {
    let scale = Scale::spanning(8000.0, 12_000.0).unwrap();
    let line =
        |span: f64| law(Shape::Polynomial(Polynomial::new(scale, &[8200.0, span]).unwrap()), (8000.0, 12_000.0), 0.05);
    assert!(matches!(EdgeTable::solve(&line(1200.0)), Err(EdgeError::TooManyIntervals { .. })));
    let out = EdgeTable::solve(&line(30_000.0)).unwrap_err();
    assert!(matches!(out, EdgeError::OutOfTaps { .. }));
    assert!(std::format!("{out}").contains("1023"));
    assert!(AxisLaw::new(&line(60_000.0), None, LowPass::NONE).is_err());
}

#[test]
fn a_table_that_disagrees_with_its_law_is_not_believed() {
    let law = paper_x(WORKING, 0.05);
    let table = EdgeTable::solve(&law).unwrap();
    let other = paper_x((8600.0, 11_900.0), 0.05);
    assert!(matches!(table.check(&other), Err(EdgeError::Disagrees { .. })));
    let unordered: EdgeTable = {
        let mut bytes = [0_u8; 2048];
        let mut reversed: Vec<Interval> = table.intervals().to_vec();
        reversed.reverse();
        postcard::from_bytes(postcard::to_slice(&reversed.as_slice(), &mut bytes).unwrap()).unwrap()
    };
    assert!(matches!(unordered.check(&law), Err(EdgeError::Malformed { .. })));
}

fn group_at(temperature: u16, zro: u16) -> GroupSums {
    let mut sums = GroupSums::default();
    (0..500).for_each(|_| sums.push(temperature, zro));
    sums
}

#[test]
fn trim_asks_for_a_tap_only_when_it_changes_and_corrects_nothing() {
    let law = paper_x(WORKING, 0.05);
    let table = EdgeTable::solve(&law).unwrap();
    let axis_law = AxisLaw::new(&law, Some(&table), LowPass::NONE).unwrap();
    let mut axis = AxisCompensation::new(Some(&axis_law), Taps::MIDDLE);
    axis.set_mode(Mode::Trim);
    let first = axis.close_group(Some(&axis_law), &group_at(8500, 8541));
    assert_eq!(first.move_to, law.tap(TemperatureCode(34_000)));
    assert_eq!(first.corrected, Q16(8541 << 16));
    axis.wiper_written(Some(&axis_law), first.move_to.unwrap());
    assert_eq!(axis.close_group(Some(&axis_law), &group_at(8500, 8541)).move_to, None);
    let outside = axis.close_group(Some(&axis_law), &group_at(8000, 8541));
    assert_eq!((outside.move_to, outside.coverage), (None, Coverage::Below));
}

/// Over a whole ramp the hybrid's corrected reading stays at the centre while the wiper walks through 14 taps.
#[test]
fn hybrid_leaves_no_saw_tooth_on_a_perfect_plant() {
    let law = paper_x(WORKING, 0.05);
    let table = EdgeTable::solve(&law).unwrap();
    let axis_law = AxisLaw::new(&law, Some(&table), LowPass::NONE).unwrap();
    let mut axis = AxisCompensation::new(Some(&axis_law), Taps::MIDDLE);
    axis.set_mode(Mode::Hybrid);
    let mut moves = 0;
    for temperature in 8500..=11_900_u16 {
        let code = TemperatureCode(temperature * 4);
        let reading = law.drift(code).0 + law.trim.effect(axis.tap());
        // Whole counts: the reading's own rounding is up to half a count.
        let zro = reading.0.round();
        let sums = group_at(temperature, zro as u16);
        axis.skip_samples(500);
        let outcome = axis.close_group(Some(&axis_law), &sums);
        assert!((outcome.corrected.to_counts() - 8200.0).abs() < 1.0, "at {temperature}");
        if let Some(tap) = outcome.move_to {
            moves += 1;
            axis.wiper_written(Some(&axis_law), tap);
        }
    }
    assert_eq!(moves, 15, "the first write and 14 taps");
}

#[test]
fn a_sample_is_corrected_by_the_last_group_and_the_settling_wiper() {
    let law = paper_x(WORKING, 0.05);
    let table = EdgeTable::solve(&law).unwrap();
    let low_pass = LowPass::first_order(40.0, 0.003, 0.0001);
    let axis_law = AxisLaw::new(&law, Some(&table), low_pass).unwrap();
    let mut axis = AxisCompensation::new(Some(&axis_law), Taps::MIDDLE);
    axis.set_mode(Mode::Hybrid);
    assert_eq!(axis.sample(8541), Q16(8541 << 16), "before the first group nothing is known");
    axis.skip_samples(499);
    let tap = axis.close_group(Some(&axis_law), &group_at(8500, 8541)).move_to.unwrap();
    axis.wiper_written(Some(&axis_law), tap);
    let step = law.trim.effect(tap).0;
    for k in 0..20 {
        let come = 1.0 - (-2.0 * std::f64::consts::PI * 40.0 * (0.003 * f64::from(k + 1) - 0.0001)).exp();
        let reading = law.drift(TemperatureCode(34_000)).0.0 + step * come;
        let corrected = axis.sample(reading.round() as u16).to_counts();
        assert!((corrected - 8200.0).abs() < 0.6, "sample {k}: {corrected}");
    }
}

#[test]
fn an_empty_group_and_a_missing_calibration_hold_the_wiper() {
    let mut axis = AxisCompensation::new(None, Taps::MIDDLE);
    axis.set_mode(Mode::Hybrid);
    let outcome = axis.close_group(None, &group_at(9000, 8300));
    assert_eq!((outcome.move_to, outcome.corrected), (None, Q16(8300 << 16)));
    let empty = axis.close_group(None, &GroupSums::default());
    assert_eq!((empty.move_to, empty.coverage), (None, Coverage::Invalid));
}

/// Found by chance: knots that lie between codes, and a drift that turns sharply at them.
#[test]
fn a_steep_table_whose_knots_lie_between_codes_is_corrected_as_closely_as_any() {
    let valid = (3_544.392_951_456_605, 4_044.392_951_456_605);
    let knots = [8000.0, 8000.0, 8_384.305_520_526_714, 8_087.200_707_608_347, 8_364.232_030_447_734];
    let shape = Shape::Table(Table::new(Scale::spanning(valid.0, valid.1).unwrap(), &knots).unwrap());
    assert_correction_is_close(&law(shape, valid, 0.0));
}

/// Found by chance: within the range every code is close, and below it the end, which lies between two codes, is not.
#[test]
fn a_drift_that_is_steep_where_it_is_held_is_refused() {
    let valid = (1_449.401_306_666_164_4, 1_949.401_306_666_164_4);
    let coefficients = [8200.0, 0.0, 0.0, -47.697_586_920_828_684, 129.687_573_568_726_6, -134.389_795_429_515_7];
    let scale = Scale::spanning(valid.0, valid.1).unwrap();
    let shape = Shape::Polynomial(Polynomial::new(scale, &coefficients).unwrap());
    let refused = AxisLaw::new(&law(shape, valid, 0.0), None, LowPass::NONE).unwrap_err();
    assert!(matches!(refused, LawRefused::Unrepresentable(Unrepresentable::TooCoarse)), "{refused}");
}

/// The codes before the first knot are passed over, those past the last one stand at its level.
#[test]
fn a_table_is_level_beyond_its_knots_however_far_the_range_reaches() {
    for (coldest, hottest) in [(9000.0, 9200.0), (8000.0, 12_000.0), (11_900.0, 12_400.0), (9_999.9, 10_000.7)] {
        let scale = Scale::spanning(coldest, hottest).unwrap();
        let shape = Shape::Table(Table::new(scale, &[8100.0, 8200.0, 8150.0, 8220.0]).unwrap());
        assert_correction_is_close(&law(shape, WORKING, 0.0));
    }
}

/// Found by chance: a turn that reaches another tap at one code alone.
#[test]
fn a_tap_of_a_single_code_at_a_turn_is_in_the_table() {
    let valid = (1000.0, 1500.0);
    let knots = [8_000.0, 8_247.080_721_860_155, 8_000.0];
    let shape = Shape::Table(Table::new(Scale::spanning(valid.0, valid.1).unwrap(), &knots).unwrap());
    assert_sweeps_agree(&law(shape, valid, 0.0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_polynomial_law_agrees_with_its_table_and_its_integers(
        coefficients in prop::collection::vec(-150.0..150.0_f64, 1..=5),
        first in 1000.0..8000.0_f64, span in 500.0..8000.0_f64, dead_band in 0.0..0.4_f64,
    ) {
        let valid = (first, first + span);
        let scale = Scale::spanning(valid.0, valid.1).unwrap();
        let mut all = std::vec![8200.0];
        all.extend(coefficients);
        let shape = Shape::Polynomial(Polynomial::new(scale, &all).unwrap());
        assert_table_is_the_law(&law(shape.clone(), valid, 0.0));
        let law = law(shape, valid, dead_band);
        assert_sweeps_agree(&law);
        assert_correction_is_close_unless_steep_at_an_end(&law)?;
    }

    /// What an axis remembers to be quick changes nothing: it asks for what the table says, whatever happens to wiper
    /// and mode in between.
    #[test]
    fn an_update_asks_for_what_the_table_says(
        events in prop::collection::vec((0..8_u8, 30_000..62_000_u16), 1..400), dead_band in 0.0..0.4_f64,
    ) {
        let law = paper_x(TURNING, dead_band);
        let table = EdgeTable::solve(&law).unwrap();
        let axis_law = AxisLaw::new(&law, Some(&table), LowPass::NONE).unwrap();
        let mut axis = AxisCompensation::new(Some(&axis_law), Taps::MIDDLE);
        let (mut mode, mut tap, mut interval) = (Mode::Off, Taps::MIDDLE, None);
        let mut code = 34_000_u16;
        for (event, number) in events {
            match event {
                0 => {
                    mode = [Mode::Off, Mode::Trim, Mode::Digital, Mode::Hybrid][usize::from(number % 4)];
                    interval = None;
                    axis.set_mode(mode);
                }
                1 => {
                    tap = Taps::new(490 + number % 40).unwrap();
                    axis.wiper_written(Some(&axis_law), tap);
                }
                // A small step, and a jump.
                2..=6 => code = code.saturating_add_signed(i16::try_from(number % 601).unwrap() - 300),
                _ => code = number,
            }
            let code = TemperatureCode(code);
            let wanted = mode.moves_wiper().then(|| {
                let now = interval.map_or_else(|| table.find(code), |before| {
                    let held: Interval = table.intervals()[before];
                    let holds = (held.hold_down_to..=held.hold_up_to).contains(&code.0);
                    if holds { before } else { table.find(code) }
                });
                interval = Some(now);
                table.intervals()[now].tap
            });
            let asked = axis.update(&axis_law, code);
            prop_assert_eq!(asked, wanted.filter(|&wanted| wanted != tap));
            // Every other write fails.
            if let Some(asked) = asked.filter(|_| number % 2 == 0) {
                tap = asked;
                axis.wiper_written(Some(&axis_law), tap);
            }
        }
    }

    #[test]
    fn any_table_law_agrees_with_its_table_and_its_integers(
        knots in prop::collection::vec(8000.0..8400.0_f64, 2..=9),
        first in 1000.0..8000.0_f64, span in 500.0..8000.0_f64, dead_band in 0.0..0.4_f64,
    ) {
        let valid = (first, first + span);
        let shape = Shape::Table(Table::new(Scale::spanning(valid.0, valid.1).unwrap(), &knots).unwrap());
        // Up and down by a dozen taps eight times is refused, and rightly.
        let solved = EdgeTable::solve(&law(shape.clone(), valid, 0.0));
        prop_assume!(!matches!(solved, Err(EdgeError::TooManyIntervals { .. })));
        assert_table_is_the_law(&law(shape.clone(), valid, 0.0));
        let law = law(shape, valid, dead_band);
        assert_sweeps_agree(&law);
        assert_correction_is_close_unless_steep_at_an_end(&law)?;
    }
}
