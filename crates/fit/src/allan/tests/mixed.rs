//! Where white noise, flicker and a walk stand side by side.

use super::*;

/// Flicker whose spectrum to either side is `B^2 / (2 pi f)` (IEEE Std 952-1997, C.1.3) from the samples' rate to beyond the
/// record: first-order processes an octave apart, each of the variance `B^2 ln 2 / pi`. That of one with the time constant T and the
/// variance v is `2 v T / (1 + (2 pi f T)^2)`; its integral over ln T is `v / (2 f)`, and an octave is ln 2 of it.
struct Flicker(Vec<(f64, f64, f64)>);

impl Flicker {
    fn of(b: f64, noise: &mut Uniform) -> Self {
        let size = b * (std::f64::consts::LN_2 / std::f64::consts::PI).sqrt();
        let process = |octave: i32| {
            let kept = (-1.0 / 2.0_f64.powi(octave)).exp();
            (size * noise.next(), kept, size * (1.0 - kept * kept).sqrt())
        };
        Self((1..20).map(process).collect())
    }

    fn next(&mut self, noise: &mut Uniform) -> f64 {
        for (state, kept, pushed) in &mut self.0 {
            *state = *kept * *state + *pushed * noise.next();
        }
        self.0.iter().map(|(state, ..)| state).sum()
    }
}

/// A record of an hour at 10 Hz.
fn record(n: f64, b: f64, k: f64, noise: &mut Uniform) -> Allan {
    const PERIOD_S: f64 = 0.1;
    let mut flicker = Flicker::of(b, noise);
    let mut walk = 0.0;
    let rates: Vec<f64> = (0..36_000)
        .map(|_| {
            walk += k * PERIOD_S.sqrt() * normal(noise);
            walk + flicker.next(noise) + n / PERIOD_S.sqrt() * normal(noise)
        })
        .collect();
    Allan::of(&rates, PERIOD_S).unwrap()
}

/// How many of the records show a coefficient, in how many of those its bounds hold the truth, and its mean over the truth.
fn told(found: &[Coefficient], truth: f64) -> (f64, f64, f64) {
    let of = |found: &Coefficient| match *found {
        Coefficient::Seen { value, low, high, .. } => Some((value, low <= truth && truth <= high)),
        Coefficient::Hidden { .. } => None,
    };
    let seen: Vec<(f64, bool)> = found.iter().filter_map(of).collect();
    let count = seen.len() as f64;
    let held = seen.iter().filter(|(_, held)| *held).count() as f64;
    (count, held / count, seen.iter().map(|(value, _)| value / truth / count).sum())
}

/// The curve seldom shows of flicker and a walk more than one: the bounds are of both cases. By the one that the curve needs alone
/// those of N held it in 90 of 100 at the last, and those of K in 71, 38 and 68; K came out 18, 27 and 6 % too large.
#[test]
fn beside_flicker_and_a_walk_the_bounds_hold_the_truth_as_often_as_they_say() {
    const RECORDS: usize = 100;
    let n = 0.005;
    for (b, k) in [(7e-4, 2e-4), (1.4e-3, 3e-4), (2e-3, 1e-3)] {
        let mut noise = Uniform(31_337);
        let found: Vec<Coefficients> = (0..RECORDS).map(|_| record(n, b, k, &mut noise).coefficients).collect();
        let of = |of: fn(&Coefficients) -> Coefficient| found.iter().map(of).collect::<Vec<_>>();
        let (seen, held, mean) = told(&of(|found| found.angle_random_walk), n);
        // 95 of 100, less two standard deviations of so many.
        assert!(seen > 99.5 && held >= 0.91 && (mean - 1.0).abs() < 0.005, "B {b} K {k}: N {seen} {held} {mean}");
        let (seen, held, mean) = told(&of(|found| found.rate_random_walk), k);
        // Of a weak walk those are seen that came out large.
        assert!(seen >= 40.0 && held >= 0.9 && (0.9..1.2).contains(&mean), "B {b} K {k}: K {seen} {held} {mean}");
    }
}
