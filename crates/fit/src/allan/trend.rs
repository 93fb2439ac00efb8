//! A smooth trend of a record, which is no noise: what is left of a warm-up, a bias that ages, a temperature that creeps.
//!
//! It raises the Allan deviation at long averaging times as a walk or flicker does, and the curve alone does not tell them apart.
//! The record does: a trend can be taken off it, a walk comes again at every length. IEEE Std 952-1997 gives a rate ramp its own
//! coefficient R (annex C.1.5); here the ramp is one of the terms.

/// Time constants of a settling that are tried, as parts of the record.
const SETTLINGS: [f64; 7] = [1.0 / 64.0, 1.0 / 32.0, 1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0, 1.0];

/// The temperature's noise is no trend: it is averaged over this part of the record.
const SMOOTHED: usize = 96;

/// Averaging times up to this part of the record are read of what the trend leaves. At longer ones the trend takes too much of a
/// walk: of its variance 15 % at this part, 30 % at twice, 57 % at four times (found by drawing walks).
pub(super) const READ: usize = 32;

/// What a trend leaves of the rates: a constant, time, its square, the temperatures if there are any, and that settling from the
/// record's start which explains most. NaN stays.
pub(super) fn without(rates: &[f64], temperatures: Option<&[f64]>) -> Vec<f64> {
    let place = |i: usize| i as f64 / rates.len() as f64;
    let column = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
        rates.iter().enumerate().map(|(i, rate)| if rate.is_finite() { of(place(i)) } else { 0.0 }).collect()
    };
    let mut left: Vec<f64> = rates.iter().map(|rate| if rate.is_finite() { *rate } else { 0.0 }).collect();
    let mut terms: Vec<Vec<f64>> = Vec::new();
    let mut plain = vec![column(&|_| 1.0), column(&|x| x), column(&|x| x * x)];
    if let Some(temperatures) = temperatures {
        let smooth = smoothed(temperatures);
        plain.push(rates.iter().zip(smooth).map(|(rate, t)| if rate.is_finite() { t } else { 0.0 }).collect());
    }
    for term in plain {
        terms.extend(orthogonal(term, &terms));
    }
    for term in &terms {
        take_off(&mut left, term);
    }
    let settlings = SETTLINGS.iter().filter_map(|part| orthogonal(column(&|x| libm::exp(-x / part)), &terms));
    if let Some(settling) = settlings.max_by(|a, b| dot(&left, a).abs().total_cmp(&dot(&left, b).abs())) {
        take_off(&mut left, &settling);
    }
    left.into_iter().zip(rates).map(|(left, rate)| if rate.is_finite() { left } else { f64::NAN }).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes the share of a term of length one off.
fn take_off(values: &mut [f64], term: &[f64]) {
    let share = dot(values, term);
    values.iter_mut().zip(term).for_each(|(value, term)| *value -= share * term);
}

/// A term less its shares of those before it, of length one; none where next to nothing is left of it.
fn orthogonal(mut term: Vec<f64>, before: &[Vec<f64>]) -> Option<Vec<f64>> {
    let whole = dot(&term, &term);
    // Twice: after once a term that nearly is a sum of the others still has shares of them.
    for _ in 0..2 {
        before.iter().for_each(|other| take_off(&mut term, other));
    }
    let length = dot(&term, &term);
    (length > 1e-12 * whole).then(|| {
        let scale = length.sqrt().recip();
        term.iter_mut().for_each(|value| *value *= scale);
        term
    })
}

/// Means over blocks, and lines from one block's middle to the next; about the mean of all, where there is none 0.
fn smoothed(values: &[f64]) -> Vec<f64> {
    let block = values.len().div_ceil(SMOOTHED).max(1);
    let mean = |of: &[f64]| {
        let finite = || of.iter().filter(|value| value.is_finite());
        finite().sum::<f64>() / finite().count() as f64
    };
    let all = mean(values);
    let about = |mean: f64| if mean.is_finite() { mean - all } else { 0.0 };
    let means: Vec<f64> = values.chunks(block).map(|block| about(mean(block))).collect();
    // A place is above zero and below the number of blocks; half a block at either end goes on as the next does.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let at = |i: usize| {
        let place = (i as f64 + 0.5) / block as f64 - 0.5;
        let before = (place.max(0.0) as usize).min(means.len().saturating_sub(2));
        let after = (before + 1).min(means.len() - 1);
        means[before] + (place - before as f64) * (means[after] - means[before])
    };
    (0..values.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_a_trend_is_taken_off_and_a_gap_stays() {
        let temperature = |x: f64| (20.0 * x).sin();
        let of = |x: f64| 5.0 + 3.0 * x - 2.0 * x * x + 4.0 * (-x / 0.125).exp() + 0.3 * temperature(x);
        let places: Vec<f64> = (0..9600).map(|i| f64::from(i) / 9600.0).collect();
        let mut rates: Vec<f64> = places.iter().map(|x| of(*x)).collect();
        rates[4000] = f64::NAN;
        let temperatures: Vec<f64> = places.iter().map(|x| temperature(*x)).collect();
        let left = without(&rates, Some(&temperatures));
        assert!(left[4000].is_nan());
        // Of the temperature a block's mean is taken, which is off by the bend within it.
        assert!(left.iter().filter(|left| left.is_finite()).all(|left| left.abs() < 0.01), "{:?}", &left[..3]);
    }
}
