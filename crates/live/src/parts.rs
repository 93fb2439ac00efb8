//! The parts of the page, each with the count of changes at which it last changed.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What all threads share. Nobody writes to a socket while it is locked.
#[derive(Default)]
pub struct Parts {
    state: Mutex<State>,
    /// Told of every change.
    changed: Condvar,
    /// Told when somebody comes to look on.
    wanted: Condvar,
}

#[derive(Default)]
struct State {
    parts: Vec<Part>,
    changes: u64,
    readers: usize,
    /// Nothing changes any more.
    is_over: bool,
    /// Nobody is served any more.
    is_closed: bool,
}

struct Part {
    id: &'static str,
    changed_at: u64,
    html: Arc<str>,
}

impl State {
    fn put(&mut self, parts: Vec<(&'static str, String)>) {
        for (id, html) in parts {
            let changes = self.changes + 1;
            match self.parts.iter_mut().find(|part| part.id == id) {
                Some(part) if *part.html == *html => continue,
                Some(part) => (part.changed_at, part.html) = (changes, html.into()),
                None => self.parts.push(Part { id, changed_at: changes, html: html.into() }),
            }
            self.changes = changes;
        }
    }
}

/// What has changed since a reader last looked.
pub struct News {
    /// The parts, in their order.
    pub parts: Vec<(&'static str, Arc<str>)>,
    /// Up to which change.
    pub changes: u64,
    /// Nothing comes after it.
    pub is_over: bool,
    /// Nobody is served any more.
    pub is_closed: bool,
}

impl Parts {
    fn lock(&self) -> MutexGuard<'_, State> {
        // A thread that has panicked has left whole parts.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes parts as they are now; after the last ones none.
    pub fn put(&self, parts: Vec<(&'static str, String)>) {
        let mut state = self.lock();
        if !state.is_over {
            state.put(parts);
            self.changed.notify_all();
        }
    }

    /// Takes the last parts.
    pub fn put_last(&self, parts: Vec<(&'static str, String)>) {
        let mut state = self.lock();
        state.put(parts);
        state.is_over = true;
        self.changed.notify_all();
        self.wanted.notify_all();
    }

    /// What has changed since; waits for it, but not longer than so.
    pub fn since(&self, changes: u64, patience: Duration) -> News {
        let until = Instant::now() + patience;
        let mut state = self.lock();
        loop {
            let left = until.saturating_duration_since(Instant::now());
            if state.changes > changes || state.is_over || state.is_closed || left.is_zero() {
                let new = state.parts.iter().filter(|part| part.changed_at > changes);
                return News {
                    parts: new.map(|part| (part.id, Arc::clone(&part.html))).collect(),
                    changes: state.changes,
                    is_over: state.is_over,
                    is_closed: state.is_closed,
                };
            }
            state = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Waits until somebody looks on; `false` if nothing is to be made any more.
    pub fn are_wanted(&self) -> bool {
        let mut state = self.lock();
        while state.readers == 0 && !state.is_over && !state.is_closed {
            state = self.wanted.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        !state.is_over && !state.is_closed
    }

    /// Waits a while, or until nothing is to be made any more.
    pub fn rest(&self, time: Duration) {
        let until = Instant::now() + time;
        let mut state = self.lock();
        while !state.is_over && !state.is_closed {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return;
            }
            state = self.wanted.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// A reader comes, unless so many are there.
    pub fn enter(&self, most: usize) -> bool {
        let mut state = self.lock();
        if state.readers >= most {
            return false;
        }
        state.readers += 1;
        self.wanted.notify_all();
        true
    }

    /// A reader goes.
    pub fn leave(&self) {
        self.lock().readers -= 1;
        self.changed.notify_all();
    }

    /// Waits until all readers are gone, but not longer than so.
    pub fn until_alone(&self, patience: Duration) {
        let until = Instant::now() + patience;
        let mut state = self.lock();
        while state.readers > 0 {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return;
            }
            state = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Nobody is served any more.
    pub fn close(&self) {
        self.lock().is_closed = true;
        self.changed.notify_all();
        self.wanted.notify_all();
    }

    /// Whether it is so.
    pub fn is_closed(&self) -> bool {
        self.lock().is_closed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_TIME: Duration = Duration::ZERO;

    #[test]
    fn a_reader_gets_what_has_changed_since_and_only_the_newest() {
        let parts = Parts::default();
        parts.put(vec![("now", "1".into()), ("plan", "a".into())]);
        let first = parts.since(0, NO_TIME);
        assert_eq!(
            first.parts.iter().map(|(id, html)| (*id, &**html)).collect::<Vec<_>>(),
            [("now", "1"), ("plan", "a")]
        );
        parts.put(vec![("now", "2".into()), ("plan", "a".into())]);
        parts.put(vec![("now", "3".into())]);
        let second = parts.since(first.changes, NO_TIME);
        assert_eq!(second.parts.iter().map(|(id, html)| (*id, &**html)).collect::<Vec<_>>(), [("now", "3")]);
        assert!(parts.since(second.changes, NO_TIME).parts.is_empty());
    }

    #[test]
    fn after_the_end_nobody_waits() {
        let parts = Parts::default();
        parts.put_last(vec![("now", "the end".into())]);
        // Made before the end, and late.
        parts.put(vec![("now", "before".into())]);
        assert!(!parts.are_wanted());
        let news = parts.since(0, Duration::MAX / 4);
        assert!(news.is_over && *news.parts[0].1 == *"the end");
    }
}
