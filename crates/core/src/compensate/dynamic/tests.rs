//! The integer history against the f64 one, over ramps and random walks, and the axis that runs it.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss)] // codes of a test

use std::vec::Vec;

use proptest::prelude::*;

use super::super::{
    AxisCompensation, AxisLaw, DriftNumbers, EdgeTable, LawNumbers, LowPass, Mode, StaticLaw, TrimNumbers,
};
use super::*;
use crate::drift::{Drift, History, HistoryState, Memory, Polynomial, Scale, Shape, Term, ValidRange};
use crate::group::GroupSums;
use crate::trim::{TapEffects, Trim, TrimLine};
use crate::units::{Counts, TemperatureScale};

const SCALE: TemperatureScale = TemperatureScale::QUARTER_COUNTS;
/// The reading aimed at.
const CENTRE: Counts = Counts(8200.0);
/// The board's groups: 500 scans of a millisecond.
const PERIOD_S: f64 = 0.5;

fn paper(offset: f64) -> Shape {
    let scale = Scale::spanning(8500.0, 11_900.0).unwrap();
    let raw = [13_435.7 + offset, -0.894_782, 0.375_298e-4];
    Shape::Polynomial(Polynomial::from_raw_coefficients(scale, &raw).unwrap())
}

fn law() -> StaticLaw {
    let line = TrimLine::new(-0.031_990_6, 0.0, Counts(8200.0), Taps::MIDDLE).unwrap();
    let valid = ValidRange::new(8500.0, 11_900.0).unwrap();
    StaticLaw {
        drift: Drift { shape: paper(0.0), valid },
        trim: Trim { line, measured: None },
        dead_band: 0.05,
        temperature_scale: SCALE,
    }
}

/// Hysteresis of up to 40 counts and a lag of the same size: a tenth of the paper's drift each.
fn history() -> History {
    let term = |memory, weight, behind, share| Term { memory, weight, behind, share };
    History::new(
        paper(-7.0),
        &[
            term(Memory::Play { half_width: 80.0 }, 0.1, 0.0, 0.2),
            term(Memory::Play { half_width: 400.0 }, -0.1, 0.0, 0.4),
            term(Memory::Lag { time_constant_s: 60.0 }, 0.2, 0.4, 0.2),
            term(Memory::Lag { time_constant_s: 960.0 }, 0.02, -0.1, 0.2),
        ],
    )
    .unwrap()
}

/// Both in the device's form, for a law.
fn fixed(law: &StaticLaw) -> (FixedDrift, FixedHistory) {
    let drift = DriftNumbers::new(&law.drift, SCALE).unwrap();
    let numbers = HistoryNumbers::new(&history(), &law.drift, Counts(0.0), SCALE, PERIOD_S).unwrap();
    // A dead band of 0.05 tap.
    let history = FixedHistory::from_numbers(&numbers, drift.first, drift.last, 3277).unwrap();
    (FixedDrift::from_numbers(&drift).unwrap(), history)
}

/// Both forms over a walk of codes, `None` a lost group: the largest difference of their drifts, counts.
fn largest_difference(walk: impl Iterator<Item = Option<u16>>) -> f64 {
    let (law, history) = (law(), history());
    let (fixed_drift, fixed) = fixed(&law);
    let (mut state, mut fixed_state) = (HistoryState::default(), FixedHistoryState::default());
    let mut largest = 0.0_f64;
    for code in walk {
        let temperature = code.map_or(f64::NAN, |code| SCALE.temperature(TemperatureCode(code)));
        history.advance(&law.drift, &mut state, temperature, PERIOD_S);
        let Some(code) = code.map(TemperatureCode) else {
            fixed_state.lose(1);
            continue;
        };
        fixed.advance(&mut fixed_state, code);
        let (by_f64, _) = history.evaluate(&state);
        let (by_integers, _) = fixed.drift(&fixed_state, fixed_drift.evaluate(code));
        largest = largest.max((by_f64 - by_integers.to_counts()).abs());
    }
    largest
}

/// The paper's ramp, 34 minutes up and down, with every third group of a minute lost.
#[test]
fn over_ramps_with_lost_groups_the_integers_are_the_f64_model() {
    let up = (0..4096_u32).map(|group| (33_000 + 4 * group) as u16);
    let walk = up.clone().chain(up.rev()).enumerate();
    let largest = largest_difference(walk.map(|(group, code)| (group / 120 % 5 != 2 || group % 3 > 0).then_some(code)));
    assert!(largest < 0.1, "{largest} counts");
}

proptest! {
    #[test]
    fn over_random_walks_the_integers_are_the_f64_model(
        start in 30_000..50_000_u16, steps in prop::collection::vec((-2000..2000_i32, 1..40_usize, 0..10_u8), 1..60),
    ) {
        let mut code = i32::from(start);
        let mut walk = std::vec![Some(start)];
        for (rise, groups, lost) in steps {
            for _ in 0..groups {
                code = (code + rise / groups as i32).clamp(0, 65_535);
                walk.push((lost > 2).then_some(u16::try_from(code).unwrap()));
            }
        }
        let largest = largest_difference(walk.into_iter());
        prop_assert!(largest < 0.1, "{} counts", largest);
    }

    #[test]
    fn the_tap_is_the_one_that_the_f64_trim_model_gives(
        drift in 7000.0..9500.0_f64, at in 300..700_u16, uneven in prop::collection::vec(20.0..40.0_f64, 40),
        measured in any::<bool>(),
    ) {
        let mut law = law();
        let mut effect = -600.0;
        let effects: Vec<Counts> = uneven.iter().map(|step| { effect += step; Counts(effect) }).collect();
        law.trim.measured = measured.then(|| TapEffects::new(Taps::new(490).unwrap(), &effects).unwrap());
        let (_, fixed) = fixed(&law);
        let effects = FixedEffects::from_numbers(&TrimNumbers::new(&law.trim).unwrap()).unwrap();
        let now = Taps::new(at).unwrap();
        let from_centre = Q16::from_counts(drift - 8200.0).unwrap();
        let tap = fixed.tap(&effects, now, from_centre.0);
        let position = law.trim.position(Counts(drift));
        let away = (position - f64::from(at)).abs();
        // Within a thousandth of a tap of an edge both answers are right.
        if away < 0.549 {
            prop_assert_eq!(tap, now);
        } else if away > 0.551 {
            prop_assert!((f64::from(tap.get()) - position).abs() < 0.501, "{} at {}", tap.get(), position);
        }
    }
}

fn group(code: u16) -> GroupSums {
    let mut sums = GroupSums::default();
    (0..500).for_each(|_| sums.push(code / 4, 8300));
    sums
}

fn dynamic_law() -> AxisLaw {
    let law = law();
    let edges = EdgeTable::solve(&law).unwrap();
    let mut numbers = LawNumbers::new(&law, Some(&edges), LowPass::NONE).unwrap();
    numbers.history = Some(HistoryNumbers::new(&history(), &law.drift, CENTRE, SCALE, PERIOD_S).unwrap());
    AxisLaw::from_numbers(&numbers).unwrap()
}

#[test]
fn an_axis_subtracts_the_dynamic_drift_and_says_when_it_is_known() {
    let law = dynamic_law();
    let mut axis = AxisCompensation::new(Some(&law), Taps::MIDDLE);
    axis.set_mode(Mode::Digital);
    let (static_law, history) = (self::law(), history());
    let mut state = HistoryState::default();
    let mut known_at = None;
    for step in 0..6000_u32 {
        let code = 34_000 + (2 * step).min(13_000) as u16;
        let code = code / 4 * 4;
        history.advance(&static_law.drift, &mut state, f64::from(code) / 4.0, PERIOD_S);
        let outcome = axis.close_group(Some(&law), &group(code));
        let (drift, knowledge) = history.evaluate(&state);
        let expected = 8300.0 - (drift - 8200.0);
        assert!((outcome.corrected.to_counts() - expected).abs() < 0.1, "at {code}: {outcome:?} {expected}");
        assert_eq!(outcome.move_to, None);
        if outcome.knowledge != knowledge {
            // A step or two apart where the share crosses the threshold.
            let share = history.known_share(&state);
            assert!((share - 0.95).abs() < 1e-3, "{share}");
        }
        if outcome.knowledge == Knowledge::Known {
            known_at = known_at.or(Some(step));
        }
    }
    // The wide play is known after 800 counts, 1600 groups; the long lag, of a fifth of the whole, is believed by three
    // quarters after as long as its time constant, 1920 groups.
    assert!(known_at.is_some_and(|at| (1700..2100).contains(&at)), "{known_at:?}");
}

#[test]
fn a_hybrid_axis_moves_its_wiper_by_the_dynamic_drift_and_a_trimmed_one_by_the_static() {
    let law = dynamic_law();
    let (static_law, history) = (self::law(), history());
    let mut state = HistoryState::default();
    let mut axes = [Mode::Hybrid, Mode::Trim].map(|mode| {
        let mut axis = AxisCompensation::new(Some(&law), Taps::MIDDLE);
        axis.set_mode(mode);
        axis
    });
    let mut apart = 0;
    for step in 0..3000_u16 {
        let code = (34_000 + 4 * step).min(45_000);
        history.advance(&static_law.drift, &mut state, f64::from(code) / 4.0, PERIOD_S);
        for axis in &mut axes {
            if let Some(tap) = axis.close_group(Some(&law), &group(code)).move_to {
                axis.wiper_written(Some(&law), tap);
            }
        }
        let (dynamic, _) = history.evaluate(&state);
        let (fixed, _) = static_law.drift(TemperatureCode(code));
        let [hybrid, trim] = [0, 1].map(|axis: usize| f64::from(axes[axis].tap().get()));
        assert!((hybrid - static_law.trim.position(Counts(dynamic))).abs() < 0.56);
        assert!((trim - static_law.trim.position(fixed)).abs() < 0.56);
        apart += u32::from((hybrid - trim).abs() > 0.5);
    }
    assert!(apart > 500, "the two laws ask for different taps: {apart}");
}

#[test]
fn empty_and_lost_groups_advance_the_history() {
    let law = dynamic_law();
    let run = |lost: bool| {
        let mut axis = AxisCompensation::new(Some(&law), Taps::MIDDLE);
        axis.set_mode(Mode::Digital);
        let mut last = Q16::default();
        for step in 0..2000_u16 {
            let code = 34_000 + 4 * step;
            match step % 10 {
                3 if lost => drop(axis.close_group(Some(&law), &GroupSums::default())),
                4 if lost => axis.lose_groups(1),
                _ => last = axis.close_group(Some(&law), &group(code)).corrected,
            }
        }
        last.to_counts()
    };
    assert!((run(true) - run(false)).abs() < 0.05, "{} {}", run(true), run(false));
}

#[test]
fn a_history_whose_numbers_do_not_fit_is_refused() {
    let law = law();
    let with = |memory, weight, period| {
        let history = History::new(paper(0.0), &[Term { memory, weight, behind: 0.0, share: 1.0 }]).unwrap();
        HistoryNumbers::new(&history, &law.drift, CENTRE, SCALE, period)
    };
    assert!(with(Memory::Play { half_width: 100.0 }, 0.1, 0.5).is_ok());
    assert!(with(Memory::Play { half_width: 100.0 }, 1e6, 0.5).is_err(), "weight");
    assert!(with(Memory::Play { half_width: 1e9 }, 0.1, 0.5).is_err(), "half-width");
    for period in [0.0, -1.0, f64::NAN] {
        assert!(with(Memory::Lag { time_constant_s: 60.0 }, 0.1, period).is_err(), "period {period}");
    }
}
