use proptest::prelude::*;

use super::*;

/// Temperatures and rates without a pattern that a block boundary could hide.
fn rows(count: usize, offset: f64) -> (Vec<f64>, Vec<f64>) {
    (0..count)
        .map(|i| {
            let i = i as f64;
            let temperature = 10.0 + 50.0 * (0.37 * i).sin();
            let rate = offset + 0.4 * (temperature / 30.0) - (temperature / 40.0).powi(2) + 0.01 * (12.9 * i).cos();
            (temperature, rate)
        })
        .unzip()
}

fn scale() -> Scale {
    Scale::spanning(-40.0, 60.0).unwrap()
}

fn fit(basis: Basis, temperatures: &[f64], rates: &[f64]) -> Fit {
    let mut fit = Fit::new(scale(), basis);
    fit.push_rows(temperatures, rates);
    fit
}

/// The largest distance of two solutions' curves over the scale, in units of the first one's range.
fn distance(a: &Solution, b: &Solution) -> f64 {
    let curve = |solution: &Solution| -> Vec<f64> {
        let shape = solution.shape().unwrap();
        (0..=100).map(|t| shape.evaluate(-40.0 + f64::from(t))).collect()
    };
    let (a, b) = (curve(a), curve(b));
    let range = a.iter().fold(f64::MIN, |m, v| m.max(*v)) - a.iter().fold(f64::MAX, |m, v| m.min(*v));
    a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / range
}

/// Golden numbers of numpy 2.4:
///
/// ```python
/// i = np.arange(200.0); T = -40 + 0.5 * i
/// y = 0.3 - 0.002*T + 4e-5*T**2 + 1e-7*T**3 + 0.001*np.sin(7*i)
/// np.polynomial.Polynomial.fit(T, y, 3).convert().coef             # raw
/// x = (T - 9.75) / 49.75; p, cov = np.polyfit(x, y, 3, cov=True)   # scaled, covariance
/// np.sqrt(np.mean((y - np.polyval(p, x))**2))                      # rms
/// ```
#[test]
fn a_cubic_agrees_with_numpy() {
    let (temperatures, rates): (Vec<f64>, Vec<f64>) = (0..200)
        .map(|i| {
            let i = f64::from(i);
            let t = -40.0 + 0.5 * i;
            (t, 0.3 - 0.002 * t + 4e-5 * t * t + 1e-7 * t.powi(3) + 0.001 * (7.0 * i).sin())
        })
        .unzip();
    let mut fit = Fit::new(Scale::spanning(-40.0, 59.5).unwrap(), Basis::Powers(3));
    fit.push_rows(&temperatures, &rates);
    let solution = fit.finish().unwrap();
    let raw = [0.2999831661223424, -0.0019995024977402603, 4.004811537086428e-05, 9.895444348982677e-08];
    let scaled = [0.284386807590464, -0.05921959796336956, 0.10628545269458334, 0.012184692006430629];
    let variances = [5.719728300995071e-09, 4.719642333230201e-08, 2.8033280255461107e-08, 1.0795514434880659e-07];
    for (got, golden) in solution.raw_coefficients().iter().zip(raw) {
        assert!((got / golden - 1.0).abs() < 1e-11, "{got} {golden}");
    }
    for (got, golden) in solution.coefficients.iter().zip(scaled) {
        assert!((got - golden).abs() < 1e-14, "{got} {golden}");
    }
    for (got, golden) in (0..4).map(|k| solution.covariance[k][k]).zip(variances) {
        assert!((got / golden - 1.0).abs() < 1e-9, "{got} {golden}");
    }
    assert!((solution.rms / 0.0007058548900779377 - 1.0).abs() < 1e-9);
    assert_eq!(solution.rows, 200);
}

proptest! {
    #[test]
    fn partitions_merged_in_any_order_give_one_curve(
        cuts in proptest::collection::vec(0_usize..5000, 6),
        order in Just((0..7_usize).collect::<Vec<_>>()).prop_shuffle(),
        size in 1_usize..=5,
    ) {
        let (temperatures, rates) = rows(5000, 3.0);
        let mut cuts = cuts;
        cuts.extend([0, 5000]);
        cuts.sort_unstable();
        for basis in [Basis::Powers(size), Basis::PiecewiseLinear(4 * size)] {
            let whole = fit(basis, &temperatures, &rates).finish().unwrap();
            let parts: Vec<Fit> = cuts
                .windows(2)
                .map(|cut| fit(basis, &temperatures[cut[0]..cut[1]], &rates[cut[0]..cut[1]]))
                .collect();
            let mut seven = Fit::new(scale(), basis);
            order.iter().for_each(|&part| seven.merge(&parts[part]));
            let mut two = fit(basis, &temperatures[cuts[3]..], &rates[cuts[3]..]);
            two.merge(&fit(basis, &temperatures[..cuts[3]], &rates[..cuts[3]]));
            for merged in [seven, two] {
                let merged = merged.finish().unwrap();
                prop_assert!(distance(&whole, &merged) < 1e-12);
                prop_assert!((merged.rms / whole.rms - 1.0).abs() < 1e-10);
                prop_assert_eq!(merged.rows, 5000);
            }
        }
    }
}

#[test]
fn rows_one_by_one_give_the_same_bits_as_columns() {
    let (temperatures, rates) = rows(700, 3.0);
    let columns = fit(Basis::Powers(3), &temperatures, &rates).finish().unwrap();
    let mut single = Fit::new(scale(), Basis::Powers(3));
    temperatures.iter().zip(&rates).for_each(|(t, r)| single.push(*t, *r));
    assert_eq!(single.finish().unwrap(), columns);
}

#[test]
fn an_offset_a_million_times_the_noise_leaves_the_rms_right() {
    let noise = |i: usize| ((i * 7919) % 1000) as f64 / 1000.0 - 0.4995;
    // Uniform over one: the variance is 1/12.
    let noise_rms = (1.0_f64 / 12.0).sqrt();
    let (temperatures, _) = rows(100_000, 0.0);
    let rates: Vec<f64> = (0..100_000).map(|i| 1e6 * noise_rms + noise(i)).collect();
    for basis in [Basis::Powers(5), Basis::PiecewiseLinear(16)] {
        let rms = fit(basis, &temperatures, &rates).finish().unwrap().rms;
        assert!((rms / noise_rms - 1.0).abs() < 0.01, "{rms} {noise_rms}");
    }
}

#[test]
fn the_held_out_sum_of_squares_is_that_of_a_second_pass() {
    let (temperatures, rates) = rows(1000, 3.0);
    let trained = fit(Basis::Powers(2), &temperatures[..600], &rates[..600]).finish().unwrap();
    let held_out = fit(Basis::Powers(2), &temperatures[600..], &rates[600..]);
    let shape = trained.shape().unwrap();
    let second_pass: f64 =
        temperatures[600..].iter().zip(&rates[600..]).map(|(t, r)| (r - shape.evaluate(*t)).powi(2)).sum();
    let from_factor = held_out.sum_of_squares_of(&trained.coefficients);
    assert!((from_factor / second_pass - 1.0).abs() < 1e-11, "{from_factor} {second_pass}");
}

#[test]
fn a_lowered_fit_is_the_fit_of_the_lower_order() {
    let (temperatures, rates) = rows(1000, 3.0);
    let fifth = fit(Basis::Powers(5), &temperatures, &rates);
    for order in 1..=5 {
        let lowered = fifth.lowered(order).unwrap().finish().unwrap();
        let direct = fit(Basis::Powers(order), &temperatures, &rates).finish().unwrap();
        assert!(distance(&direct, &lowered) < 1e-12);
        assert!((lowered.rms / direct.rms - 1.0).abs() < 1e-10);
    }
    assert!(fifth.lowered(6).is_none());
}

#[test]
fn a_table_goes_straight_over_a_gap_in_the_data() {
    let temperatures: Vec<f64> = (-40..=60).filter(|t| !(0..30).contains(t)).map(f64::from).collect();
    let rates: Vec<f64> = temperatures.iter().map(|t| 2.0 + 0.1 * t).collect();
    let table = fit(Basis::PiecewiseLinear(10), &temperatures, &rates).finish().unwrap();
    let shape = table.shape().unwrap();
    for t in -40..=60 {
        assert!((shape.evaluate(f64::from(t)) - 2.0 - 0.1 * f64::from(t)).abs() < 1e-6);
    }
}

#[test]
fn what_cannot_be_fitted_says_why() {
    let mut fit = Fit::new(scale(), Basis::Powers(3));
    fit.push(1.0, 1.0);
    assert_eq!(fit.finish(), Err(FitError::TooFewRows { rows: 1, coefficients: 4 }));
    (0..600).for_each(|i| fit.push(f64::from(i % 2), 1.0));
    assert_eq!(fit.finish(), Err(FitError::Undetermined { coefficients: 4 }));
    fit.push(f64::NAN, 1.0);
    assert_eq!(fit.finish(), Err(FitError::NotFinite));
}
