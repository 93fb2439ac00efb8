//! Blocked cross-validation: the folds of a record.
//!
//! A fold is contiguous, of several logs one part of each. Neighbouring rows are alike, so rows dealt out at random would show a
//! model its own test.

use std::ops::Range;

/// The folds of a record.
pub const FOLDS: usize = 8;

/// One rms is told from another if it is so many times that: a twentieth is as little as eight folds tell.
pub const TELLING: f64 = 1.05;

/// The rows of a fold, 0 to 7, of a record of so many rows: `fold n / 8` to `(fold + 1) n / 8`, rounded down.
#[must_use]
pub fn rows_of_fold(fold: usize, rows: usize) -> Range<usize> {
    fold * rows / FOLDS..(fold + 1) * rows / FOLDS
}

/// What is held out at a time: a part of each log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fold(Vec<Range<usize>>);

impl Fold {
    /// The folds of several logs, one after the other: of each log the same eighth, so that what is held out of a log lasts as
    /// long whatever logs stand beside it.
    #[must_use]
    pub fn of_logs(logs: &[Range<usize>]) -> Vec<Self> {
        let part = |log: &Range<usize>, fold| {
            let rows = rows_of_fold(fold, log.len());
            log.start + rows.start..log.start + rows.end
        };
        (0..FOLDS).map(|fold| Self(logs.iter().map(|log| part(log, fold)).collect())).collect()
    }

    /// Its part of each log.
    #[must_use]
    pub fn parts(&self) -> &[Range<usize>] {
        &self.0
    }

    /// Its rows, in order.
    pub fn rows(&self) -> impl Iterator<Item = usize> {
        self.0.iter().cloned().flatten()
    }

    /// Whether a row is in it.
    #[must_use]
    pub fn has(&self, row: usize) -> bool {
        self.0.iter().any(|part| part.contains(&row))
    }
}

/// The fold that a row is in: the inverse of [`rows_of_fold`].
#[must_use]
// The quotient is below 8 for a row of the record.
#[allow(clippy::cast_possible_truncation)]
pub fn fold_of_row(row: u64, rows: u64) -> usize {
    let folds = FOLDS as u64;
    ((folds * (row + 1) - 1) / rows.max(1)).min(folds - 1) as usize
}

/// The standard error of an estimate, from the estimates that leave out one fold each (the jackknife).
#[must_use]
pub fn jackknife_error(without: &[f64]) -> f64 {
    let count = without.len() as f64;
    let mean = without.iter().sum::<f64>() / count;
    let squares: f64 = without.iter().map(|estimate| (estimate - mean).powi(2)).sum();
    ((count - 1.0) / count * squares).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_several_logs_a_fold_has_the_same_eighth_of_each() {
        let folds = Fold::of_logs(&[0..16, 16..24, 24..28]);
        assert_eq!(folds[0].parts(), [0..2, 16..17, 24..24]);
        assert_eq!(folds[7].parts(), [14..16, 23..24, 27..28]);
        let all: usize = folds.iter().map(|fold| fold.rows().count()).sum();
        assert_eq!(all, 28);
        assert!(folds[7].has(23) && !folds[7].has(22));
    }

    #[test]
    fn every_row_is_in_one_fold_and_both_ways_agree() {
        for rows in 1..100 {
            let folds: Vec<usize> = (0..rows).map(|row| fold_of_row(row as u64, rows as u64)).collect();
            for fold in 0..FOLDS {
                let own: Vec<usize> = (0..rows).filter(|row| folds[*row] == fold).collect();
                assert_eq!(own, rows_of_fold(fold, rows).collect::<Vec<_>>(), "{rows} {fold}");
            }
        }
    }
}
