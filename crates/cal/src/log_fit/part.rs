//! Where in one of several logs something is: logs of one unit are joined, and people look in a file.

use crate::condition::{Excluded, Step};
use crate::quality::Reason;
use zerorate_fit::still::Still;

/// One log's rows among those of all.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct LogPart {
    /// The log's name, where there are several.
    pub name: Option<String>,
    /// Rows before its own.
    pub first_row: u64,
    /// The time of its first row, seconds from the first log's.
    pub starts_s: f64,
}

impl LogPart {
    /// A sentence of it, with its name before it.
    pub(super) fn reason(&self, reason: Reason) -> Reason {
        match &self.name {
            Some(name) => Reason { text: format!("{name}: {}", reason.text), ..reason },
            None => reason,
        }
    }

    /// What begins a sentence of one of its axes: the axis's name, then its own.
    pub(super) fn axis(&self, axis: &str) -> String {
        self.name.as_ref().map_or_else(|| axis.to_owned(), |name| format!("{axis}: {name}"))
    }

    /// An interval by its own rows and times.
    pub(super) fn interval(&self, joined: &Excluded) -> Excluded {
        Excluded { rows: self.rows(joined.rows), time_s: self.times_s(joined.time_s), ..joined.clone() }
    }

    /// A step by its own rows and times.
    pub(super) fn step(&self, joined: &Step) -> Step {
        let row = joined.row - self.first_row;
        Step { row, rows: self.rows(joined.rows), time_s: self.times_s(joined.time_s), ..joined.clone() }
    }

    /// Rows in which an axis was stuck, by its own rows and times.
    pub(super) fn still(&self, joined: &Still) -> Still {
        let mut own = *joined;
        (own.rows, own.time_s) = (self.rows(joined.rows), self.times_s(joined.time_s));
        own
    }

    fn rows(&self, (from, to): (u64, u64)) -> (u64, u64) {
        (from - self.first_row, to - self.first_row)
    }

    fn times_s(&self, (from, to): (f64, f64)) -> (f64, f64) {
        (from - self.starts_s, to - self.starts_s)
    }
}
