//! A zero at start-up: what a device at rest reads in its first half minute, it takes off from then on.

use crate::residual::ResidualStatistics;

/// The time over which the zero is taken, seconds: what autopilots do at boot takes a few; half a minute is long against
/// a group.
pub const BOOT_S: f64 = 30.0;

/// How many of the rows `used`, in order, fall into their first half minute: one at least, half of them at most; 0 of none.
pub(crate) fn booted(time_s: &[f64], used: &[usize]) -> usize {
    let Some(&first) = used.first() else { return 0 };
    let within = |&&row: &&usize| time_s[row] - time_s[first] < BOOT_S;
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
}
