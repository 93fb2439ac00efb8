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

/// A clock whose rows stand at whole multiples of a period but for so much of it is even: some rows may be lost. One that jitters is
/// off by a fourth.
const EVEN: f64 = 0.05;

/// Of differences a tenth at most is nothing: rows that come in bursts have no period of their own.
const MOST_OF_NOTHING: f64 = 0.1;

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
        let typical = self.within(1, 2);
        let first = bin((GAP * typical).max(least)) + 1;
        let gaps = self.bins.iter().skip(first);
        gaps.fold((0, 0.0), |(count, sum), bin| (count + bin.0, sum + bin.1))
    }

    /// The time from one row to the next of an even clock, of whose rows some may be lost; `None` of one that jitters, and of rows
    /// that come in bursts.
    #[must_use]
    pub fn even_period(&self) -> Option<f64> {
        let all: u64 = self.bins.iter().map(|(count, _)| count).sum();
        let moved: Vec<(f64, f64)> =
            self.bins[1..].iter().filter(|(count, _)| *count > 0).map(|&(count, sum)| (count as f64, sum)).collect();
        let count: f64 = moved.iter().map(|(count, _)| count).sum();
        if count < (1.0 - MOST_OF_NOTHING) * all as f64 {
            return None;
        }
        let mut before = 0.0;
        let (first, sum) = moved.iter().find(|(own, _)| {
            before += own;
            10.0 * before >= count
        })?;
        // The shortest differences are of rows between which none was lost, but for a few.
        let mut period = sum / first;
        let places = |period: f64| {
            let of = move |&(count, sum): &(f64, f64)| (count, sum, (sum / count / period).round().max(1.0));
            // A bin of longer ones has those of several places.
            moved.iter().map(of).filter(|(.., places)| *places < 5.0)
        };
        for _ in 0..4 {
            let (sums, rows) =
                places(period).fold((0.0, 0.0), |(s, n), (count, sum, places)| (s + sum, n + count * places));
            period = sums / rows;
        }
        let (off, of) = places(period).fold((0.0, 0.0), |(off, of), (count, sum, places)| {
            (off + count * (sum / count / period - places).abs(), of + count)
        });
        (off <= EVEN * of).then_some(period)
    }

    /// How long a difference may be and still be as usual: 99 of 100 are no longer.
    #[must_use]
    pub fn usual(&self) -> f64 {
        self.within(99, 100)
    }

    /// The end of the bin up to which so many of so many differences lie; 0 without any.
    fn within(&self, part: u64, of: u64) -> f64 {
        let all: u64 = self.bins.iter().map(|(count, _)| count).sum();
        let mut before = 0;
        let last = self.bins.iter().position(|(count, _)| {
            before += count;
            of * before >= part * all
        });
        last.map_or(0.0, |bin| edge(bin + 1))
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
    fn the_period_of_an_even_clock_is_found_whatever_rows_are_lost_and_one_that_jitters_has_none() {
        let period = |times: &mut dyn Iterator<Item = f64>| {
            let mut spacing = Spacing::default();
            times.for_each(|time| spacing.push(time));
            spacing.even_period()
        };
        // Multiplied by an odd number, the low bits of rows are as thrown.
        let thrown = |row: u32| f64::from(row.wrapping_mul(2_654_435_761) >> 16) / 65_536.0;
        for lost in [0.0, 0.1, 0.3, 0.5] {
            let found = period(&mut (0..5000).filter(|row| thrown(*row) >= lost).map(|row| 3.0 + 0.1 * f64::from(row)));
            assert!(found.is_some_and(|found| (found - 0.1).abs() < 1e-4), "{lost}: {found:?}");
        }
        // A second of every four, and 15 of every 60.
        for (of, kept) in [(40, 30), (600, 450)] {
            let found = period(&mut (0..6000).filter(|row| row % of < kept).map(|row| 0.1 * f64::from(row)));
            assert!(found.is_some_and(|found| (found - 0.1).abs() < 1e-4), "{found:?}");
        }
        assert_eq!(period(&mut (0..5000).map(|row| 0.1 * (f64::from(row) + 0.5 * thrown(row)))), None);
        assert_eq!(period(&mut (0..5000).map(|row| f64::from(row / 10))), None);
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
