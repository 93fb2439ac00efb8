//! What a board keeps through a restart of its processor, and what it learns from it when it starts.
//!
//! The potentiometer keeps its taps while the processor starts anew, and cannot be asked for them. So they are kept beside
//! it as they are commanded, in memory that start-up does not clear, with how often the program has failed and where it did
//! last: no wiper moves because of a restart. All begins anew when power comes, also when it was gone for so short a time that
//! the memory still holds what it held: the potentiometer may have lost its taps.

use core::ops::Deref;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use heapless::String;
use zerorate_core::units::{Axis, Taps};
use zerorate_core::wire::{FILE_BYTES, FaultRegisters, ResetCause, Stop};

use crate::trim_part::TrimPart;

/// What stands beside the facts when they are some: memory holds anything when power comes. Another form of the facts has
/// another mark.
const MARK: u32 = 0x5A52_5357;
/// Faults of the program in a row after which its record is set aside: what happens three times happens with every group.
const SET_ASIDE: u32 = 3;

/// What a board's own registers tell of its reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reset {
    /// Power came.
    Power,
    /// The supply fell below the level at which the processor is held in reset.
    BrownOut,
    /// The watchdog was not fed.
    Watchdog,
    /// The program asked for it, or a debugger.
    Software,
    /// The reset pin.
    Pin,
    /// The board has no such registers: facts in its memory tell that its power did not go.
    Untold,
}

/// The facts, in words of which every bit pattern is one: so memory that nobody has written is one of these, too.
#[derive(Debug, Default)]
pub struct Kept {
    mark: AtomicU32,
    restarts: AtomicU32,
    /// Whether the restart under way is the program's own.
    stopped: AtomicU32,
    /// Whether it is at what its record decides.
    at_record: AtomicU32,
    /// Faults of the program since it last was at work for a while.
    in_a_row: AtomicU32,
    /// Dips of the supply.
    dips: AtomicU32,
    /// The taps that were commanded last.
    taps: [AtomicU32; 2],
    /// Where the program stopped itself last.
    place: Place,
}

/// What is known of a start.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Started {
    /// Why the program started.
    pub reset: ResetCause,
    /// Restarts by the watchdog and after faults of the program since power came.
    pub restarts: u32,
    /// Whether the program has failed so often in a row that it starts without its record.
    pub set_aside: bool,
    /// The taps that were commanded last.
    pub taps: [Taps; 2],
    /// Where the program stopped itself last since power came.
    pub stop: Option<Stop>,
}

impl Started {
    /// Power came: nothing is known.
    pub const POWER: Self =
        Self { reset: ResetCause::Power, restarts: 0, set_aside: false, taps: [Taps::MIDDLE; 2], stop: None };
}

impl Kept {
    /// What is known of this start; to be asked once, before anything that can fail.
    #[must_use]
    pub fn started(&self, reset: Reset) -> Started {
        let has_facts = self.has_facts();
        if !has_facts || matches!(reset, Reset::Power | Reset::BrownOut) {
            self.begin_anew();
        }
        let stop = self.place.stop();
        let own = self.stopped.swap(0, Relaxed) != 0;
        let reset = match (reset, &stop) {
            (Reset::Power, _) => ResetCause::Power,
            (Reset::BrownOut, _) => ResetCause::BrownOut,
            (Reset::Watchdog, _) => ResetCause::Watchdog,
            (Reset::Pin, _) => ResetCause::Pin,
            (Reset::Software | Reset::Untold, Some(Stop::Panic { .. })) if own => ResetCause::Panic,
            (Reset::Software | Reset::Untold, Some(Stop::Fault(_))) if own => ResetCause::Fault,
            (Reset::Untold, _) if !has_facts => ResetCause::Power,
            (Reset::Software | Reset::Untold, _) => ResetCause::Software,
        };
        let hung = self.at_record.swap(0, Relaxed) != 0;
        if reset == ResetCause::Watchdog {
            self.count();
            if hung {
                self.failed();
            }
        }
        let tap = |kept: &AtomicU32| u16::try_from(kept.load(Relaxed)).ok().and_then(Taps::new).unwrap_or(Taps::MIDDLE);
        let set_aside = self.in_a_row.load(Relaxed) >= SET_ASIDE;
        Started { reset, restarts: self.restarts.load(Relaxed), set_aside, taps: self.taps.each_ref().map(tap), stop }
    }

    /// Keeps where the program has stopped itself, and counts it; the processor is to be restarted.
    pub fn stopped(&self, stop: &Stop) {
        if !self.has_facts() {
            self.begin_anew();
        }
        self.count();
        self.failed();
        self.place.keep(stop);
        self.stopped.store(1, Relaxed);
    }

    /// Does what the record decides. A watchdog that bites meanwhile finds a program that its record has hung; at any other time
    /// it may be the acquisition that is dead, which no record is to blame for. An interrupt may come in between and do such
    /// work of its own: what it has interrupted is at it again when it returns.
    pub fn at_record<R>(&self, work: impl FnOnce() -> R) -> R {
        let interrupted = self.at_record.load(Relaxed);
        self.at_record.store(1, Relaxed);
        let done = work();
        self.at_record.store(interrupted, Relaxed);
        done
    }

    /// The program does its work with its record, or has been given another one: what failed before is another matter.
    pub fn works(&self) {
        self.in_a_row.store(0, Relaxed);
    }

    /// The processor's supply has dipped, and the program goes on.
    pub fn dipped(&self) {
        self.dips.store(self.dips().saturating_add(1), Relaxed);
    }

    /// Dips of the processor's supply since power came.
    pub fn dips(&self) -> u32 {
        self.dips.load(Relaxed)
    }

    fn keep(&self, axis: Axis, tap: Taps) {
        self.taps[axis.index()].store(tap.get().into(), Relaxed);
    }

    fn failed(&self) {
        self.in_a_row.store(self.in_a_row.load(Relaxed).saturating_add(1), Relaxed);
    }

    fn count(&self) {
        self.restarts.store(self.restarts.load(Relaxed).saturating_add(1), Relaxed);
    }

    fn has_facts(&self) -> bool {
        self.mark.load(Relaxed) == MARK
    }

    fn begin_anew(&self) {
        for word in [&self.restarts, &self.stopped, &self.at_record, &self.in_a_row, &self.dips, &self.place.kind] {
            word.store(0, Relaxed);
        }
        Axis::BOTH.into_iter().for_each(|axis| self.keep(axis, Taps::MIDDLE));
        self.mark.store(MARK, Relaxed);
    }
}

/// Words of a place: the line and the file's name, or the registers.
const WORDS: usize = 1 + FILE_BYTES / 4;
const PANIC: u32 = 1;
const FAULT: u32 = 2;

/// Where the program stopped itself, in words.
#[derive(Debug, Default)]
struct Place {
    /// [`PANIC`], [`FAULT`], or it has not.
    kind: AtomicU32,
    words: [AtomicU32; WORDS],
}

impl Place {
    fn keep(&self, stop: &Stop) {
        let mut words = [0; WORDS];
        let kind = match stop {
            Stop::Panic { file, line } => {
                words[0] = *line;
                for (word, bytes) in words[1..].iter_mut().zip(file.as_bytes().chunks(4)) {
                    *word = bytes.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte));
                }
                PANIC
            }
            Stop::Fault(FaultRegisters { pc, lr, cfsr, hfsr, mmfar, bfar }) => {
                words[..6].copy_from_slice(&[*pc, *lr, *cfsr, *hfsr, *mmfar, *bfar]);
                FAULT
            }
        };
        self.words.iter().zip(words).for_each(|(kept, word)| kept.store(word, Relaxed));
        self.kind.store(kind, Relaxed);
    }

    fn stop(&self) -> Option<Stop> {
        let words = self.words.each_ref().map(|word| word.load(Relaxed));
        match self.kind.load(Relaxed) {
            PANIC => {
                let bytes = words[1..].iter().flat_map(|word| word.to_le_bytes()).take_while(|&byte| byte != 0);
                let file = String::from_utf8(bytes.collect()).unwrap_or_default();
                Some(Stop::Panic { file, line: words[0] })
            }
            FAULT => {
                let [pc, lr, cfsr, hfsr, mmfar, bfar, ..] = words;
                Some(Stop::Fault(FaultRegisters { pc, lr, cfsr, hfsr, mmfar, bfar }))
            }
            _ => None,
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

    const REGISTERS: FaultRegisters = FaultRegisters { pc: 1, lr: 2, cfsr: 3, hfsr: 4, mmfar: 5, bfar: u32::MAX };

    #[test]
    fn power_finds_the_middle_taps_and_no_fault_whatever_is_in_the_memory() {
        for mark in [0, 1, MARK, u32::MAX] {
            for reset in [Reset::Power, Reset::BrownOut] {
                let (taps, place) = ([9.into(), 8.into()], Place { kind: FAULT.into(), words: Default::default() });
                let facts = [77, 1, 1, 9, 5].map(AtomicU32::new);
                let [restarts, stopped, at_record, in_a_row, dips] = facts;
                let kept = Kept { mark: mark.into(), restarts, stopped, at_record, in_a_row, dips, taps, place };
                let started = kept.started(reset);
                assert_eq!(Started { reset: ResetCause::Power, ..started.clone() }, Started::POWER);
                assert_eq!((started.reset == ResetCause::BrownOut, kept.dips()), (reset == Reset::BrownOut, 0));
            }
        }
    }

    #[test]
    fn a_restart_is_counted_told_apart_and_finds_the_taps_that_were_written() {
        let (kept, part) = (Kept::default(), Part::default());
        let _ = kept.started(Reset::Power);
        let mut keeping = Keeping::new(part.clone(), &kept);
        keeping.write(Axis::Y, Taps::LAST).unwrap();
        part.unplugged.set(true);
        assert!(keeping.write(Axis::X, Taps::FIRST).is_err());
        let taps = [Taps::MIDDLE, Taps::LAST];
        let stop = Stop::panic_at("src/compensator.rs", 212);
        kept.stopped(&stop);
        let panicked =
            Started { reset: ResetCause::Panic, restarts: 1, taps, stop: Some(stop.clone()), ..Started::POWER };
        assert_eq!(kept.started(Reset::Software), panicked);
        let bitten = Started { reset: ResetCause::Watchdog, restarts: 2, ..panicked };
        assert_eq!(kept.started(Reset::Watchdog), bitten, "and the place of the panic is still known");
        assert_eq!(kept.started(Reset::Pin), Started { reset: ResetCause::Pin, ..bitten.clone() });
        assert_eq!(kept.started(Reset::Software).reset, ResetCause::Software, "a panic is told once");
        kept.stopped(&Stop::Fault(REGISTERS));
        let fault = Started { reset: ResetCause::Fault, restarts: 3, stop: Some(Stop::Fault(REGISTERS)), ..bitten };
        assert_eq!(kept.started(Reset::Software), fault);
    }

    #[test]
    fn a_watchdog_that_bites_at_what_the_record_decides_counts_against_the_record_and_no_other_does() {
        let kept = Kept::default();
        let _ = kept.started(Reset::Power);
        // As a hang does it: the work never ends, and the flag stays.
        let hang = || kept.at_record.store(1, Relaxed);
        for n in 1..=9 {
            kept.at_record(|| ());
            assert!(!kept.started(Reset::Watchdog).set_aside, "{n} times between sets");
        }
        for n in 1..=3 {
            hang();
            let started = kept.started(Reset::Watchdog);
            assert_eq!((started.set_aside, started.restarts), (n == 3, 9 + n));
        }
        kept.works();
        hang();
        assert!(!kept.started(Reset::Pin).set_aside && !kept.started(Reset::Watchdog).set_aside, "a pin ends it");
    }

    #[test]
    fn an_interrupt_within_such_work_does_not_end_it() {
        let kept = Kept::default();
        let _ = kept.started(Reset::Power);
        // A scan is taken just before a set is worked on, and the set hangs.
        for n in 1..=3 {
            let started = kept.at_record(|| {
                kept.at_record(|| ());
                kept.started(Reset::Watchdog)
            });
            assert_eq!(started.set_aside, n == 3, "{n}");
        }
        kept.at_record(|| ());
        assert_eq!(kept.at_record.load(Relaxed), 0, "and with the outer work it ends");
    }

    #[test]
    fn a_board_that_cannot_tell_knows_by_its_memory_that_its_power_did_not_go() {
        let kept = Kept::default();
        assert_eq!(kept.started(Reset::Untold), Started::POWER);
        assert_eq!(kept.started(Reset::Untold).reset, ResetCause::Software);
        kept.stopped(&Stop::panic_at(&"x".repeat(60), 1));
        let started = kept.started(Reset::Untold);
        assert_eq!((started.reset, started.stop), (ResetCause::Panic, Some(Stop::panic_at(&"x".repeat(32), 1))));
    }

    #[test]
    fn a_program_that_stops_before_it_has_asked_why_it_started_is_known_too() {
        let kept = Kept { mark: 7.into(), restarts: 900.into(), ..Kept::default() };
        kept.stopped(&Stop::Fault(REGISTERS));
        let started = kept.started(Reset::Software);
        assert_eq!((started.reset, started.restarts), (ResetCause::Fault, 1));
    }
}
