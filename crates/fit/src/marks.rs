//! Marks that a log is known by wherever they stand in it: its rows, for a copy with every second row has those; words of its
//! noise, for rows in other numbers have those.
//!
//! They are given as hashes, of which those that end in zeros are kept. Marks of a coarse sensor repeat by chance in any log of
//! its kind; they do so within the log too, and such a log is known by none of them.

use std::collections::BTreeMap;

/// Marks that are kept of a log.
const MOST_KEPT: usize = 1024;

/// Marks of it that are written.
const MOST_WRITTEN: usize = 32;

/// The fewest marks in common that make a copy.
const LEAST_IN_COMMON: usize = 4;

/// And their share of the shorter log's, at least: of every second row of a part of a log it is a half or more.
const LEAST_SHARE: f64 = 0.1;

/// The largest share of marks that stand in a log more than once, of one whose marks tell it from others.
const MOST_REPEATED: f64 = 0.01;

/// Some marks of a log, by their hashes.
#[derive(Debug, Clone, PartialEq)]
pub struct Marks {
    /// What stands before a written one, so that nobody takes it for one of another kind.
    kind: &'static str,
    /// How often each was met.
    kept: BTreeMap<u64, u32>,
    /// Of the hashes with so many zeros at their end all are kept.
    zeros: u32,
    last: u64,
}

impl Marks {
    /// None yet, of a kind.
    #[must_use]
    pub fn new(kind: &'static str) -> Self {
        Self { kind, kept: BTreeMap::new(), zeros: 0, last: 0 }
    }

    /// Takes in the next mark; one that is like the mark before it is passed over, for a sensor may rest.
    pub fn push(&mut self, hash: u64) {
        if std::mem::replace(&mut self.last, hash) == hash || hash.trailing_zeros() < self.zeros {
            return;
        }
        *self.kept.entry(hash).or_default() += 1;
        self.thin(MOST_KEPT);
    }

    /// As a calibration keeps some of them; none where they do not tell the log from others.
    #[must_use]
    pub fn written(&self) -> Vec<String> {
        let mut few = self.clone();
        few.thin(MOST_WRITTEN);
        let marks = few.kept.into_keys().filter(|_| self.tells());
        marks.map(|mark| format!("{} {mark:016x}", self.kind)).collect()
    }

    /// Whether so many of these were written of another log that they are of one.
    #[must_use]
    pub fn are_of(&self, written: &[String]) -> bool {
        let of_kind = |written: &String| {
            let hash = written.strip_prefix(self.kind)?.strip_prefix(' ')?;
            u64::from_str_radix(hash, 16).ok()
        };
        let marks = written.iter().filter_map(of_kind);
        let (all, common) = marks.fold((0, 0), |(all, common), mark| (all + 1, common + self.has(mark)));
        self.are_enough(common, all)
    }

    /// Whether two logs have so many in common that one is of the other's rows.
    #[must_use]
    pub fn are_those_of(&self, other: &Self) -> bool {
        let zeros = self.zeros.max(other.zeros);
        let of_both = |marks: &Self| marks.kept.keys().filter(|mark| mark.trailing_zeros() >= zeros).count();
        let common = other.kept.keys().map(|mark| self.has(*mark)).sum();
        other.tells() && self.are_enough(common, of_both(self).min(of_both(other)))
    }

    fn has(&self, mark: u64) -> usize {
        usize::from(self.kept.contains_key(&mark))
    }

    fn are_enough(&self, common: usize, of: usize) -> bool {
        self.tells() && common >= LEAST_IN_COMMON && common as f64 >= LEAST_SHARE * of as f64
    }

    /// Whether the log's marks are hardly ever the same.
    fn tells(&self) -> bool {
        let all: u32 = self.kept.values().sum();
        f64::from(all) - self.kept.len() as f64 <= MOST_REPEATED * f64::from(all)
    }

    /// Keeps so many at most.
    fn thin(&mut self, most: usize) {
        while self.kept.len() > most {
            self.zeros += 1;
            self.kept.retain(|mark, _| mark.trailing_zeros() >= self.zeros);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mixed::mixed;

    fn marks(rows: impl Iterator<Item = u64>) -> Marks {
        let mut marks = Marks::new("row");
        rows.for_each(|row| marks.push(mixed(row)));
        marks
    }

    #[test]
    fn a_thinned_copy_of_a_log_or_of_a_part_of_it_is_known() {
        let whole = marks(1..60_001);
        let written = whole.written();
        assert!(written.len() <= MOST_WRITTEN && written.len() > MOST_WRITTEN / 4, "{}", written.len());
        for every in [2, 3] {
            let thinned = marks((1..60_001).step_by(every));
            assert!(thinned.are_of(&written) && thinned.are_those_of(&whole) && whole.are_those_of(&thinned));
        }
        let other = marks(100_000..160_000);
        assert!(!other.are_of(&written) && !other.are_those_of(&whole) && !whole.are_of(&[]));
    }

    #[test]
    fn a_coarse_sensors_rows_tell_nothing() {
        let coarse = |seed: u64| marks((0..60_000).map(move |row| mixed(row + seed) % 500));
        assert!(!coarse(0).are_those_of(&coarse(1 << 32)) && coarse(0).written().is_empty());
    }
}
