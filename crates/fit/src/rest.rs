//! Whether a gyro whose rates are taken as rad/s ever rests: where it does not, they are in another unit.

/// Half a minute's turn a second; no drift takes a gyro so far from its median (a log's fit calls it a rotation).
const MOVED_RAD_PER_S: f64 = 0.3;
/// A log at rest is not moved for a fifth of its rows.
const MOVED_SHARE: f64 = 0.2;
/// 34 deg/s: the worst zero-rate output in the data sheets of cheap parts is 20.
const FARTHEST_ZERO_RAD_PER_S: f64 = 0.6;
/// 1.7 deg/s rms from row to row: a noisy part sampled fast has a third of it.
const LOUDEST_RAD_PER_S: f64 = 0.03;

/// From the median of the size of differences between rows to their standard deviation, if it is Gaussian:
/// 1 / (0.6745 sqrt 2).
const MEDIAN_TO_SIGMA: f64 = 1.048;

/// The width of a bin of rates, rad/s, and how many of them lie on each side of 0.
const BIN: f64 = 0.05;
const BINS: usize = 1000;

/// Bins of differences: four an octave, from 2^-30 on.
const OCTAVE: f64 = 4.0;
const LEAST_OCTAVE: f64 = -30.0;

/// How one axis's rates lie, taken as rad/s.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    rows: u64,
    bins: Vec<u64>,
    differences: Vec<u64>,
    last: f64,
}

impl Default for Spread {
    fn default() -> Self {
        Self { rows: 0, bins: vec![0; 2 * BINS + 1], differences: vec![0; 2 * BINS], last: f64::NAN }
    }
}

impl Spread {
    /// Takes in successive rates; those that are no number are passed over.
    // Clamped to the bins there are.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn take(&mut self, rates: &[f64]) {
        for &rate in rates.iter().filter(|rate| rate.is_finite()) {
            self.rows += 1;
            let bin = (rate / BIN).round() + BINS as f64;
            self.bins[(bin.max(0.0) as usize).min(2 * BINS)] += 1;
            let octave = libm::log2((rate - self.last).abs());
            if !octave.is_nan() {
                let bin = OCTAVE * (octave - LEAST_OCTAVE);
                self.differences[(bin.max(0.0) as usize).min(2 * BINS - 1)] += 1;
            }
            self.last = rate;
        }
    }

    /// Whether the gyro would never rest, if these were rad/s.
    #[must_use]
    pub fn never_rests(&self) -> bool {
        let Some(median) = middle(&self.bins) else { return false };
        let reach = MOVED_RAD_PER_S / BIN;
        let is_far = |bin: usize| (bin as f64 - median as f64).abs() > reach;
        let moved: u64 = (0..self.bins.len()).filter(|bin| is_far(*bin)).map(|bin| self.bins[bin]).sum();
        let zero = BIN * (median as f64 - BINS as f64).abs();
        let noise = middle(&self.differences)
            .map_or(0.0, |bin| MEDIAN_TO_SIGMA * libm::exp2((bin as f64 + 0.5) / OCTAVE + LEAST_OCTAVE));
        moved as f64 > MOVED_SHARE * self.rows as f64 || zero > FARTHEST_ZERO_RAD_PER_S || noise > LOUDEST_RAD_PER_S
    }
}

/// The bin in which the median lies.
fn middle(bins: &[u64]) -> Option<usize> {
    let half = bins.iter().sum::<u64>().div_ceil(2);
    let mut below = 0;
    bins.iter().position(|count| {
        below += count;
        half > 0 && below >= half
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn never_rests(rate: impl Fn(f64) -> f64) -> bool {
        let mut spread = Spread::default();
        spread.take(&(0..4000).map(|row| rate(f64::from(row))).collect::<Vec<_>>());
        spread.never_rests()
    }

    #[test]
    fn a_gyro_in_degrees_is_not_taken_for_one_in_radians() {
        let noise = |row: f64| (row * 12.9898).sin() * 2.0_f64.sqrt();
        // A part with 0.1 deg/s of noise, 0.5 of bias and 2 of drift: at rest in either unit where it is written in rad/s.
        let dps = |row: f64| 0.5 + 2.0 * row / 4000.0 + 0.1 * noise(row);
        assert!(never_rests(dps));
        assert!(!never_rests(|row| dps(row).to_radians()));
        // Without drift its noise tells, or its bias.
        assert!(never_rests(|row| 0.1 * noise(row)));
        assert!(never_rests(|row| 3.0 + 0.001 * noise(row)));
        // A gyro in rad/s that is turned by hand for a tenth of the log rests all the same.
        assert!(!never_rests(|row| if row < 400.0 { 2.0 } else { 0.001 * noise(row) }));
    }
}
