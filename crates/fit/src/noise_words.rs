//! What a log's noise is known by wherever a part of it begins: rows that were rounded, scaled or shifted, and rows of which a
//! column is missing, are other rows, and rise and fall as they did.
//!
//! A word is of 64 successive changes of one axis, a bit each: whether it rose. From row to row that is noise, for a drift is
//! far slower. Rounding turns a change here and there, and leaves the words between them.

use crate::marks::Marks;
use crate::mixed::mixed;

/// The words of one sensor's noise.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseWords {
    axes: Vec<Axis>,
    /// Words of all axes: which column is which may differ in a copy.
    marks: Marks,
}

#[derive(Debug, Clone, PartialEq)]
struct Axis {
    last: f64,
    word: u64,
    changes: u64,
}

impl Default for NoiseWords {
    fn default() -> Self {
        Self { axes: Vec::new(), marks: Marks::new("noise") }
    }
}

impl NoiseWords {
    /// Takes in successive rows: a column of values an axis, all as long.
    pub fn push_rows<A: AsRef<[f64]>>(&mut self, values: &[A]) {
        self.axes.resize(values.len(), Axis { last: f64::NAN, word: 0, changes: 0 });
        for (axis, values) in self.axes.iter_mut().zip(values) {
            for value in values.as_ref().iter().copied().filter(|value| value.is_finite()) {
                let before = std::mem::replace(&mut axis.last, value);
                // A row that is like the one before says nothing of noise, nor does the first.
                let Some(change) = value.partial_cmp(&before).filter(|change| change.is_ne()) else { continue };
                axis.word = axis.word << 1 | u64::from(change.is_gt());
                axis.changes += 1;
                if axis.changes >= u64::from(u64::BITS) {
                    self.marks.push(mixed(axis.word));
                }
            }
        }
    }

    /// As a calibration keeps some of them; none where they do not tell the log from others.
    #[must_use]
    pub fn written(&self) -> Vec<String> {
        self.marks.written()
    }

    /// Whether so many of these were written of another log that this is of its noise.
    #[must_use]
    pub fn are_of(&self, written: &[String]) -> bool {
        self.marks.are_of(written)
    }

    /// Whether two logs have a part of their noise in common.
    #[must_use]
    pub fn are_those_of(&self, other: &Self) -> bool {
        self.marks.are_those_of(&other.marks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise of one, made of twelve uniform numbers.
    fn noise(seed: u64, rows: std::ops::Range<u64>) -> Vec<f64> {
        let uniform = |row: u64, part: u64| mixed(mixed(seed << 32 | row) ^ part) as f64 / u64::MAX as f64;
        rows.map(|row| (0..12).map(|part| uniform(row, part)).sum::<f64>() - 6.0).collect()
    }

    fn words(columns: &[Vec<f64>]) -> NoiseWords {
        let mut words = NoiseWords::default();
        // A slow drift is no noise.
        let drifting = |column: &Vec<f64>| column.iter().enumerate().map(|(row, v)| v + 1e-4 * row as f64).collect();
        words.push_rows(&columns.iter().map(drifting).collect::<Vec<Vec<f64>>>());
        words
    }

    fn rounded(column: Vec<f64>, step: f64) -> Vec<f64> {
        column.into_iter().map(|value| (value / step).round() * step).collect()
    }

    #[test]
    fn a_part_in_other_numbers_or_fewer_columns_is_known_by_its_noise() {
        let axes = |rows: std::ops::Range<u64>| [1, 2, 3].map(|seed| noise(seed, rows.clone()));
        let whole = words(&axes(0..20_000));
        let written = whole.written();
        let [x, _, z] = axes(10_000..30_000);
        let scaled = |column: &[f64]| column.iter().map(|value| 57.295_78 * value - 4.0).collect::<Vec<_>>();
        for copy in [
            [rounded(x.clone(), 1e-3), rounded(z.clone(), 1e-3)],
            [rounded(x.clone(), 0.03), rounded(z.clone(), 0.03)],
            [scaled(&z), scaled(&x)],
        ] {
            let copy = words(&copy);
            assert!(copy.are_those_of(&whole) && whole.are_those_of(&copy) && copy.are_of(&written));
        }
    }

    /// Fine and coarse ones, those that rest within a step, and those behind a filter.
    #[test]
    fn another_run_is_not() {
        let filtered = |column: Vec<f64>| {
            let mut state = 0.0;
            let filter = |value: f64| {
                state += 0.1 * (value - state);
                state
            };
            column.into_iter().map(filter).collect::<Vec<_>>()
        };
        type Shown<'a> = &'a dyn Fn(Vec<f64>) -> Vec<f64>;
        let shown: [Shown; 7] = [
            &|column| column,
            &|column| rounded(column, 0.3),
            &|column| rounded(column, 1.0),
            &|column| rounded(column, 3.0),
            &|column| rounded(column, 6.0),
            &|column| filtered(column),
            &|column| rounded(filtered(column), 0.5),
        ];
        for (place, shown) in shown.iter().enumerate() {
            for seed in 0..20 {
                let [one, other] = [seed, 100 + seed].map(|seed| words(&[shown(noise(seed, 0..30_000))]));
                assert!(!one.are_those_of(&other) && !one.are_of(&other.written()), "{place}, seed {seed}");
            }
        }
    }
}
