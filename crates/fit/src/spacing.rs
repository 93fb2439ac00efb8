//! How far apart successive times are as a rule, whatever gaps lie between some of them.
//!
//! Differences are counted in bins of a quarter of an octave, so that a log of any length needs one pass and little memory.

/// Bins an octave.
const BINS_AN_OCTAVE: f64 = 4.0;
/// Differences below 2^-40 of the times' unit are 0, and those above 2^80 are alike.
const LEAST_OCTAVE: f64 = -40.0;
const MOST_OCTAVE: f64 = 80.0;
const BINS: usize = 481;

/// A difference of so many typical ones is a gap.
const GAP: f64 = 16.0;

/// The differences of successive times.
#[derive(Debug, Clone, PartialEq)]
pub struct Spacing {
    /// How many differences lie in each bin, and their sum.
    bins: Vec<(u64, f64)>,
    last: f64,
}

impl Default for Spacing {
    fn default() -> Self {
        Self { bins: vec![(0, 0.0); BINS], last: f64::NAN }
    }
}

impl Spacing {
    /// Takes in the next time; one that is no number is passed over.
    pub fn push(&mut self, time: f64) {
        if !time.is_finite() {
            return;
        }
        let apart = time - self.last;
        self.last = time;
        if apart.is_nan() {
            return;
        }
        let bin = &mut self.bins[bin(apart)];
        *bin = (bin.0 + 1, bin.1 + apart);
    }

    /// How many differences are gaps, and their sum: those of 16 typical ones, and of `least` at least.
    #[must_use]
    pub fn gaps(&self, least: f64) -> (u64, f64) {
        let all: u64 = self.bins.iter().map(|(count, _)| count).sum();
        let mut before = 0;
        let middle = self.bins.iter().position(|(count, _)| {
            before += count;
            2 * before >= all
        });
        let typical = middle.map_or(0.0, |bin| edge(bin + 1));
        let first = bin((GAP * typical).max(least)) + 1;
        let gaps = self.bins.iter().skip(first);
        gaps.fold((0, 0.0), |(count, sum), bin| (count + bin.0, sum + bin.1))
    }
}

/// The bin of a difference.
// From 0 to the last bin.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn bin(apart: f64) -> usize {
    (BINS_AN_OCTAVE * (libm::log2(apart.max(0.0)).clamp(LEAST_OCTAVE, MOST_OCTAVE) - LEAST_OCTAVE)) as usize
}

/// Where a bin begins.
fn edge(bin: usize) -> f64 {
    libm::exp2(bin as f64 / BINS_AN_OCTAVE + LEAST_OCTAVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gaps(times: impl Iterator<Item = f64>, least: f64) -> (u64, f64) {
        let mut spacing = Spacing::default();
        times.for_each(|time| spacing.push(time));
        spacing.gaps(least)
    }

    #[test]
    fn what_is_far_longer_than_the_others_is_a_gap_in_any_unit() {
        for unit in [1.0, 1e-3, 1e6, 1e9] {
            let even = |from: f64| (0..1000).map(move |row| (from + 0.5 * f64::from(row)) * unit);
            assert_eq!(gaps(even(0.0), 0.0), (0, 0.0));
            let (count, sum) = gaps(even(0.0).chain(even(1500.0)).chain(even(90_000.0)), 15.0 * unit);
            assert_eq!(count, 2);
            let apart = (1500.0 - 499.5) + (90_000.0 - 1999.5);
            assert!((sum / unit - apart).abs() < 1e-6, "{sum}");
        }
    }

    #[test]
    fn rows_that_come_in_bursts_or_without_a_time_have_no_gaps_for_that() {
        // Ten rows of one time, a second apart.
        assert_eq!(gaps((0..1000).map(|row: u32| f64::from(row / 10)), 15.0), (0, 0.0));
        let holes = (0..1000_u32).map(|row| if row % 3 == 0 { f64::NAN } else { f64::from(row) });
        assert_eq!(gaps(holes, 15.0), (0, 0.0));
        assert_eq!(gaps(std::iter::empty(), 15.0), (0, 0.0));
    }
}
