use super::averages::Averages;
use super::marginal::{Marginal, Spreads};
use super::noise::{Wander, Whitened};
use super::*;
use crate::predict::DriftModel;
use crate::series::NextRun;

/// A cycle of 60 groups with a curve, a loop and noise of no particular kind.
struct Cycle {
    time_s: Vec<f64>,
    temperature: Vec<f64>,
    rate: Vec<f64>,
}

impl Cycle {
    fn new() -> Self {
        let time_s: Vec<f64> = (0..60).map(|group| 10.0 * f64::from(group)).collect();
        let temperature: Vec<f64> = time_s.iter().map(|t| 20.0 + 30.0 * (t / 95.5).sin()).collect();
        let noise = |group: usize| ((group * 7919) % 100) as f64 / 1000.0;
        let rate = temperature.iter().enumerate().map(|(g, t)| 0.02 * t + 1e-4 * t * t + noise(g)).collect();
        Self { time_s, temperature, rate }
    }

    /// Six cycles of 600 s with a slope, and 0.5 at the start that is gone with 600 s.
    fn warming_up() -> Self {
        let time_s: Vec<f64> = (0..360).map(|group| 10.0 * f64::from(group)).collect();
        let temperature: Vec<f64> = time_s.iter().map(|t| 20.0 + 30.0 * (t / 95.5).sin()).collect();
        let noise = |group: usize| ((group * 7919) % 101) as f64 / 5000.0;
        let rate = |(group, (t, c)): (usize, (&f64, &f64))| 0.02 * c + 0.5 * (-t / 600.0).exp() + noise(group);
        let rate = time_s.iter().zip(&temperature).enumerate().map(rate).collect();
        Self { time_s, temperature, rate }
    }

    /// A part that is behind its sensor: a curve that is level in its middle, taken at a temperature that follows by `tau_s`.
    /// Air by `air`, second by second.
    fn behind(seconds: u32, tau_s: f64, air: impl Fn(f64) -> f64) -> Self {
        let (mut cycle, mut inside) = (Self { time_s: vec![], temperature: vec![], rate: vec![] }, air(0.0));
        for second in 0..seconds {
            let now = f64::from(second);
            inside += (air(now) - inside) / tau_s;
            if second % 10 == 0 {
                let noise = f64::from((second / 10 * 7919) % 101) / 101.0 - 0.5;
                cycle.time_s.push(now);
                cycle.temperature.push(air(now));
                cycle.rate.push(1e-3 * (inside - 20.0).powi(2) + 0.004 * noise);
            }
        }
        cycle
    }

    /// The model that was learnt of it, with parts that are behind.
    fn with_parts_behind(&self) -> DriftModel {
        self.with(|series| {
            let (_, with_parts_behind) = Evidence::likeliest(series, range(-10.0, 50.0), range(-17.5, 57.5)).unwrap();
            let (evidence, found) = with_parts_behind.expect("lags can be told");
            evidence.fit(&found, |_| true).unwrap().model
        })
    }

    /// What being behind adds, root mean square, and what a model leaves.
    fn late_and_left(&self, model: &DriftModel) -> (f64, f64) {
        let biases = model.biases(self.time_s.iter().copied().zip(self.temperature.iter().copied()));
        let rms = |left: &dyn Fn(usize) -> f64| {
            let squares: f64 = (0..biases.len()).map(|group| left(group).powi(2)).sum();
            (squares / biases.len() as f64).sqrt()
        };
        let late = rms(&|group| self.rate[group] - 1e-3 * (self.temperature[group] - 20.0).powi(2));
        (late, rms(&|group| self.rate[group] - biases[group]))
    }

    fn with<T>(&self, f: impl FnOnce(&Series<'_>) -> T) -> T {
        let (weight, log) = (vec![1.0; self.rate.len()], vec![0; self.rate.len()]);
        let (time_s, temperature, rate) = (&self.time_s[..], &self.temperature[..], &self.rate[..]);
        f(&Series { time_s, temperature, shown: temperature, rate, weight: &weight, log: &log, next: NextRun::Another })
    }
}

fn range(min: f64, max: f64) -> ValidRange {
    ValidRange::new(min, max).unwrap()
}

/// The columns of a cycle with a straight drift in time.
fn straight_columns(series: &Series<'_>) -> Columns {
    let (measured, valid) = (range(-10.0, 50.0), range(-17.5, 57.5));
    let memories = Memories::of(series, measured, valid);
    Columns::new(series, measured, valid, &memories, Slow::Straight, None).unwrap()
}

/// The innovations and their determinant against the covariance written out and factorised.
#[test]
fn whitening_is_that_of_the_covariance_written_out() {
    Cycle::new().with(|series| {
        let columns = straight_columns(series);
        let averages = Averages::new(series, &columns, |group| !(20..29).contains(&group)).unwrap();
        let wander = Wander { log_ratio: 0.7, log_seconds: 4.5 };
        let whitened = Whitened::new(&averages, wander);
        let rows = averages.time_s.len();
        let covariance = nalgebra::DMatrix::from_fn(rows, rows, |i, j| {
            let apart = (averages.time_s[i] - averages.time_s[j]).abs();
            let white = if i == j { averages.variance[i] } else { 0.0 };
            white + 1.4_f64.exp() * (-apart / 4.5_f64.exp()).exp()
        });
        let factor = covariance.cholesky().unwrap();
        let log_determinant: f64 = factor.l().diagonal().iter().map(|own| 2.0 * own.ln()).sum();
        assert!((whitened.log_determinant - log_determinant).abs() < 1e-9);
        let products = &averages.rows * factor.solve(&averages.rows.transpose());
        assert!((whitened.products - products).amax() < 1e-8);
    });
}

/// Gradient and marginal likelihood against differences of the likelihood, and that against the rows' whole covariance.
#[test]
fn the_marginal_likelihood_and_its_gradient_are_those_of_the_whole_covariance() {
    Cycle::new().with(|series| {
        let columns = straight_columns(series);
        let averages = Averages::new(series, &columns, |_| true).unwrap();
        let wander = Wander { log_ratio: -0.5, log_seconds: 5.0 };
        let whitened = Whitened::new(&averages, wander);
        let marginal = Marginal::new(&columns.kinds, &whitened, wander);
        let spreads = Spreads::prior(&columns.kinds);
        let at = |change: &dyn Fn(&mut Spreads)| {
            let mut moved = spreads.clone();
            change(&mut moved);
            marginal.evaluate(&moved).unwrap()
        };
        let here = at(&|_| {});
        for place in 0..=spreads.kinds.len() {
            let moved = |by: f64| {
                at(&|spreads: &mut Spreads| match spreads.kinds.get_mut(place) {
                    Some((_, log)) => *log += by,
                    None => spreads.white += by,
                })
            };
            let slope = (moved(1e-4).cost - moved(-1e-4).cost) / 2e-4;
            assert!((slope - here.gradient[place]).abs() < 1e-4 * (1.0 + slope.abs()), "{place}: {slope}");
        }
        // Of the white part's spread alone: log of N(y; 0, sigma^2 C + X S X'), but for constants and priors.
        let width = columns.kinds.len();
        let likelihood = |white: f64| {
            let of =
                |kind| spreads.kinds.iter().find(|(own, _)| *own == kind).map_or(100.0, |(_, log)| (2.0 * log).exp());
            let spread = nalgebra::DVector::from_iterator(width, columns.kinds.iter().map(|kind| of(*kind)));
            let rows = averages.rows.rows(0, width).transpose();
            let noise = nalgebra::DMatrix::from_fn(60, 60, |i, j| {
                let apart = (averages.time_s[i] - averages.time_s[j]).abs();
                let white = if i == j { averages.variance[i] } else { 0.0 };
                white + (-1.0_f64).exp() * (-apart / 5.0_f64.exp()).exp()
            });
            let whole =
                noise * (2.0 * white).exp() + &rows * nalgebra::DMatrix::from_diagonal(&spread) * rows.transpose();
            let factor = whole.cholesky().unwrap();
            let rates = averages.rows.row(width).transpose();
            let determinant: f64 = factor.l().diagonal().iter().map(|own| own.ln()).sum();
            determinant + 0.5 * rates.dot(&factor.solve(&rates))
        };
        let prior = |log: f64| 0.5 * ((log + 3.0) / 3.0).powi(2) + 0.5 * ((log - 0.5 + 4.0) / 2.0).powi(2);
        let (a, b) = (spreads.white, spreads.white + 0.7);
        let ours = at(&|spreads| spreads.white = b).cost - here.cost;
        let exact = likelihood(b) + prior(b) - likelihood(a) - prior(a);
        assert!((ours - exact).abs() < 1e-6, "{ours} {exact}");
    });
}

/// What lags is the part and not the rate: it is late most where the curve is steep, and at one end of it with the other sign than
/// at the other. Of a cycle it is learnt, of a run of another kind it is judged. A lag of the rate itself, learnt of the same
/// cycle, leaves 2.5 times as much of the other run as none.
#[test]
fn a_part_that_is_behind_its_sensor_is_found_and_helps_another_run() {
    // 50 degrees and back in an hour and a quarter.
    let cycle = |t: f64| 50.0 - 60.0 * (t / 2200.0 - 1.0).abs();
    let other = |t: f64| -8.0 + 0.04 * t;
    let next = Cycle::behind(1400, 120.0, other);
    let (late, left) = next.late_and_left(&Cycle::behind(4400, 120.0, cycle).with_parts_behind());
    assert!(late > 0.1 && left < 0.25 * late, "{left} of {late}");
}

/// From soak to soak, warming alone: at each the part comes after, and there is no other way of it.
#[test]
fn a_part_that_is_behind_its_sensor_is_found_between_soaks() {
    let soaks = |t: f64| {
        let soak = (t / 600.0).floor().min(7.0);
        let before = if soak > 0.0 { -10.0 + 60.0 * (soak - 1.0) / 7.0 } else { -10.0 };
        let to = -10.0 + 60.0 * soak / 7.0;
        to + (before - to) * (-(t - 600.0 * soak) / 60.0).exp()
    };
    let next = Cycle::behind(1400, 120.0, |t| -8.0 + 0.04 * t);
    let (late, left) = next.late_and_left(&Cycle::behind(4800, 120.0, soaks).with_parts_behind());
    assert!(late > 0.1 && left < 0.5 * late, "{left} of {late}");
}

/// With the first 600 s held out, what follows switching on is told from 600 s on, and is not carried back to the start, where
/// it would be e times as much.
#[test]
fn a_start_that_was_not_seen_is_not_made_up() {
    Cycle::warming_up().with(|series| {
        let ((evidence, found), _) = Evidence::likeliest(series, range(-10.0, 50.0), range(-17.5, 57.5)).unwrap();
        let made = evidence.fit(&found, |group| group >= 60).unwrap();
        let drift = made.model.time_drift.expect("what follows switching on");
        assert!((drift.seen_from_s - 600.0).abs() < 10.0, "{drift:?}");
        assert!((drift.at(0.0, 0.0) - drift.at(600.0, 600.0)).abs() < 0.02, "{drift:?}");
    });
}

#[test]
fn what_follows_switching_on_is_the_recordings_own() {
    Cycle::warming_up().with(|series| {
        let ((evidence, found), _) = Evidence::likeliest(series, range(-10.0, 50.0), range(-17.5, 57.5)).unwrap();
        let made = evidence.fit(&found, |_| true).unwrap();
        let drift = made.model.time_drift.expect("what follows switching on");
        let start: Vec<(f64, f64)> = drift.start_up.iter().map(|part| (part.rate, part.time_constant_s)).collect();
        assert!(start.len() == 3 && (start[1].1 - 600.0).abs() < 1e-9, "{start:?}");
        assert!(start[0].0.abs() < 0.05 && (start[1].0 - 0.5).abs() < 0.05, "{start:?}");
        let fallen = drift.at(0.0, 0.0) - drift.at(1200.0, 1200.0);
        assert!((fallen - 0.5 * (1.0 - (-2.0_f64).exp())).abs() < 0.03, "{fallen}");
        assert!((made.model.drift.evaluate(40.0).0 - made.model.drift.evaluate(0.0).0 - 0.8).abs() < 0.01);
    });
}
