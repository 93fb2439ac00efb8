//! What one sensor's rows in a log are known by: runs of them, some of them one by one, and their noise, in words and in signs.
//!
//! Each log is known by some of its runs of 64 successive rows, those whose hash ends in zeros: which ones does not depend
//! on where the log begins, so that what overlaps gives the same runs in both (fingerprints by a rolling hash: Schleimer,
//! Wilkerson and Aiken, "Winnowing", 2003). Times are no part of a row: they are told from each log's own start.

use std::collections::BTreeMap;

use crate::marks::Marks;
use crate::mixed::mixed;
use crate::noise_signs::NoiseSigns;
use crate::noise_words::NoiseWords;

/// Rows in a run: more than noise repeats, in the coarsest of sensors.
const RUN: usize = 64;

/// A run has at least so many rows that are unlike the row before: a sensor that is stuck, or rests below its own
/// resolution, is like any other that does.
const LEAST_CHANGES: usize = RUN / 4;

/// Runs that are kept of a sensor's log.
const MOST_KEPT: usize = 4096;

/// Runs of a sensor's log that are written: a log that is half another's has two of them but for one time in four
/// thousand.
const MOST_WRITTEN: usize = 16;

/// Runs in common from which on two logs overlap.
const LEAST_IN_COMMON: usize = 2;

/// The part of a log from which on it is said to stand in itself twice: of coarse numbers a few runs are alike by chance.
const LEAST_TWICE: f64 = 0.01;

/// An odd number of well mixed bits, the base of the rolling hash (the golden ratio's).
const BASE: u64 = 0x9e37_79b9_7f4a_7c15;

/// What one sensor's rows in one log are known by.
#[derive(Debug, Clone, PartialEq)]
pub struct Fingerprint {
    /// The hashes of the last rows and whether each was unlike the one before, by the row's number modulo [`RUN`].
    last: [(u64, bool); RUN],
    rows: usize,
    changes: usize,
    rolling: u64,
    /// `BASE` to the power of [`RUN`].
    base_of_run: u64,
    /// Of the hashes with so many zeros at their end all are kept.
    zeros: u32,
    /// How often each was met.
    kept: BTreeMap<u64, u32>,
    /// Rows one by one.
    marks: Marks,
    words: NoiseWords,
    signs: NoiseSigns,
}

impl Default for Fingerprint {
    fn default() -> Self {
        let base_of_run = (0..RUN).fold(1_u64, |power, _| power.wrapping_mul(BASE));
        let last = [(0, false); RUN];
        let (kept, marks) = (BTreeMap::new(), Marks::new("row"));
        let (words, signs) = (NoiseWords::default(), NoiseSigns::default());
        Self { last, rows: 0, changes: 0, rolling: 0, base_of_run, zeros: 0, kept, marks, words, signs }
    }
}

impl Fingerprint {
    /// Takes in successive rows: their temperatures, and a column of values an axis. A row without any value is none: of a
    /// temperature alone many are alike.
    pub fn push_rows<A: AsRef<[f64]>>(&mut self, temperatures: &[f64], values: &[A]) {
        self.words.push_rows(values);
        self.signs.push_rows(values);
        for (row, temperature) in temperatures.iter().enumerate() {
            if values.iter().all(|axis| axis.as_ref()[row].is_nan()) {
                continue;
            }
            let values = values.iter().map(|axis| axis.as_ref()[row]);
            let row = std::iter::once(*temperature).chain(values).fold(0, |hash, value| mixed(hash ^ value.to_bits()));
            self.marks.push(row);
            self.push(row);
        }
    }

    fn push(&mut self, row: u64) {
        let place = self.rows % RUN;
        let before = self.last[(self.rows + RUN - 1) % RUN].0;
        let (gone, gone_changed) = std::mem::replace(&mut self.last[place], (row, row != before));
        self.changes = self.changes + usize::from(row != before) - usize::from(gone_changed);
        self.rolling =
            self.rolling.wrapping_mul(BASE).wrapping_add(row).wrapping_sub(gone.wrapping_mul(self.base_of_run));
        self.rows += 1;
        let run = mixed(self.rolling);
        if self.rows < RUN || self.changes < LEAST_CHANGES || run.trailing_zeros() < self.zeros {
            return;
        }
        *self.kept.entry(run).or_default() += 1;
        self.thin(MOST_KEPT);
    }

    /// Keeps so many runs at most.
    fn thin(&mut self, most: usize) {
        while self.kept.len() > most {
            self.zeros += 1;
            self.kept.retain(|run, _| run.trailing_zeros() >= self.zeros);
        }
    }

    /// What is written of it: a few runs of 16 hexadecimal digits, a few of its rows and of its noise's words, and signs.
    pub fn written(&self) -> impl Iterator<Item = String> + use<> {
        let mut few = self.clone();
        few.thin(MOST_WRITTEN);
        let runs = few.kept.into_keys().map(|run| format!("{run:016x}"));
        runs.chain(self.marks.written()).chain(self.words.written()).chain(self.signs.written())
    }

    /// Whether some of these rows are among those of which this was written, or these are a copy of them.
    #[must_use]
    pub fn is_among(&self, written: &[String]) -> bool {
        let runs = written.iter().filter_map(|run| u64::from_str_radix(run, 16).ok());
        let common = runs.filter(|run| self.kept.contains_key(run)).count();
        let has_its_signs = || written.iter().any(|written| self.signs.is_of(written));
        common >= LEAST_IN_COMMON || self.marks.are_of(written) || self.words.are_of(written) || has_its_signs()
    }

    /// Whether these rows are a copy of another log's, in other numbers or some of them.
    #[must_use]
    pub fn is_copied_from(&self, other: &Self) -> bool {
        self.marks.are_those_of(&other.marks)
            || self.words.are_those_of(&other.words)
            || self.signs.are_of(&other.signs)
    }

    /// The part of these rows that another log has too; `None` where the two have nothing in common.
    #[must_use]
    pub fn part_in(&self, other: &Self) -> Option<f64> {
        let zeros = self.zeros.max(other.zeros);
        let of_both = |run: &&u64| run.trailing_zeros() >= zeros;
        let (own, common) = self
            .kept
            .keys()
            .filter(of_both)
            .fold((0, 0), |(own, common), run| (own + 1, common + usize::from(other.kept.contains_key(run))));
        (common >= LEAST_IN_COMMON).then(|| common as f64 / f64::from(own))
    }

    /// The part of these rows that stand in the log before, too; `None` where all are there once.
    #[must_use]
    pub fn part_twice(&self) -> Option<f64> {
        let all: u32 = self.kept.values().sum();
        let again = all as usize - self.kept.len();
        let part = again as f64 / f64::from(all);
        (again >= LEAST_IN_COMMON && part >= LEAST_TWICE).then_some(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of a gyro with noise of a few of its steps.
    fn rows(range: std::ops::Range<u64>) -> Fingerprint {
        let mut log = Fingerprint::default();
        for row in range {
            let value = |axis: u64| (mixed(mixed(row) ^ axis) % 7) as f64;
            let values = [vec![value(1)], vec![value(2)], vec![value(3)]];
            log.push_rows(&[20.0], &values);
        }
        log
    }

    #[test]
    fn what_two_logs_have_in_common_is_found_wherever_each_begins() {
        let (first, second) = (rows(0..60_000), rows(45_017..105_017));
        let part = second.part_in(&first).unwrap();
        assert!((part - 14_983.0 / 60_000.0).abs() < 0.03, "{part}");
        assert_eq!(rows(60_000..120_000).part_in(&first), None);
        // A short one in a long one.
        assert!(rows(1000..1400).part_in(&rows(0..60_000)).is_some_and(|part| part > 0.9));
    }

    #[test]
    fn the_few_runs_that_are_written_tell_a_log_from_others() {
        let written =
            [rows(0..60_000), rows(900_000..960_000)].iter().flat_map(Fingerprint::written).collect::<Vec<_>>();
        let runs = written.iter().filter(|written| !written.contains(' ')).count();
        assert!(runs <= 2 * MOST_WRITTEN && runs > MOST_WRITTEN / 2, "{runs}");
        let of = rows;
        assert!(of(0..60_000).is_among(&written) && of(20_000..60_000).is_among(&written));
        assert!(!of(100_000..160_000).is_among(&written) && !of(0..60_000).is_among(&[]));
    }

    #[test]
    fn rows_that_stand_in_a_log_twice_are_told() {
        let mut twice = Fingerprint::default();
        (0..60_000).chain(20_000..50_000).for_each(|row| twice.push(mixed(row)));
        let part = twice.part_twice().unwrap();
        assert!((part - 30_000.0 / 90_000.0).abs() < 0.03, "{part}");
        assert_eq!(rows(0..60_000).part_twice(), None);
    }

    #[test]
    fn a_sensor_that_is_stuck_is_in_no_other_log() {
        let mut stuck = Fingerprint::default();
        (0..1000).for_each(|row| stuck.push(row / 10));
        assert_eq!(stuck.part_in(&stuck), None);
    }
}
