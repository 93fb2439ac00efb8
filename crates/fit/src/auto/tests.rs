use std::f64::consts::TAU;

use super::*;
use crate::drift_fit::BandPoint;
use crate::intervals;

/// A series in time, groups of 10 s.
struct Made {
    time_s: Vec<f64>,
    temperature: Vec<f64>,
    rate: Vec<f64>,
}

/// White noise of unit variance, near enough: the sum of twelve uniform numbers less their mean.
fn noise(seed: &mut u64) -> f64 {
    let uniform = || {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 33) as f64 / (1_u64 << 31) as f64
    };
    std::iter::repeat_with(uniform).take(12).sum::<f64>() - 6.0
}

/// Down from 25 to -30, up to 65, down to 20: 400 groups.
fn cycle() -> Vec<f64> {
    let turn = |group: f64| match group {
        g if g < 80.0 => 25.0 - 55.0 * g / 80.0,
        g if g < 260.0 => -30.0 + 95.0 * (g - 80.0) / 180.0,
        g => 65.0 - 45.0 * (g - 260.0) / 140.0,
    };
    (0..400).map(|group| turn(f64::from(group))).collect()
}

/// Down and up again, four times.
fn cycles() -> Vec<f64> {
    (0..400).map(|group| 20.0 + 45.0 * (TAU * f64::from(group) / 100.0).cos()).collect()
}

impl Made {
    fn new(temperature: Vec<f64>, rate: impl Fn(usize, f64) -> f64) -> Self {
        let mut seed = 7;
        let rate = temperature.iter().enumerate().map(|(group, t)| rate(group, *t) + 1e-4 * noise(&mut seed)).collect();
        Self { time_s: (0..temperature.len()).map(|group| 10.0 * group as f64).collect(), temperature, rate }
    }

    fn fit(&self, asked: Model) -> GroupFit {
        self.fit_of_logs(asked, &vec![0; self.rate.len()])
    }

    fn fit_of_logs(&self, asked: Model, log: &[u32]) -> GroupFit {
        let weight = vec![1.0; self.rate.len()];
        let (time_s, temperature, rate) = (&self.time_s[..], &self.temperature[..], &self.rate[..]);
        let series =
            Series { time_s, temperature, shown: temperature, rate, weight: &weight, log, next: NextRun::Another };
        let used = (0..rate.len()).filter(|&group| series.is_used(group)).map(|group| temperature[group]);
        let (min, max) = intervals::ends(used);
        fit(&series, ValidRange::new(min, max).unwrap(), asked).unwrap()
    }
}

fn cubic(t: f64) -> f64 {
    let x = (t - 20.0) / 45.0;
    0.01 + 0.02 * x - 0.003 * x * x + 0.002 * x * x * x
}

fn chosen(fit: &GroupFit) -> String {
    fit.fit.chosen_model()
}

/// Hysteresis by another reading than ours: Bouc and Wen's differential equation, whose branches bend. It saturates
/// within about 8 degrees, at 2 mrad/s.
fn bouc_wen(temperature: &[f64]) -> Vec<f64> {
    let (mut z, mut before) = (0.0, temperature[0]);
    let step = |&t: &f64| {
        for _ in 0..20 {
            let rise = (t - before) / 20.0;
            z += rise / 8.0 - (rise.abs() / 8.0) * z;
        }
        before = t;
        2e-3 * z
    };
    temperature.iter().map(step).collect()
}

#[test]
fn a_static_unit_gets_its_curve_and_nothing_beside_it() {
    let fit = Made::new(cycle(), |_, t| cubic(t)).fit(Model::Auto);
    assert!(!chosen(&fit).contains('+'), "{}", chosen(&fit));
    for t in [-30.0, 0.0, 40.0, 65.0] {
        assert!((fit.fit.model.drift.evaluate(t).0 - cubic(t)).abs() < 5e-5, "at {t}");
    }
    assert!(
        fit.fit.statistics.held_out.unwrap().rms < 1.15e-4
            && fit.fit.statistics.nested.unwrap().deployed_cold.unwrap() < 1.2e-4,
        "{:?}",
        fit.fit.statistics.nested
    );
    // A knot in the middle, a few groups to either side of it.
    assert!((1e-6..1e-4).contains(&fit.fit.statistics.covariance[16][16].sqrt()));
    // 95 of 100 within 1.96e-4.
    assert!(fit.fit.band.iter().all(|point| (1.5e-4..3.0e-4).contains(&point.half_width)), "{:?}", fit.fit.band);
}

#[test]
fn hysteresis_of_another_kind_is_found_and_predicted_on_data_never_seen() {
    let history = bouc_wen(&cycles());
    let fit = Made::new(cycles(), |group, t| cubic(t) + history[group]).fit(Model::Auto);
    assert!(chosen(&fit).contains("play") && fit.fit.model.history.is_some(), "{}", chosen(&fit));
    let nested = fit.fit.statistics.nested.unwrap();
    let [own, cubic] = [nested.in_recording, nested.cubic_in_recording].map(Option::unwrap);
    assert!(own < 0.25 * cubic, "{nested:?}");
    let [warm, cold, cubic] = [nested.deployed_warm, nested.deployed_cold, nested.cubic_deployed].map(Option::unwrap);
    assert!(warm < 0.5 * cubic && cold < 1.1 * cubic, "{nested:?}");
}

/// The inside of a part, which follows the temperature with a time constant, solved in steps of a second.
fn inside(temperature: &[f64], time_constant_s: f64) -> Vec<f64> {
    let mut inside = temperature[0];
    let follow = |t: &f64| {
        (0..10).for_each(|_| inside += (t - inside) / time_constant_s);
        inside
    };
    temperature.iter().map(follow).collect()
}

#[test]
fn a_lag_and_a_drift_in_time_are_told_apart() {
    let temperature = cycles();
    let ahead: Vec<f64> = inside(&temperature, 240.0).iter().zip(&temperature).map(|(inside, t)| inside - t).collect();
    let fit = Made::new(temperature, |group, t| cubic(t) + 2e-4 * ahead[group] + 1e-6 * 10.0 * group as f64);
    let fit = fit.fit(Model::Auto);
    assert!(chosen(&fit).contains("lag"), "{}", chosen(&fit));
    let drift = fit.fit.model.time_drift.expect("a drift in time");
    // Two lags stand for a third: what they leave at first is taken for a start-up. Of the second half all is told.
    let drifted = drift.at(3990.0, 3990.0) - drift.at(1995.0, 1995.0);
    assert!((drifted - 1.995e-3).abs() < 2e-4, "{drifted}: {drift:?}");
    assert!(drift.at(1995.0, 1995.0).abs() < 1e-9, "nothing in the log's middle: {drift:?}");
    let nested = fit.fit.statistics.nested.unwrap();
    assert!(nested.in_recording.unwrap() < 0.1 * nested.cubic_in_recording.unwrap(), "{nested:?}");
}

#[test]
fn a_ramp_in_one_direction_has_neither_history_nor_drift_in_time() {
    let ramp = (0..400).map(|group| -30.0 + 0.25 * f64::from(group)).collect();
    let fit = Made::new(ramp, |group, t| cubic(t) + 1e-6 * group as f64).fit(Model::Auto);
    assert!(fit.fit.model.history.is_none() && fit.fit.model.time_drift.is_none());
}

/// An end of a heating ramp is held out: going on along its tangent is nearer there than a cubic that is held.
#[test]
fn what_is_deployed_after_a_ramp_with_hysteresis_is_what_the_same_ramp_leaves_again() {
    let temperature: Vec<f64> = (0..400).map(|group| -20.0 + 0.2 * f64::from(group)).collect();
    let history = bouc_wen(&temperature);
    let ramp = Made::new(temperature, |group, t| cubic(t) + 10.0 * history[group]);
    let GroupFit { fit, .. } = ramp.fit(Model::Auto);
    // Again: the truth, with no noise but the model's own, zeroed over three groups.
    let mut predictor = Predictor::new(&fit.model, Start::Unknown);
    let mut of =
        |(group, t): (usize, &f64)| cubic(*t) + 10.0 * history[group] - predictor.predict(ramp.time_s[group], *t).bias;
    let left: Vec<f64> = ramp.temperature.iter().enumerate().map(&mut of).collect();
    let zero = left[..3].iter().sum::<f64>() / 3.0;
    let again = (left[3..].iter().map(|left| (left - zero).powi(2)).sum::<f64>() / 397.0 + 1e-8).sqrt();
    let told = fit.statistics.deployed.unwrap().rms;
    assert!(told > 0.5 * again && told < 3.0 * again, "told {told:.2e}, again {again:.2e}");
}

/// The same profile again: the truth, zeroed over its first three groups. Zeroed with each eighth it would be half as much.
#[test]
fn what_a_static_cubic_leaves_of_a_whole_log_is_what_the_next_run_has_left() {
    let history = bouc_wen(&cycles());
    let made = Made::new(cycles(), |group, t| cubic(t) + history[group]);
    let GroupFit { fit, .. } = made.fit(Model::Auto);
    let static_cubic = fit.static_cubic.unwrap();
    let left = |group: usize, t: &f64| cubic(*t) + history[group] - static_cubic.drift.evaluate(*t).0;
    let left: Vec<f64> = made.temperature.iter().enumerate().map(|(group, t)| left(group, t)).collect();
    let zero = left[..3].iter().sum::<f64>() / 3.0;
    let again = (left[3..].iter().map(|left| (left - zero).powi(2)).sum::<f64>() / (left.len() - 3) as f64).sqrt();
    let told = static_cubic.deployed.unwrap().rms;
    assert!(told > 0.8 * again && told < 1.3 * again, "told {told:.2e}, again {again:.2e}");
}

/// One cycle, and a cubic that was asked for. The same run again: the truth, with no noise but the model's own, zeroed over its
/// first three groups.
#[test]
fn a_cubic_leaves_less_of_the_same_loop_again_than_of_its_folds_and_no_less_than_in_sample() {
    let temperature: Vec<f64> = (-200..200).map(|group: i32| 60.0 - 0.4 * f64::from(group.abs())).collect();
    let history = bouc_wen(&temperature);
    for size in [0.0, 0.3, 1.0, 3.0] {
        let made = Made::new(temperature.clone(), |group, t| cubic(t) + size * history[group]);
        let GroupFit { fit, .. } = made.fit(Model::Poly(3));
        assert!(fit.misses_its_own_branch());
        let of = |(group, t): (usize, &f64)| cubic(*t) + size * history[group] - fit.model.drift.evaluate(*t).0;
        let left: Vec<f64> = temperature.iter().enumerate().map(of).collect();
        let zero = left[..3].iter().sum::<f64>() / 3.0;
        let again = (left[3..].iter().map(|left| (left - zero).powi(2)).sum::<f64>() / 397.0 + 1e-8).sqrt();
        let (told, in_sample) = (fit.statistics.deployed.unwrap().rms, fit.statistics.in_sample.rms);
        assert!(told > again && again > 0.95 * in_sample, "{size}: {told:.2e}, {again:.2e}, {in_sample:.2e}");
    }
    let one_way = Made::new(temperature[..200].to_vec(), |_, t| cubic(t));
    assert!(!one_way.fit(Model::Poly(3)).fit.misses_its_own_branch());
    // Between two logs that warm nothing cools.
    let twice = Made::new(temperature[..200].repeat(2), |_, t| cubic(t));
    let log: Vec<u32> = (0..400).map(|group| group / 200).collect();
    assert!(!twice.fit_of_logs(Model::Poly(3), &log).fit.misses_its_own_branch());
}

#[test]
fn at_either_end_it_is_better_than_a_cubic_that_is_held() {
    for curve in [cubic as fn(f64) -> f64, |t| 0.01 + 3e-4 * t, |t| 0.01 * (-(t + 30.0) / 30.0).exp()] {
        let ramp: Vec<f64> = (0..400).map(|group| -30.0 + 0.25 * f64::from(group)).collect();
        let mut made = Made::new(ramp, |_, t| curve(t));
        let truth = made.rate.clone();
        for end in [0..40, 360..400] {
            made.rate = truth.clone();
            made.rate[end.clone()].fill(f64::NAN);
            let rms = |model: Model| {
                let fit = made.fit(model);
                let left = |group: usize| truth[group] - fit.fit.model.drift.evaluate(made.temperature[group]).0;
                (end.clone().map(|group| left(group).powi(2)).sum::<f64>() / end.len() as f64).sqrt()
            };
            let (own, held) = (rms(Model::Auto), rms(Model::Poly(3)));
            // Where the curve is level there is nothing to gain, and the slope has an error.
            assert!(own < 0.5 * held + 2e-4, "{end:?}: {own} against {held}");
        }
    }
}

#[test]
fn outliers_do_not_move_the_curve() {
    let clean = Made::new(cycle(), |_, t| cubic(t)).fit(Model::Auto);
    let outlying = |group: usize| if group % 20 == 7 { 0.05 } else { 0.0 };
    let fit = Made::new(cycle(), |group, t| cubic(t) + outlying(group)).fit(Model::Poly(3));
    for t in [-30.0, 0.0, 40.0, 65.0] {
        assert!((fit.fit.model.drift.evaluate(t).0 - clean.fit.model.drift.evaluate(t).0).abs() < 5e-5, "at {t}");
    }
}

#[test]
fn a_longer_record_gives_the_same_curve_as_its_thinned_one() {
    let long: Vec<f64> =
        cycle().windows(2).flat_map(|w| (0..6).map(move |k| w[0] + (w[1] - w[0]) * f64::from(k) / 6.0)).collect();
    let fit = Made::new(long, |_, t| cubic(t)).fit(Model::Auto);
    assert_eq!(fit.residuals.len(), 2394);
    assert!((fit.fit.model.drift.evaluate(50.0).0 - cubic(50.0)).abs() < 2e-5);
    assert!((fit.fit.statistics.in_sample.rms - 1e-4).abs() < 1e-5);
}

#[test]
fn several_logs_have_a_history_each_and_no_drift_in_time() {
    let mut temperature = cycles();
    temperature.extend(cycles());
    let one = bouc_wen(&cycles());
    let log: Vec<u32> = (0..800).map(|group| u32::from(group >= 400)).collect();
    let made = Made::new(temperature, |group, t| cubic(t) + one[group % 400]);
    let fit = made.fit_of_logs(Model::Auto, &log);
    assert!(fit.fit.model.history.is_some() && fit.fit.model.time_drift.is_none());
    assert!(fit.fit.statistics.held_out.unwrap().rms < 4e-4, "{:?}", fit.fit.statistics.held_out);
}

/// A unit that warms up and whose die is behind its sensor, switched on twice: what both runs say of it helps on the third no less
/// than what one says. A fold that lasts twice as long has twice the warming up in it, which no device predicts.
#[test]
fn two_runs_of_a_unit_leave_no_more_of_a_third_than_one_does() {
    let behind = |temperature: Vec<f64>| inside(&temperature, 120.0).into_iter().map(cubic);
    let run: Vec<f64> = behind(cycle()).collect();
    let warming_up = |group: usize| 3e-2 * libm::exp(-10.0 * (group % 400) as f64 / 900.0);
    let left_of_the_third = |runs: usize| {
        let temperature = (0..runs).flat_map(|_| cycle()).collect();
        let log: Vec<u32> = (0..runs).flat_map(|run| vec![u32::try_from(run).unwrap(); 400]).collect();
        let made = Made::new(temperature, |group, _| run[group % 400] + warming_up(group));
        let model = made.fit_of_logs(Model::Auto, &log).fit.model;
        let rows = cycles().into_iter().enumerate().map(|(group, t)| (10.0 * group as f64, t));
        let left: Vec<f64> = behind(cycles()).zip(model.biases(rows)).map(|(rate, bias)| rate - bias).collect();
        ResidualStatistics::about_mean(&left).0.rms
    };
    let (one, two) = (left_of_the_third(1), left_of_the_third(2));
    assert!(two < 1.05 * one, "{two} of {one}");
}

/// Three ramps, up, down and up, over other temperatures each, each with a level of its own: a named curve is not bent by them.
#[test]
fn the_levels_of_logs_do_not_bend_a_curve() {
    let log: Vec<u32> = (0..900).map(|group| group / 300).collect();
    let temperature = |group: usize| {
        let along = (group % 300) as f64 / 300.0;
        [5.0 + 40.0 * along, 55.0 - 45.0 * along, 30.0 * along][group / 300]
    };
    let level = |group: usize| [0.0, 5.0, -1.0][group / 300];
    let made = Made::new((0..900).map(temperature).collect(), |group, t| cubic(t) + level(group));
    for model in [Model::Poly(3), Model::Auto] {
        let fit = made.fit_of_logs(model, &log);
        let left = |t: f64| cubic(t) - fit.fit.model.drift.evaluate(t).0;
        let all: Vec<f64> = (0..=50).map(|t| left(f64::from(t))).collect();
        let [least, most] = [f64::min, f64::max].map(|of| all.iter().copied().reduce(of).unwrap());
        assert!(most - least < 2e-3, "{model}: {least} to {most}");
        let offsets: Vec<f64> = fit.fit.statistics.by_log.iter().map(|log| log.offset.unwrap()).collect();
        let true_offsets = [0.0, 5.0, -1.0].map(|level| level - 4.0 / 3.0);
        assert!(offsets.iter().zip(true_offsets).all(|(own, put)| (own - put).abs() < 5e-3), "{offsets:?}");
    }
}

/// Two ramps of 400 groups, 0.25 C apart: one drifts by 0.01 a degree, the other by 0.02 from 5 on. Of the second the first
/// alone leaves 0.01 a degree, a line through both 0.005.
#[test]
fn of_two_logs_each_is_predicted_by_the_other() {
    let ramp = |group: usize| -30.0 + 0.25 * (group % 400) as f64;
    let log: Vec<u32> = (0..800).map(|group| u32::from(group >= 400)).collect();
    let rate = |group: usize, t: f64| if group < 400 { 0.01 * t } else { 0.02 * t + 5.0 };
    let made = Made::new((0..800).map(ramp).collect(), rate);
    let left = made.fit_of_logs(Model::Poly(1), &log).fit.statistics.by_log;
    // The zero is the mean of the first three groups: the others are 0.25 C times 2 to 398 above it.
    let squares = (398.0 * 399.0 * 797.0 / 6.0 - 1.0) / 397.0;
    let span = 0.25 * f64::sqrt(squares);
    assert_eq!(left.len(), 2);
    for (left, own) in left.iter().zip([0.01, 0.02]) {
        let others = left.by_the_others.expect("the other log settles a line");
        for (told, slope) in [(left.uncorrected, own), (others, 0.01), (left.by_all, 0.005)] {
            assert!((told / (slope * span) - 1.0).abs() < 1e-3, "{left:?}");
        }
    }
    // The line through both is halfway, 0.005 a degree and 2.5 from either; the mean temperature is 19.875 C.
    for (left, offset) in left.iter().zip([-2.599_375, 2.599_375]) {
        assert!((left.offset.unwrap() - offset).abs() < 1e-4, "{left:?}");
    }
    let alone = Made::new((0..400).map(ramp).collect(), |_, t| 0.01 * t).fit(Model::Poly(1));
    assert!(alone.fit.statistics.by_log.is_empty());
}

/// What the second of two runs leaves of the first is what a calibration of it alone does: its strength, its temperatures and its part of
/// the cubic are its own.
#[test]
fn the_other_logs_are_fitted_as_if_there_were_no_more() {
    let run = |temperature: Vec<f64>| {
        let history = bouc_wen(&temperature);
        Made::new(temperature, move |group, t| cubic(t) + history[group] + 2e-3 * libm::exp(-(group as f64) / 50.0))
    };
    let (first, second) = (run(cycle()), run(cycles()));
    let both = Made {
        time_s: [&first.time_s[..], &second.time_s].concat(),
        temperature: [&first.temperature[..], &second.temperature].concat(),
        rate: [&first.rate[..], &second.rate].concat(),
    };
    let log: Vec<u32> = (0..800).map(|group| u32::from(group >= 400)).collect();
    let told = both.fit_of_logs(Model::Auto, &log).fit.statistics.by_log[0].by_the_others.unwrap();
    let rows = first.time_s.iter().copied().zip(first.temperature.iter().copied());
    let biases = second.fit(Model::Auto).fit.model.biases(rows);
    let left: Vec<f64> = first.rate.iter().zip(biases).map(|(rate, bias)| rate - bias).collect();
    let zero = left[..3].iter().sum::<f64>() / 3.0;
    let squares = left[3..].iter().map(|left| (left - zero).powi(2)).sum::<f64>();
    let truth = (squares / 397.0).sqrt();
    assert!((told / truth - 1.0).abs() < 1e-9, "{told} for {truth}");
}

/// A cold log and a warm one beside it, on one line of 0.01 a degree: a calibration of either is held where the other begins, and
/// leaves of that all 2 to 398 steps of 0.125 C after its zero.
#[test]
fn what_the_others_predict_is_held_beyond_their_temperatures() {
    let log: Vec<u32> = (0..800).map(|group| u32::from(group >= 400)).collect();
    let made = Made::new((0..800).map(|group| -30.0 + 0.125 * f64::from(group)).collect(), |_, t| 0.01 * t);
    let span = 0.125 * f64::sqrt((398.0 * 399.0 * 797.0 / 6.0 - 1.0) / 397.0);
    for left in made.fit_of_logs(Model::Poly(1), &log).fit.statistics.by_log {
        let others = left.by_the_others.expect("the other log settles a line");
        assert!((others / (0.01 * span) - 1.0).abs() < 2e-3, "{left:?}");
    }
}

/// One log begins cold and one warm, on one line of 0.01 a degree: each moves by the 396 steps of 0.25 C after its zero was taken.
#[test]
fn logs_that_start_at_other_temperatures_do_not_add_their_ends() {
    let there_and_back = |group: usize| -30.0 + 0.25 * if group < 400 { group } else { 799 - group } as f64;
    let log: Vec<u32> = (0..800).map(|group| u32::from(group >= 400)).collect();
    let made = Made::new((0..800).map(there_and_back).collect(), |_, t| 0.01 * t);
    let uncorrected =
        made.fit_of_logs(Model::Auto, &log).fit.statistics.uncorrected.expect("a log is held out as a whole");
    assert!((uncorrected.pp - 0.01 * 0.25 * 396.0).abs() < 1e-3, "{uncorrected:?}");
}

#[test]
fn the_static_cubic_is_of_the_same_data_without_their_drift_in_time() {
    let fit = Made::new(cycles(), |group, t| cubic(t) + 1e-6 * 10.0 * group as f64).fit(Model::Auto);
    let cubic_fit = fit.fit.static_cubic.unwrap();
    // The level is that of the recording's middle.
    assert!((cubic_fit.drift.evaluate(40.0).0 - cubic(40.0) - 2e-3).abs() < 5e-5);
    assert!(cubic_fit.in_sample.rms < 1.2e-4 && cubic_fit.held_out.unwrap().rms < 1.3e-4, "{cubic_fit:?}");
    assert!((cubic_fit.drift.valid.max() - 65.0).abs() < 1e-9);
    assert!(fit.fit.model.drift.valid.max() > 70.0, "as far beyond as the ends were tested");
}

#[test]
fn too_few_groups_or_one_temperature_are_refused() {
    let few = Made::new(vec![1.0, 20.0, 30.0], |_, t| cubic(t));
    let refused = |made: &Made, asked: Model| {
        let (weight, log) = (vec![1.0; made.rate.len()], vec![0; made.rate.len()]);
        let series = Series {
            time_s: &made.time_s,
            temperature: &made.temperature,
            shown: &made.temperature,
            rate: &made.rate,
            weight: &weight,
            log: &log,
            next: NextRun::Another,
        };
        fit(&series, ValidRange::new(1.0, 30.0).unwrap(), asked).unwrap_err()
    };
    assert!(matches!(refused(&few, Model::Poly(3)), FitError::TooFewRows { rows: 3, coefficients: 4 }));
    let one = Made::new(vec![20.0; 400], |_, t| cubic(t));
    assert!(matches!(refused(&one, Model::Auto), FitError::Undetermined { .. }));
}

/// The share of a run's groups within a band about what is predicted of them, less a zero by so many groups at its start.
fn covered(fit: &GroupFit, band: &[BandPoint], second: &Made, zeroed_by: usize) -> f64 {
    let biases = fit.fit.model.biases(second.time_s.iter().copied().zip(second.temperature.iter().copied()));
    let half = |t: f64| {
        let after = band.iter().position(|point| point.temperature >= t).unwrap_or(band.len() - 1).max(1);
        let [from, to] = [&band[after - 1], &band[after]];
        from.half_width
            + (t - from.temperature) / (to.temperature - from.temperature) * (to.half_width - from.half_width)
    };
    let left: Vec<f64> = second.rate.iter().zip(&biases).map(|(rate, bias)| rate - bias).collect();
    let zero = left[..zeroed_by].iter().sum::<f64>() / zeroed_by.max(1) as f64;
    let is_within = |(t, left): &(&f64, &f64)| (*left - zero).abs() <= half(**t);
    second.temperature.iter().zip(&left).filter(is_within).count() as f64 / left.len() as f64
}

#[test]
fn the_bands_hold_95_of_100_groups_of_this_run_and_of_the_next() {
    let made = |noises: usize, loops: f64| {
        let history = bouc_wen(&cycles());
        // Of a second run the noise is another.
        let mut made = Made::new(cycles(), |group, t| cubic(t) + loops * history[group]);
        let mut seed = 1000 + noises as u64;
        made.rate.iter_mut().for_each(|rate| *rate += 2e-4 * noise(&mut seed));
        made
    };
    for loops in [0.0, 1.0] {
        let shares = (0..5).map(|k| {
            let (first, second) = (made(k, loops), made(k + 7, loops));
            let fit = first.fit(Model::Auto);
            [covered(&fit, &fit.fit.band, &first, 0), covered(&fit, &fit.fit.next_run_band, &second, 3)]
        });
        let [own, next] = shares.fold([0.0; 2], |sum, share| [sum[0] + share[0] / 5.0, sum[1] + share[1] / 5.0]);
        assert!((0.93..0.97).contains(&own), "this run, loops of {loops}: {own}");
        assert!((0.91..0.98).contains(&next), "the next, loops of {loops}: {next}");
    }
}

#[test]
fn the_drift_of_a_loop_is_that_of_the_curve_between_its_ways() {
    // Once up and down, a loop as tall as the curve: beside lags and plays the model's own curve has what they leave it.
    let temperature: Vec<f64> =
        (0..720_i32).map(|group| 60.0 - 70.0 * f64::from((group - 360).abs()) / 360.0).collect();
    let x = |t: f64| (t - 25.0) / 35.0;
    let middle = |t: f64| 0.02 * (0.4 * x(t) + 0.25 * x(t).powi(2) - 0.2 * x(t).powi(3));
    let loops = |group: usize, t: f64| if group < 360 { 0.006 } else { -0.006 } * (1.0 - x(t).powi(2));
    let made = Made::new(temperature, |group, t| middle(t) + loops(group, t));
    let fit = made.fit(Model::Auto).fit;
    assert!(fit.model.history.is_some(), "{}", fit.chosen_model());
    let ends = (0..=700).map(|tenth| middle(-10.0 + 0.1 * f64::from(tenth)));
    let (least, most) = ends.fold((f64::NAN, f64::NAN), |(a, b), rate| (rate.min(a), rate.max(b)));
    let told = fit.measured_drift().peak_to_peak();
    assert!((told / (most - least) - 1.0).abs() < 0.1, "{told} of {}, by {}", most - least, fit.chosen_model());
}

/// Below -20 the rates were lost, not the temperatures: the next run sees them as well, and an autopilot's cubic is for them. No
/// further than the curve is believed.
#[test]
fn a_static_cubic_is_for_the_temperatures_of_the_log_that_had_no_rate_too() {
    let range = |lost_below: f64| {
        let mut made = Made::new(cycle(), |_, t| cubic(t));
        let lost = made.temperature.iter().map(|t| *t < lost_below).collect::<Vec<_>>();
        made.rate.iter_mut().zip(lost).filter(|(_, lost)| *lost).for_each(|(rate, _)| *rate = f64::NAN);
        let fit = made.fit(Model::Auto).fit;
        (fit.measured.min(), fit.static_cubic.unwrap().drift)
    };
    let (measured, drift) = range(-25.0);
    assert!((measured + 25.0).abs() < 0.7 && (drift.valid.min() + 30.0).abs() < 0.7, "{measured}: {drift:?}");
    assert!((drift.evaluate(-30.0).0 - cubic(-30.0)).abs() < 1e-3, "{drift:?}");
    let (measured, drift) = range(-15.0);
    assert!((drift.valid.min() - (measured - (65.0 - measured) / 8.0)).abs() < 1e-6, "{measured}: {drift:?}");
    // Without its rates the sensor jumps by 7 degrees.
    let mut made = Made::new(cycle(), |_, t| cubic(t));
    for group in 10..20 {
        (made.rate[group], made.temperature[group]) = (f64::NAN, 72.0);
    }
    let fit = made.fit(Model::Auto).fit;
    assert!((fit.static_cubic.unwrap().drift.valid.max() - fit.measured.max()).abs() < 1e-9);
}
