use super::*;

mod mixed;

/// The Allan deviation of averages over `m` samples, each pair of them beginning `stride` samples after the one before.
fn deviation(rates: &[f64], m: usize, stride: usize) -> f64 {
    let (squares, pairs) = Sums::of(rates).squares(m, stride);
    (squares / (2.0 * pairs as f64)).sqrt()
}

/// NIST SP 1065, 12.4: the 1000-point set, `n(i+1) = 16807 n(i) mod 2147483647` from 1234567890, over 2147483647.
fn nist() -> Vec<f64> {
    let mut n: u64 = 1_234_567_890;
    (0..1000)
        .map(|_| {
            let value = n as f64 / 2_147_483_647.0;
            n = 16_807 * n % 2_147_483_647;
            value
        })
        .collect()
}

/// NIST SP 1065, table 31.
#[test]
fn nists_thousand_points_give_nists_deviations() {
    let rates = nist();
    assert!((rates.iter().sum::<f64>() / 1000.0 - 0.489_774_5).abs() < 1e-7, "the set's mean is in the table too");
    let plain = [(1, 0.292_231_9), (10, 0.099_657_36), (100, 0.038_978_04)];
    let overlapping = [(1, 0.292_231_9), (10, 0.091_599_53), (100, 0.032_414_13 + 2e-8)];
    for (m, expected) in plain {
        let found = deviation(&rates, m, m);
        assert!((found / expected - 1.0).abs() < 1e-6, "m {m}: {found}, and the table has {expected}");
    }
    for (m, expected) in overlapping {
        let found = deviation(&rates, m, 1);
        assert!((found / expected - 1.0).abs() < 1e-4, "m {m}: {found}, and the table has {expected}");
    }
}

/// Uniform noise of the same generator, scaled to unit variance.
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = 16_807 * self.0 % 2_147_483_647;
        (self.0 as f64 / 2_147_483_647.0 - 0.5) * 12.0_f64.sqrt()
    }
}

#[test]
fn white_noise_has_its_angle_random_walk_and_no_other() {
    let mut noise = Uniform(42);
    // 0.02 a sample at 100 Hz: N = 0.02 * sqrt(0.01).
    let rates: Vec<f64> = (0..20_000).map(|_| 5.0 + 0.02 * noise.next()).collect();
    let allan = Allan::of(&rates, 0.01).unwrap();
    let Coefficient::Seen { value, low, high, .. } = allan.coefficients.angle_random_walk else {
        panic!("{:?}", allan.coefficients)
    };
    assert!((value / 0.002 - 1.0).abs() < 0.02 && low < 0.002 && high > 0.002, "{low} {value} {high}");
    assert_eq!(allan.coefficients.bias_instability.value(), None);
    assert_eq!(allan.coefficients.rate_random_walk.value(), None);
    assert!((allan.at(1.0).unwrap() / 0.002 - 1.0).abs() < 0.15);
}

#[test]
fn white_noise_shows_a_bias_instability_or_a_walk_in_no_more_logs_than_are_told() {
    let mut noise = Uniform(20_261);
    let (mut flicker, mut walks) = (0, 0);
    const LOGS: usize = 200;
    for _ in 0..LOGS {
        let rates: Vec<f64> = (0..3000).map(|_| noise.next()).collect();
        let found = Allan::of(&rates, 0.5).unwrap().coefficients;
        flicker += usize::from(found.bias_instability.value().is_some());
        walks += usize::from(found.rate_random_walk.value().is_some());
        assert!(
            found.angle_random_walk.value().is_some_and(|value| (value - 0.5_f64.sqrt()).abs() < 0.05),
            "{found:?}"
        );
    }
    // One in twenty, at the confidence of the intervals.
    assert!(flicker <= LOGS / 20 && walks <= LOGS / 20, "{flicker} {walks} of {LOGS}");
}

#[test]
fn a_walk_below_white_noise_is_found_with_both_its_coefficients() {
    let mut noise = Uniform(7);
    let (n, k, period) = (0.01_f64, 0.002_f64, 0.5_f64);
    let mut bias = 0.0;
    let rates: Vec<f64> = (0..40_000)
        .map(|_| {
            bias += k * period.sqrt() * noise.next();
            bias + n / period.sqrt() * noise.next()
        })
        .collect();
    let allan = Allan::of(&rates, period).unwrap();
    let found = allan.coefficients;
    assert!((found.angle_random_walk.value().unwrap() / n - 1.0).abs() < 0.03, "{found:?}");
    assert!((found.rate_random_walk.value().unwrap() / k - 1.0).abs() < 0.15, "{found:?}");
    let noises: Vec<Noise> = allan.points.iter().map(|point| point.noise).collect();
    assert_eq!(noises[3], Noise::AngleRandomWalk);
    assert_eq!(noises[noises.len() - 12], Noise::RateRandomWalk);
}

/// White noise of N = 0.002 at 10 Hz through a filter of gain 1, from its first samples on.
fn filtered(seed: u64, samples: usize, mut filter: impl FnMut(&mut Uniform) -> f64) -> Allan {
    let mut noise = Uniform(seed);
    (0..1000).for_each(|_| {
        filter(&mut noise);
    });
    let rates: Vec<f64> = (0..samples).map(|_| 0.002 / 0.1_f64.sqrt() * filter(&mut noise)).collect();
    Allan::of(&rates, 0.1).unwrap()
}

/// The mean of the newest so many samples.
fn boxcar(length: usize) -> impl FnMut(&mut Uniform) -> f64 {
    let mut held = std::collections::VecDeque::from(vec![0.0; length]);
    move |noise| {
        held.pop_front();
        held.push_back(noise.next());
        held.iter().sum::<f64>() / length as f64
    }
}

/// A filter of first order, by the part of a sample that it takes.
fn pole(part: f64) -> impl FnMut(&mut Uniform) -> f64 {
    let mut held = 0.0;
    move |noise| {
        held += part * (noise.next() - held);
        held
    }
}

/// A filter of 2 s in a log of 2000.
const SHORT: &str = "a long pole in a short log";

#[test]
fn a_filtered_gyro_has_the_random_walk_of_the_noise_before_the_filter() {
    let (mut seen, mut missed) = (0, 0);
    for seed in 1..=20 {
        let found = [
            ("a boxcar of 1 s", filtered(seed * 7001, 72_000, boxcar(10))),
            ("a boxcar of 0.3 s", filtered(seed * 7002, 72_000, boxcar(3))),
            ("a pole", filtered(seed * 7003, 72_000, pole(0.2))),
            (SHORT, filtered(seed * 7004, 20_000, pole(0.05))),
        ];
        for (which, allan) in found {
            match allan.coefficients.angle_random_walk {
                Coefficient::Seen { value, low, high, .. } => {
                    seen += 1;
                    missed += usize::from(low > 0.002 || high < 0.002);
                    assert!((value / 0.002 - 1.0).abs() < 0.15, "{which}, seed {seed}: {value}");
                }
                // A thousand times the filter's own are few averages.
                Coefficient::Hidden { at_most } => {
                    assert!(which == SHORT && at_most > 0.002, "{which}, seed {seed}: below {at_most}");
                }
            }
            assert!(allan.filtered_below_s.is_some_and(|end_s| end_s > 0.2 && end_s < 300.0), "{which}, seed {seed}");
            assert_eq!(allan.points[0].noise, Noise::Filtered);
            let others = [allan.coefficients.bias_instability, allan.coefficients.rate_random_walk];
            assert!(others.iter().all(|other| other.value().is_none_or(|value| value < 2e-4)), "{which}: {others:?}");
        }
    }
    assert!(seen >= 60 && missed <= seen / 8, "{seen} of 80 seen, {missed} of them not within the bounds");
}

#[test]
fn a_gyro_without_a_filter_shows_none() {
    let mut noise = Uniform(5);
    let told = (0..200).filter(|log| {
        let mut bias = 0.0;
        let rates: Vec<f64> = (0..5000)
            .map(|_| {
                bias += f64::from(log % 4) * 0.01 * noise.next();
                bias + noise.next()
            })
            .collect();
        Allan::of(&rates, 0.1).unwrap().filtered_below_s.is_some()
    });
    assert_eq!(told.count(), 0);
}

/// Of 200 records, the bounds at an averaging factor of 8 miss the truth about as often as they say: 5 %.
#[test]
fn the_bounds_hold_the_truth_as_often_as_they_say() {
    let mut noise = Uniform(99);
    let missed = (0..200)
        .filter(|_| {
            let rates: Vec<f64> = (0..512).map(|_| noise.next()).collect();
            let allan = Allan::of(&rates, 1.0).unwrap();
            let point = allan.points.iter().find(|point| (point.tau_s - 8.0).abs() < 0.1).unwrap();
            let truth = 1.0 / 8.0_f64.sqrt();
            point.low > truth || point.high < truth
        })
        .count();
    assert!((2..=20).contains(&missed), "{missed} of 200");
}

/// Normal noise of one: a sum of twelve (Irwin and Hall), of the same generator.
fn normal(noise: &mut Uniform) -> f64 {
    (0..12).map(|_| noise.next()).sum::<f64>() / 12.0_f64.sqrt()
}

/// Of 300 records of 6000 samples of N = 1 at a period of 0.1 s.
#[test]
fn the_bounds_of_n_hold_the_truth_as_often_as_they_say() {
    const RECORDS: usize = 300;
    let mut noise = Uniform(271_828);
    let (mut held, mut sum) = (0, 0.0);
    for _ in 0..RECORDS {
        let rates: Vec<f64> = (0..6000).map(|_| 10.0_f64.sqrt() * normal(&mut noise)).collect();
        let found = Allan::of(&rates, 0.1).unwrap().coefficients.angle_random_walk;
        let Coefficient::Seen { value, low, high, .. } = found else { panic!("{found:?}") };
        held += usize::from(low <= 1.0 && 1.0 <= high);
        sum += value / RECORDS as f64;
    }
    let share = held as f64 / RECORDS as f64;
    assert!((0.91..=0.99).contains(&share), "{held} of {RECORDS}");
    // Each scatters by 1.1 %.
    assert!((sum - 1.0).abs() < 3.0 * 0.011 / (RECORDS as f64).sqrt(), "{sum}");
}

/// White noise of N = 0.005 at 10 Hz for an hour, and a trend; no flicker, no walk.
#[test]
fn a_smooth_trend_is_neither_a_walk_nor_a_flicker() {
    let mut noise = Uniform(31_415);
    let trends = [
        ("a warm-up", (|t| 0.1 * libm::exp(-t / 1200.0)) as fn(f64) -> f64),
        ("a short warm-up", |t| 0.1 * libm::exp(-t / 300.0)),
        ("a lag of two minutes", |t| 0.03 * libm::exp(-t / 120.0)),
        ("a bias that ages", |t| 0.02 * t / 3600.0),
        ("a bend", |t| 0.02 * (t / 3600.0).powi(2)),
    ];
    for (which, trend) in trends {
        for _ in 0..8 {
            let rates: Vec<f64> =
                (0..36_000).map(|i| trend(f64::from(i) * 0.1) + 0.005 * 10.0_f64.sqrt() * normal(&mut noise)).collect();
            let allan = Allan::of(&rates, 0.1).unwrap();
            let found = allan.coefficients;
            assert!(found.rate_random_walk.value().is_none(), "{which}: {found:?}");
            assert!(found.bias_instability.value().is_none(), "{which}: {found:?}");
            assert!((found.angle_random_walk.value().unwrap() / 0.005 - 1.0).abs() < 0.02, "{which}: {found:?}");
        }
    }
}

/// A temperature that the chamber moves to and fro by half a degree, with a drift of 0.02 a degree.
#[test]
fn what_goes_with_the_temperature_is_no_noise() {
    let mut noise = Uniform(16_180);
    let temperatures: Vec<f64> = (0..36_000).map(|i| 25.0 + 0.25 * (f64::from(i) / 900.0).sin()).collect();
    let rates: Vec<f64> =
        temperatures.iter().map(|t| 0.02 * t + 0.005 * 10.0_f64.sqrt() * normal(&mut noise)).collect();
    let found = Allan::of_soak(&rates, &temperatures, 0.1).unwrap();
    assert!(found.smooth_trend, "{found:?}");
    assert!(found.coefficients.rate_random_walk.value().or(found.coefficients.bias_instability.value()).is_none());
}

/// A walk of K = 6e-4 beside N = 0.005, an hour each, with and without a warm-up: its bounds hold it in most.
#[test]
fn a_walk_is_seen_with_its_size_beside_a_trend_and_without_one() {
    let mut noise = Uniform(57_721);
    for trend in [0.0, 0.05] {
        let (mut seen, mut held) = (0, 0);
        for _ in 0..40 {
            let mut walk = 0.0;
            let rates: Vec<f64> = (0..36_000)
                .map(|i| {
                    walk += 6e-4 * 0.1_f64.sqrt() * normal(&mut noise);
                    walk + trend * libm::exp(-f64::from(i) / 12_000.0) + 0.005 * 10.0_f64.sqrt() * normal(&mut noise)
                })
                .collect();
            if let Coefficient::Seen { low, high, .. } = Allan::of(&rates, 0.1).unwrap().coefficients.rate_random_walk {
                seen += 1;
                held += usize::from(low <= 6e-4 && 6e-4 <= high);
            }
        }
        assert!(seen >= 36 && 10 * held >= 9 * seen, "trend {trend}: {held} of {seen} seen");
    }
}

#[test]
fn a_gap_is_left_out_and_not_bridged() {
    // A step of 100 across the gap: any average that bridged it would show.
    let mut noise = Uniform(3);
    let mut rates: Vec<f64> = (0..1000).map(|_| noise.next()).collect();
    rates[500..].iter_mut().for_each(|rate| *rate += 100.0);
    rates[500] = f64::NAN;
    let found = deviation(&rates, 10, 1);
    assert!((found / (1.0 / 10.0_f64.sqrt()) - 1.0).abs() < 0.15, "{found}");
    let without_gap: Vec<f64> = rates.iter().copied().filter(|rate| rate.is_finite()).collect();
    assert!(deviation(&without_gap, 10, 1) > 1.0);
}

#[test]
fn a_bias_a_million_times_the_noise_costs_nothing() {
    let mut noise = Uniform(11);
    let rates: Vec<f64> = (0..2000).map(|_| noise.next()).collect();
    let raised: Vec<f64> = rates.iter().map(|rate| rate + 1e6).collect();
    let (own, other) = (deviation(&rates, 7, 1), deviation(&raised, 7, 1));
    assert!((own / other - 1.0).abs() < 1e-9);
}

#[test]
fn what_has_no_allan_deviation_is_refused_with_a_reason() {
    assert_eq!(Allan::of(&[1.0; 31], 1.0).unwrap_err(), NoAllan::TooShort { samples: 31 });
    assert_eq!(Allan::of(&[1.0; 64], 1.0).unwrap_err(), NoAllan::Constant);
    assert!(matches!(Allan::of(&nist(), f64::NAN).unwrap_err(), NoAllan::NoPeriod { .. }));
    assert!(matches!(Allan::of(&[f64::NAN; 500], 1.0).unwrap_err(), NoAllan::TooShort { samples: 0 }));
}
