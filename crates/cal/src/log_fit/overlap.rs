//! Rows that two logs have in common: a log cut into files that overlap, one log saved in two forms.

use zerorate_fit::fingerprint::Fingerprint;

/// What the rows of one log are known by, a sensor each.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LogRows(pub(super) Vec<Fingerprint>);

impl LogRows {
    /// What a calibration keeps of it.
    #[must_use]
    pub fn written(&self) -> Vec<String> {
        self.0.iter().flat_map(Fingerprint::written).collect()
    }

    /// Whether some of these rows are among those that a calibration was fitted on, or these are a copy of them.
    #[must_use]
    pub fn are_among(&self, written: &[String]) -> bool {
        self.0.iter().any(|own| own.is_among(written))
    }

    /// The part of these rows that another log has too; `None` where the two have nothing in common.
    pub(super) fn part_in(&self, other: &Self) -> Option<f64> {
        let parts = self.0.iter().flat_map(|own| other.0.iter().filter_map(|other| own.part_in(other)));
        parts.max_by(f64::total_cmp)
    }

    /// Whether these rows are a copy of another log's, in other numbers or some of them.
    pub(super) fn are_copied_from(&self, other: &Self) -> bool {
        self.0.iter().any(|own| other.0.iter().any(|other| own.is_copied_from(other)))
    }

    /// The part of these rows that stand in the log before, too; `None` where all are there once.
    pub(super) fn part_twice(&self) -> Option<f64> {
        self.0.iter().filter_map(Fingerprint::part_twice).max_by(f64::total_cmp)
    }
}
