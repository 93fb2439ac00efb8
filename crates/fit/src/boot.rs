//! A zero at start-up: what a device at rest reads in its first half minute, it takes off from then on.

use crate::residual::ResidualStatistics;

/// The time over which the zero is taken, seconds: what autopilots do at boot takes a few; half a minute is long against
/// a group.
pub const BOOT_S: f64 = 30.0;

/// By so many first rows is told how far apart they are, or more where some are missing.
const FIRST: usize = 8;

/// How many of the rows `used`, in order, fall into their first half minute: one at least, half of them at most; 0 of none. A
/// row's time is the middle of it, and it lasts until half way to the next: of averages over 10 s three.
pub(crate) fn booted(time_s: &[f64], used: &[usize]) -> usize {
    let Some(&first) = used.first() else { return 0 };
    let steps = used.windows(2).map(|pair| time_s[pair[1]] - time_s[pair[0]]);
    let step = steps.take(FIRST).filter(|step| *step > 0.0).fold(BOOT_S, f64::min);
    let within = |&&row: &&usize| time_s[row] - time_s[first] < BOOT_S - 0.5 * step;
    used.iter().take_while(within).count().clamp(1, (used.len() / 2).max(1))
}

/// Takes the mean of the first half minute of the rows `used`, in order, off all of them; that half minute is left NaN,
/// for it is no prediction. One row at least is the start, half of them at most. Times in seconds; rates in any unit.
pub fn take_zero_off(residuals: &mut [f64], time_s: &[f64], used: &[usize]) {
    let booted = booted(time_s, used);
    let zero = used[..booted].iter().map(|&row| residuals[row]).sum::<f64>() / booted as f64;
    for (place, &row) in used.iter().enumerate() {
        residuals[row] = if place < booted { f64::NAN } else { residuals[row] - zero };
    }
}

/// How the noise of the zero itself varies the sum of squares of what is left of a run, which all of it shifts: a variance.
/// `used` are the run's rows, their zero taken off.
///
/// The variance of the square of a mean m that has the variance v is `4 m^2 v + 2 v^2`, with `m^2 - v` in the place of a square
/// that was found with that noise in it.
pub(crate) fn variance_by_the_zero(residuals: &[f64], time_s: &[f64], used: &[usize]) -> f64 {
    let Zero { count, mean, variance } = Zero::of(residuals, time_s, used);
    let squares = count.powi(2) * (4.0 * (mean.powi(2) - variance).max(0.0) * variance + 2.0 * variance.powi(2));
    if squares.is_finite() { squares } else { 0.0 }
}

/// Gives a run, of which the zero was taken off, another one that its noise might have made: by one standard deviation to a
/// `side` (1 or -1) of where it is, less what of that its own noise will have done.
pub(crate) fn move_zero(residuals: &mut [f64], time_s: &[f64], used: &[usize], side: f64) {
    let Zero { mean, variance, .. } = Zero::of(residuals, time_s, used);
    let of_the_run = (mean.powi(2) - variance).max(0.0).sqrt().copysign(mean);
    let shift = of_the_run - mean + side * variance.sqrt();
    if shift.is_finite() {
        used.iter().for_each(|&row| residuals[row] += shift);
    }
}

/// What is known of a zero by what it left.
struct Zero {
    /// How much is left of the run.
    count: f64,
    /// The mean of that, and its variance by the zero's noise.
    mean: f64,
    variance: f64,
}

impl Zero {
    /// The noise s of a row is by neighbours' differences, `s^2 = sum (r[k+1] - r[k])^2 / 2 n` (von Neumann et al., 1941), so
    /// that what a curve leaves is no part of it. A zero of b rows has the variance `s^2 / b`.
    fn of(residuals: &[f64], time_s: &[f64], used: &[usize]) -> Self {
        let left: Vec<f64> = used.iter().map(|&row| residuals[row]).filter(|left| left.is_finite()).collect();
        let count = left.len() as f64;
        let differences = left.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum::<f64>();
        let variance = differences / (2.0 * (count - 1.0)) / booted(time_s, used) as f64;
        Self { count, mean: left.iter().sum::<f64>() / count, variance }
    }
}

/// What is left of a run after its zero was taken off, about nothing: rates less predictions in, one a time.
#[must_use]
pub fn left_after_zero(mut residuals: Vec<f64>, time_s: &[f64]) -> ResidualStatistics {
    let all: Vec<usize> = (0..residuals.len()).collect();
    take_zero_off(&mut residuals, time_s, &all);
    ResidualStatistics::of(residuals)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_the_first_half_minute_goes_and_the_half_minute_with_it() {
        // 1, 2, 3 until 20 s: a zero of 2. Then 2 + 3, 2 - 4 and 2.
        let times = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0];
        let left = left_after_zero(vec![1.0, 2.0, 3.0, 5.0, -2.0, 2.0], &times);
        assert!((left.rms - (25.0_f64 / 3.0).sqrt()).abs() < 1e-12 && (left.pp - 7.0).abs() < 1e-12, "{left:?}");
    }

    #[test]
    fn without_times_the_first_row_is_the_start_and_of_two_rows_one_is_left() {
        assert!((left_after_zero(vec![1.0, 4.0], &[f64::NAN; 2]).rms - 3.0).abs() < 1e-12);
        assert!((left_after_zero(vec![1.0, 4.0], &[0.0, 1.0]).rms - 3.0).abs() < 1e-12);
        assert!(left_after_zero(Vec::new(), &[]).rms.is_nan());
    }

    /// Runs of noise alone, about a level that the curve misses by `missed` from the start on.
    fn variances(missed: f64) -> (f64, f64) {
        let mut state = 5_u64;
        let mut noise = || {
            let uniform = |state: &mut u64| {
                *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (*state >> 11) as f64 / (1_u64 << 53) as f64
            };
            (0..12).map(|_| uniform(&mut state)).sum::<f64>() - 6.0
        };
        let times: Vec<f64> = (0..200).map(|row| 10.0 * f64::from(row)).collect();
        let all: Vec<usize> = (0..200).collect();
        let runs = (0..2000).map(|_| {
            let mut left: Vec<f64> = all.iter().map(|&row| noise() + if row < 3 { 0.0 } else { missed }).collect();
            take_zero_off(&mut left, &times, &all);
            (
                left.iter().filter(|left| left.is_finite()).map(|left| left * left).sum::<f64>(),
                variance_by_the_zero(&left, &times, &all),
            )
        });
        let runs: Vec<(f64, f64)> = runs.collect();
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| runs.iter().map(of).sum::<f64>() / runs.len() as f64;
        let level = mean(&|run| run.0);
        (mean(&|run| (run.0 - level).powi(2)), mean(&|run| run.1))
    }

    #[test]
    fn what_the_zero_varies_is_told() {
        for missed in [0.0, 0.5, 3.0] {
            let (truth, told) = variances(missed);
            // The noise's own share of the variance, two a row, is the folds' to tell.
            let ratio = (told + 2.0 * 197.0) / truth;
            // Twice it where there is nothing but that noise: a square is never taken for less than none.
            assert!((0.85..2.1).contains(&ratio), "missed by {missed}: {told} for {truth}");
        }
    }
}
