//! A counter of time of 32 bits, as `micros()` of a small processor: full after 71 minutes, it starts anew.

/// What it counts to.
const FULL: f64 = 4_294_967_296.0;

/// It falls by all of that less the time from one row to the next: a share of it, 67 s where it counts microseconds.
const LEAST_FALL: f64 = FULL * (1.0 - 1.0 / 64.0);

/// Times as they go on, over each place where their counter was full.
#[derive(Debug, Default)]
pub(super) struct Counter {
    /// The time before, as it is written.
    last: Option<f64>,
    /// What the times since have fallen short.
    added: f64,
}

impl Counter {
    /// The next time, as it goes on. One that is no number is none.
    pub(super) fn goes_on(&mut self, time: f64) -> f64 {
        if !time.is_finite() {
            return time;
        }
        if self.last.is_some_and(|last| last < FULL && (LEAST_FALL..=FULL).contains(&(last - time))) {
            self.added += FULL;
        }
        self.last = Some(time);
        time + self.added
    }

    /// Whether it was full once.
    pub(super) fn was_full(&self) -> bool {
        self.added > 0.0
    }
}
