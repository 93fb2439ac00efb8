//! What a fit's averages are over, and when a device takes its zero, in words: a log without times has rows alone.

use zerorate_fit::boot::BOOT_S;

use super::LogFit;
use zerorate_fit::trace::period_s;

impl LogFit {
    /// The time from one average to the next, seconds, as a rule; `None` of a log without times.
    fn averaged_over_s(&self) -> Option<f64> {
        self.axes.first().and_then(|axis| period_s(&axis.trace))
    }

    /// What an average is over: `about 10 s`, or `about 21 rows`.
    #[must_use]
    pub fn averaged_over(&self) -> String {
        let rows = || {
            let counts = self.axes.first().map(|axis| &axis.calibration.fit.statistics);
            counts.map_or(f64::NAN, |counts| counts.samples_used as f64 / counts.residuals as f64)
        };
        match self.averaged_over_s() {
            Some(long) if long >= 5.0 => format!("about {long:.0} s"),
            Some(short) => format!("about {short:.1} s"),
            None => format!("about {:.0} rows", rows()),
        }
    }

    /// When a device takes its zero, of what its run begins with.
    #[must_use]
    pub fn zero_taken_in(&self) -> &'static str {
        zero_taken_in(self.averaged_over_s())
    }
}

/// The same of averages that are so many seconds apart; `None` without times.
#[must_use]
pub fn zero_taken_in(averaged_over_s: Option<f64>) -> &'static str {
    if averaged_over_s.is_some_and(|period| period < BOOT_S) { "first half minute" } else { "first average" }
}
