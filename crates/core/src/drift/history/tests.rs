use std::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::drift::{Polynomial, Scale, ValidRange};

fn line(at_zero: f64, slope: f64) -> Shape {
    Shape::Polynomial(
        Polynomial::from_raw_coefficients(Scale::spanning(-20.0, 80.0).unwrap(), &[at_zero, slope]).unwrap(),
    )
}

fn drift() -> Drift {
    Drift { shape: line(5.0, 0.1), valid: ValidRange::new(-20.0, 80.0).unwrap() }
}

fn play(half_width: f64) -> Term {
    Term { memory: Memory::Play { half_width }, weight: 0.5, behind: 0.0, share: 1.0 }
}

fn lag(time_constant_s: f64) -> Term {
    Term { memory: Memory::Lag { time_constant_s }, weight: 0.5, behind: 0.0, share: 1.0 }
}

/// `m - T` of a history of one term after each temperature, one a second.
fn ahead(term: Term, temperatures: &[f64]) -> Vec<f64> {
    let history = History::new(line(0.0, 0.0), &[term]).unwrap();
    let mut state = HistoryState::default();
    temperatures
        .iter()
        .map(|&temperature| {
            history.advance(&drift(), &mut state, temperature, 1.0);
            history.ahead(&state)[0]
        })
        .collect()
}

#[test]
fn a_play_trails_by_its_half_width_and_is_taken_back_over_twice_that() {
    let heating: Vec<f64> = (0..=40).map(f64::from).collect();
    let there_and_back: Vec<f64> = heating.iter().chain(heating.iter().rev()).copied().collect();
    let ahead = ahead(play(5.0), &there_and_back);
    assert!(ahead[10..=40].iter().all(|&m| (m + 5.0).abs() < 1e-12), "heating: {ahead:?}");
    assert!((ahead[46] - 0.0).abs() < 1e-12, "5 back: in the slot's middle");
    assert!(ahead[51..].iter().all(|&m| (m - 5.0).abs() < 1e-12), "cooling");
}

#[test]
fn a_lag_on_a_ramp_trails_by_rate_times_time_constant_whatever_the_step() {
    let history = History::new(line(0.0, 0.0), &[lag(20.0)]).unwrap();
    let after_100_s = |step: f64| {
        let mut state = HistoryState::default();
        let mut t = 0.0;
        while t <= 100.0 {
            history.advance(&drift(), &mut state, 0.3 * t, step);
            t += step;
        }
        history.ahead(&state)[0]
    };
    // tau dm/dt = T - m with T = 0.3 t, m(0) = 0: m - T = -0.3 tau (1 - exp(-t / tau)).
    let exact = -0.3 * 20.0 * (1.0 - (-5.0_f64).exp());
    for step in [0.5, 2.0, 10.0, 50.0] {
        assert!((after_100_s(step) - exact).abs() < 1e-9, "step {step}: {} {exact}", after_100_s(step));
    }
}

#[test]
fn what_is_not_known_at_start_up_is_flagged() {
    let history = History::new(line(105.0, 0.1), &[play(5.0)]).unwrap();
    let mut state = HistoryState::default();
    assert!(history.evaluate(&state).0.is_nan());
    history.advance(&drift(), &mut state, 20.0, 1.0);
    assert_eq!(history.evaluate(&state), (107.0, Knowledge::Uncertain));
    for temperature in 21..=30 {
        history.advance(&drift(), &mut state, f64::from(temperature), 1.0);
        let (reading, knowledge) = history.evaluate(&state);
        // Until 10 degrees were seen the play is in the middle of them.
        let exact = 105.0 + 0.1 * f64::from(temperature) - 0.5 * 0.5 * f64::from(temperature - 20);
        assert!((reading - exact).abs() < 1e-12, "{reading} {exact}");
        assert_eq!(knowledge == Knowledge::Known, temperature >= 29, "at {temperature}");
    }
}

#[test]
fn a_lag_becomes_known_with_time_alone() {
    let history = History::new(line(105.0, 0.1), &[lag(100.0)]).unwrap();
    let mut state = HistoryState::default();
    // The first group starts it: 168 of them are 167 s. 1 - exp(-1.68) = 0.8136, and belief(0.8136) = 0.9501.
    (0..168).for_each(|_| history.advance(&drift(), &mut state, 20.0, 1.0));
    assert_eq!(history.evaluate(&state).1, Knowledge::Uncertain);
    history.advance(&drift(), &mut state, 20.0, 1.0);
    assert_eq!(history.evaluate(&state).1, Knowledge::Known);
}

#[test]
fn a_lost_group_takes_its_time_with_it() {
    let history = History::new(line(0.0, 0.0), &[lag(20.0)]).unwrap();
    let (mut whole, mut lost) = (HistoryState::default(), HistoryState::default());
    for second in 0..50 {
        let temperature = 0.5 * f64::from(second);
        history.advance(&drift(), &mut whole, temperature, 1.0);
        history.advance(&drift(), &mut lost, if second % 7 == 3 { f64::NAN } else { temperature }, 1.0);
    }
    assert!((history.ahead(&whole)[0] - history.ahead(&lost)[0]).abs() < 1e-9);
    let (reading, coverage, _) = evaluate_dynamic(&drift(), Some(&history), &whole, f64::NAN);
    assert!(reading.is_nan() && coverage == Coverage::Invalid);
}

/// A part that is wholly behind follows a ramp by rate times time constant: its drift is the curve's there. One that is half
/// behind is half way, and what is added comes on top. Before the first change all are at the one temperature.
#[test]
fn what_is_behind_takes_the_curve_where_the_memory_is() {
    let scale = Scale::spanning(-20.0, 80.0).unwrap();
    let curve = |t: f64| 5.0 - 0.2 * t + 0.01 * t * t;
    let shape = || Shape::Polynomial(Polynomial::from_raw_coefficients(scale, &[5.0, -0.2, 0.01]).unwrap());
    for (behind, weight) in [(1.0, 0.0), (0.5, 0.0), (0.5, 0.3), (0.0, 0.3)] {
        let history = History::new(shape(), &[Term { behind, weight, ..lag(20.0) }]).unwrap();
        let mut state = HistoryState::default();
        history.advance(&drift(), &mut state, -10.0, 1.0);
        assert!((history.evaluate(&state).0 - curve(-10.0)).abs() < 1e-12);
        let mut t = 0.0;
        while t < 300.0 {
            t += 1.0;
            history.advance(&drift(), &mut state, -10.0 + 0.2 * t, 1.0);
        }
        // After fifteen time constants it is 0.2 x 20 = 4 degrees below 50.
        let expected = curve(50.0 - 4.0 * behind) - 4.0 * weight;
        assert!((history.evaluate(&state).0 - expected).abs() < 1e-4, "{behind} {weight}");
    }
    // Whatever its numbers, no part was ever outside of what was seen.
    let history = History::new(shape(), &[Term { behind: 40.0, weight: 0.0, ..lag(20.0) }]).unwrap();
    let mut state = HistoryState::default();
    [10.0, 30.0].into_iter().for_each(|t| history.advance(&drift(), &mut state, t, 1.0));
    assert!((history.evaluate(&state).0 - curve(10.0)).abs() < 1e-12);
}

#[test]
fn outside_the_valid_range_the_history_is_held_with_the_curve() {
    let held = ahead(play(5.0), &[20.0, 60.0, 80.0, 200.0, 80.0]);
    assert_eq!(held[2..], [-5.0; 3]);
}

#[test]
fn a_history_that_makes_no_sense_cannot_be_built() {
    let curve = || line(0.0, 0.0);
    let with = |term: Term| History::new(curve(), &[term]);
    assert!(with(play(5.0)).is_some() && with(lag(1.0)).is_some());
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(with(play(size)).is_none() && with(lag(size)).is_none());
    }
    assert!(with(Term { weight: f64::NAN, ..play(5.0) }).is_none());
    assert!(with(Term { behind: f64::INFINITY, ..lag(5.0) }).is_none());
    assert!(with(Term { share: 0.5, ..play(5.0) }).is_none());
    assert!(History::new(curve(), &[]).is_none());
    assert!(History::new(curve(), &[Term { share: 1.0 / 7.0, ..play(5.0) }; 7]).is_none());
}

/// The play as its definition has it, from a state that the device could not know.
fn true_play(temperatures: &[f64], half_width: f64, start: f64) -> Vec<f64> {
    let mut m = temperatures[0] + start;
    temperatures
        .iter()
        .map(|t| {
            m = m.min(t + half_width).max(t - half_width);
            m - t
        })
        .collect()
}

proptest! {
    #[test]
    fn whatever_the_state_was_at_the_start_it_is_within_what_is_not_known(
        steps in prop::collection::vec(-6.0..6.0_f64, 1..60), start in -1.0..1.0_f64, half_width in 0.5..30.0_f64,
    ) {
        let mut temperature = 30.0_f64;
        let temperatures: Vec<f64> = core::iter::once(30.0)
            .chain(steps.iter().map(|step| {
                temperature = (temperature + step).clamp(-20.0, 80.0);
                temperature
            }))
            .collect();
        let truth = true_play(&temperatures, half_width, start * half_width);
        let ours = ahead(play(half_width), &temperatures);
        let (mut least, mut most) = (30.0_f64, 30.0_f64);
        for ((t, truth), ours) in temperatures.iter().zip(&truth).zip(&ours) {
            (least, most) = (least.min(*t), most.max(*t));
            let unknown = (half_width - 0.5 * (most - least)).max(0.0);
            prop_assert!((truth - ours).abs() <= unknown + 1e-9, "{truth} {ours} {unknown}");
        }
    }
}

#[test]
fn belief_goes_from_nothing_to_all_and_does_not_turn_back() {
    assert_eq!((belief(0.0), belief(0.5), belief(1.0)), (0.0, 0.5, 1.0));
    let all: Vec<f64> = (0..=100).map(|k| belief(f64::from(k) / 100.0)).collect();
    assert!(all.windows(2).all(|pair| pair[0] < pair[1]));
}
