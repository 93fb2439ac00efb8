//! What a board keeps through a restart of its processor, and what it learns from it when it starts.
//!
//! The potentiometer keeps its taps while the processor starts anew, and cannot be asked for them. So they are kept beside
//! it as they are commanded, in memory that start-up does not clear, with how often the program has failed: no wiper moves
//! because of a restart. All begins anew when power comes.

use core::ops::Deref;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use zerorate_core::units::{Axis, Taps};
use zerorate_core::wire::ResetCause;

use crate::trim_part::TrimPart;

/// What stands beside the facts when they are some: memory holds anything when power comes.
const MARK: u32 = 0x5A52_5355;
/// Faults of the program in a row after which its record is set aside: what happens three times happens with every group.
const SET_ASIDE: u32 = 3;

/// The facts, in words of which every bit pattern is one: so memory that nobody has written is one of these, too.
#[derive(Debug, Default)]
pub struct Kept {
    mark: AtomicU32,
    restarts: AtomicU32,
    /// Whether the restart under way is the program's own.
    panicked: AtomicU32,
    /// Faults of the program since it last was at work for a while.
    in_a_row: AtomicU32,
    /// The taps that were commanded last.
    taps: [AtomicU32; 2],
}

/// What is known of a start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Started {
    /// Why the program started.
    pub reset: ResetCause,
    /// Restarts by the watchdog and after faults of the program since power came.
    pub restarts: u32,
    /// Whether the program has failed so often in a row that it starts without its record.
    pub set_aside: bool,
    /// The taps that were commanded last.
    pub taps: [Taps; 2],
}

impl Kept {
    /// What is known of this start; to be asked once. The board can tell whether its watchdog has started it.
    #[must_use]
    pub fn started(&self, by_watchdog: bool) -> Started {
        self.check();
        let panicked = self.panicked.swap(0, Relaxed) != 0;
        let reset = match (by_watchdog, panicked) {
            (true, _) => ResetCause::Watchdog,
            (false, true) => ResetCause::Panic,
            // Or a reset that only the board could tell from it.
            (false, false) => ResetCause::Power,
        };
        if by_watchdog {
            self.count();
        }
        let tap = |kept: &AtomicU32| u16::try_from(kept.load(Relaxed)).ok().and_then(Taps::new).unwrap_or(Taps::MIDDLE);
        let set_aside = self.in_a_row.load(Relaxed) >= SET_ASIDE;
        Started { reset, restarts: self.restarts.load(Relaxed), set_aside, taps: self.taps.each_ref().map(tap) }
    }

    /// Counts a fault of the program, after which the processor is to be restarted.
    pub fn panicked(&self) {
        self.check();
        self.count();
        self.in_a_row.store(self.in_a_row.load(Relaxed).saturating_add(1), Relaxed);
        self.panicked.store(1, Relaxed);
    }

    /// The program does its work with its record, or has been given another one: what failed before is another matter.
    pub fn works(&self) {
        self.in_a_row.store(0, Relaxed);
    }

    fn keep(&self, axis: Axis, tap: Taps) {
        self.taps[axis.index()].store(tap.get().into(), Relaxed);
    }

    fn count(&self) {
        self.restarts.store(self.restarts.load(Relaxed).saturating_add(1), Relaxed);
    }

    /// Begins anew unless there are facts.
    fn check(&self) {
        if self.mark.load(Relaxed) != MARK {
            self.restarts.store(0, Relaxed);
            self.panicked.store(0, Relaxed);
            self.in_a_row.store(0, Relaxed);
            Axis::BOTH.into_iter().for_each(|axis| self.keep(axis, Taps::MIDDLE));
            self.mark.store(MARK, Relaxed);
        }
    }
}

/// A trim part whose taps are kept.
pub struct Keeping<P, K> {
    part: P,
    kept: K,
}

impl<P, K> Keeping<P, K> {
    /// A part, and where its taps are kept.
    pub const fn new(part: P, kept: K) -> Self {
        Self { part, kept }
    }
}

impl<P: TrimPart, K: Deref<Target = Kept>> TrimPart for Keeping<P, K> {
    type Error = P::Error;

    fn write(&mut self, axis: Axis, tap: Taps) -> Result<(), Self::Error> {
        self.part.write(axis, tap)?;
        self.kept.keep(axis, tap);
        Ok(())
    }

    fn store_power_up(&mut self) -> Result<(), Self::Error> {
        self.part.store_power_up()
    }

    fn recall_power_up(&mut self) -> Result<(), Self::Error> {
        self.part.recall_power_up()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::Part;

    #[test]
    fn power_finds_the_middle_taps_whatever_is_in_the_memory() {
        for mark in [0, 1, u32::MAX] {
            let (mark, restarts, taps) = (mark.into(), 77.into(), [9.into(), 8.into()]);
            let kept = Kept { mark, restarts, panicked: 1.into(), in_a_row: 9.into(), taps };
            let started = Started { reset: ResetCause::Power, restarts: 0, set_aside: false, taps: [Taps::MIDDLE; 2] };
            assert_eq!(kept.started(false), started);
        }
    }

    #[test]
    fn a_restart_is_counted_told_apart_and_finds_the_taps_that_were_written() {
        let (kept, part) = (Kept::default(), Part::default());
        let _ = kept.started(false);
        let mut keeping = Keeping::new(part.clone(), &kept);
        keeping.write(Axis::Y, Taps::LAST).unwrap();
        part.unplugged.set(true);
        assert!(keeping.write(Axis::X, Taps::FIRST).is_err());
        let taps = [Taps::MIDDLE, Taps::LAST];
        kept.panicked();
        assert_eq!(kept.started(false), Started { reset: ResetCause::Panic, restarts: 1, set_aside: false, taps });
        assert_eq!(kept.started(true), Started { reset: ResetCause::Watchdog, restarts: 2, set_aside: false, taps });
        assert_eq!(kept.started(false).reset, ResetCause::Power, "a panic is told once");
    }
}
