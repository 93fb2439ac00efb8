//! How long an instrument has not answered, and what is said of it. Pure: times in, sentences out.

use std::time::{Duration, Instant};

/// An instrument that restarts is back within this; what lasts longer is told.
pub const TELL_AFTER: Duration = Duration::from_secs(180);
/// How long an instrument that did not answer is let alone before it is asked again: groups come meanwhile.
const ASK_AGAIN: Duration = Duration::from_secs(5);

/// The patience with one instrument.
#[derive(Debug, Clone)]
pub struct Patience {
    what: &'static str,
    silent_since: Option<Instant>,
    asked: Option<Instant>,
    was_told: bool,
}

impl Patience {
    /// The patience with an instrument that sentences call `what`.
    #[must_use]
    pub const fn with(what: &'static str) -> Self {
        Self { what, silent_since: None, asked: None, was_told: false }
    }

    /// Whether it is to be asked now: one that does not answer takes a second or two, and groups wait behind it.
    #[must_use]
    pub fn may_ask(&self, now: Instant) -> bool {
        self.silent_since.is_none() || self.asked.is_none_or(|asked| now.duration_since(asked) >= ASK_AGAIN)
    }

    /// Whether it has not answered since it was last asked.
    #[must_use]
    pub const fn is_silent(&self) -> bool {
        self.silent_since.is_some()
    }

    /// It did not answer for a reason; returns what is to be said.
    pub fn silent(&mut self, now: Instant, why: &str) -> Option<String> {
        let since = *self.silent_since.get_or_insert(now);
        self.asked = Some(now);
        if self.was_told || now.duration_since(since) < TELL_AFTER {
            return None;
        }
        self.was_told = true;
        Some(format!(
            "the {} has not answered for {} minutes: what needs it waits until it is back, and what the board says is recorded meanwhile. {why}. Ctrl-C ends the run",
            self.what,
            TELL_AFTER.as_secs() / 60
        ))
    }

    /// It has answered; returns what is to be said, and whether it had been silent.
    pub fn heard(&mut self, now: Instant) -> (bool, Option<String>) {
        let since = self.silent_since.take();
        let told = std::mem::take(&mut self.was_told);
        let sentence = since.filter(|_| told).map(|since| {
            let minutes = now.duration_since(since).as_secs_f64() / 60.0;
            format!("the {} answers again, after {minutes:.0} minutes: the run goes on", self.what)
        });
        (since.is_some(), sentence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_minutes_without_an_answer_are_told_once_and_the_return_too() {
        let mut patience = Patience::with("chamber");
        let start = Instant::now();
        let at = |seconds: u64| start + Duration::from_secs(seconds);
        assert!(patience.may_ask(at(0)));
        assert_eq!(patience.silent(at(0), "no answer"), None);
        assert!(!patience.may_ask(at(4)) && patience.may_ask(at(5)));
        assert_eq!(patience.silent(at(179), "no answer"), None);
        let told = patience.silent(at(180), "no answer").unwrap();
        assert!(told.contains("chamber has not answered for 3 minutes: what needs it waits"), "{told}");
        assert_eq!(patience.silent(at(300), "no answer"), None);
        let (was_silent, told) = patience.heard(at(600));
        assert!(was_silent && told.unwrap().contains("answers again, after 10 minutes"));
        assert_eq!(patience.heard(at(601)), (false, None));
    }

    #[test]
    fn a_short_silence_is_not_told() {
        let mut patience = Patience::with("chamber");
        let start = Instant::now();
        patience.silent(start, "no answer");
        assert_eq!(patience.heard(start + Duration::from_secs(60)), (true, None));
    }
}
