//! What a fit's averages are over, and when a device takes its zero, in words: a log without times has rows alone.

use zerorate_fit::boot::BOOT_S;
use zerorate_fit::drift_fit::ResidualOver;
use zerorate_fit::trace::period_s;

use super::LogFit;
use crate::condition::GROUP_S;

/// Averages of so many times the length of others are other averages.
const ALIKE: f64 = 1.25;

impl LogFit {
    /// The time from one average to the next, seconds, as a rule: the least and the greatest of the logs; `None` without times.
    fn averages_s(&self) -> Option<(f64, f64)> {
        let trace = &self.axes.first()?.trace;
        let of_logs = trace.chunk_by(|a, b| a.log == b.log).filter_map(period_s);
        of_logs.fold(None, |found, own| {
            let (least, most) = found.unwrap_or((own, own));
            Some((own.min(least), own.max(most)))
        })
    }

    /// Whether nothing was averaged: a plain fit.
    fn is_of_rows(&self) -> bool {
        self.axes.first().is_some_and(|axis| axis.calibration.fit.statistics.residual_over == ResidualOver::Rows)
    }

    /// The time from one average to the next, seconds, as a rule, of several logs the longest; `None` of logs without times and
    /// of a plain fit.
    #[must_use]
    pub fn averaged_over_s(&self) -> Option<f64> {
        self.averages_s().filter(|_| !self.is_of_rows()).map(|(_, most)| most)
    }

    /// What an average is over: `about 10 s`, or `about 21 rows`; of logs whose rows come differently fast `about 10 to 42 s`.
    #[must_use]
    pub fn averaged_over(&self) -> String {
        if self.is_of_rows() {
            return "single rows".to_owned();
        }
        // Of a log that was not fitted nothing is known of them.
        let rows = self.axes.first().map(|axis| &axis.calibration.fit.statistics).map_or_else(
            || "some rows".to_owned(),
            |counts| format!("about {:.0} rows", counts.samples_used as f64 / counts.residuals as f64),
        );
        let written = |seconds: f64| if seconds >= 5.0 { format!("{seconds:.0}") } else { format!("{seconds:.1}") };
        match self.averages_s() {
            Some((least, most)) if most > ALIKE * least => format!("about {} to {} s", written(least), written(most)),
            Some((_, most)) => format!("about {} s", written(most)),
            None => rows,
        }
    }

    /// What is to be known of a verification's averages, which are of another length where rows come seldom or the log is short.
    #[must_use]
    pub fn verified_over(&self) -> String {
        let own = self.averaged_over_s().filter(|own| !are_alike(*own, GROUP_S));
        own.map_or_else(String::new, |_| format!(", in averages over {GROUP_S:.0} s, which have another noise"))
    }

    /// When a device takes its zero, of what its run begins with.
    #[must_use]
    pub fn zero_taken_in(&self) -> &'static str {
        zero_taken_in(self.averages_s().map(|(_, most)| most))
    }
}

/// The same of averages that are so many seconds apart; `None` without times.
#[must_use]
pub fn zero_taken_in(averaged_over_s: Option<f64>) -> &'static str {
    if averaged_over_s.is_some_and(|period| period < BOOT_S) { "first half minute" } else { "first average" }
}

/// Whether averages over these two times can be held against each other.
#[must_use]
pub fn are_alike(one_s: f64, other_s: f64) -> bool {
    one_s.max(other_s) <= ALIKE * one_s.min(other_s)
}
