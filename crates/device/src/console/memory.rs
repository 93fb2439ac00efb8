//! What became of the last commands, so that one which is sent again is answered and not done again.

use heapless::Vec;
use zerorate_core::wire::Refusal;

use crate::compensator::Outcome;

/// Commands that are remembered: twice what a host may send before it waits for an answer.
const REMEMBERED: usize = 16;

/// A command that was accepted.
#[derive(Debug, Clone, Copy)]
struct Entry {
    sequence: u16,
    /// Tells it from another command with the same number.
    crc: u32,
    /// `None` while it waits.
    outcome: Option<Outcome>,
}

/// The last commands, oldest first.
#[derive(Debug, Default)]
pub(super) struct Memory {
    entries: Vec<Entry, REMEMBERED>,
}

impl Memory {
    pub(super) const fn new() -> Self {
        Self { entries: Vec::new() }
    }

    /// A new conversation begins.
    pub(super) fn forget(&mut self) {
        self.entries.clear();
    }

    /// What became of a command that came before; `Some(None)` while it waits, `None` if it is new.
    pub(super) fn find(&self, sequence: u16, crc: u32) -> Option<Option<Outcome>> {
        let is_it = |entry: &&Entry| entry.sequence == sequence && entry.crc == crc;
        self.entries.iter().rev().find(is_it).map(|entry| entry.outcome)
    }

    /// Remembers that a command waits; `false` when nothing can be forgotten for it.
    pub(super) fn wait(&mut self, sequence: u16, crc: u32) -> bool {
        self.make_room() && self.entries.push(Entry { sequence, crc, outcome: None }).is_ok()
    }

    /// Remembers what came of a command that did not wait.
    pub(super) fn done(&mut self, sequence: u16, crc: u32, outcome: Outcome) {
        if self.make_room() {
            let _ = self.entries.push(Entry { sequence, crc, outcome: Some(outcome) });
        }
    }

    /// Remembers what came of a command that waited. One that found no room was not done, and may be sent again.
    pub(super) fn settle(&mut self, sequence: u16, outcome: Outcome) {
        if outcome.1 == Err(Refusal::Busy) {
            self.entries.retain(|entry| entry.sequence != sequence || entry.outcome.is_some());
        } else if let Some(entry) = self.entries.iter_mut().find(|e| e.sequence == sequence && e.outcome.is_none()) {
            entry.outcome = Some(outcome);
        }
    }

    /// Forgets the oldest command that does not wait any more, if there is no room.
    fn make_room(&mut self) -> bool {
        if !self.entries.is_full() {
            return true;
        }
        let oldest = self.entries.iter().position(|entry| entry.outcome.is_some());
        oldest.map(|index| self.entries.remove(index)).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zerorate_core::units::GroupNumber;

    const DONE: Outcome = (GroupNumber(4), Ok(()));

    #[test]
    fn the_last_commands_are_known_by_number_and_content() {
        let mut memory = Memory::new();
        for k in 0..40_u16 {
            assert_eq!(memory.find(k, 7), None);
            memory.done(k, 7, DONE);
        }
        assert_eq!(memory.find(23, 7), None);
        assert!((24..40).all(|k| memory.find(k, 7) == Some(Some(DONE)) && memory.find(k, 8).is_none()));
        memory.forget();
        assert_eq!(memory.find(39, 7), None);
    }

    #[test]
    fn what_waits_is_never_forgotten_for_something_newer() {
        let mut memory = Memory::new();
        assert!((0..16).all(|k| memory.wait(k, 0)));
        assert!(!memory.wait(16, 0));
        memory.done(17, 0, DONE);
        assert_eq!(memory.find(17, 0), None);
        memory.settle(3, DONE);
        memory.settle(4, (GroupNumber(1), Err(Refusal::Busy)));
        assert_eq!((memory.find(3, 0), memory.find(4, 0), memory.find(5, 0)), (Some(Some(DONE)), None, Some(None)));
        assert!(memory.wait(16, 0) && memory.wait(18, 0));
        assert_eq!(memory.find(3, 0), None);
        assert!(!memory.wait(19, 0));
    }
}
