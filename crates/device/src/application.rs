//! The application: what is assembled when a board starts, fed, supervised and restarted, whatever the board.
//!
//! ```text
//! data ready (high)   Compensator   set -> group -> law -> wiper
//!     | reports   ^ commands                                        borrowed for moments, never while flash is written
//! task (low)          Task          frames, store, watchdog
//! ```
//!
//! A board with interrupts shares the [`Compensator`] with its data-ready interrupt and runs the [`Task`] below it; a home
//! without has both in one piece.

use core::borrow;
use core::ops::Deref;

use zerorate_core::board::BoardNumbers;
use zerorate_core::compensate::Mode;
use zerorate_core::record::UnitSerial;
use zerorate_core::wire::{Command, Health, Identity};

use crate::acquisition::{Acquisition, Timing};
use crate::compensator::{self, Compensator};
use crate::console::{Buffer, Console, Transmit};
use crate::restart::{Keeping, Kept, Started};
use crate::store::RecordStore;
use crate::trim_part::TrimPart;
use crate::watchdog::{Supervisor, Watchdog};

/// Sets after which a program that has just started does its work with its record: a minute of the paper's.
const AT_WORK: u32 = 40;

/// What a home gives the application.
pub struct Parts<A, P, S, W, K, M = compensator::Memory, B = Buffer> {
    /// Where sets come from.
    pub acquisition: A,
    /// What trims.
    pub trim: P,
    /// Where the record is kept.
    pub store: S,
    /// What restarts the processor when it is not fed; running.
    pub watchdog: W,
    /// What is kept through a restart.
    pub kept: K,
    /// What is known of this start.
    pub started: Started,
    /// The unit's serial; empty on a board that has not been given one, which takes any record.
    pub unit: UnitSerial,
    /// How sets are taken.
    pub timing: Timing,
    /// The board's converter and sensors, until a record tells more.
    pub board: BoardNumbers,
    /// How the board finds itself.
    pub health: fn() -> Health,
    /// What is large, or where it is: on a board statics.
    pub memory: M,
    /// Where a record is put together.
    pub buffer: B,
}

/// The application of a home.
pub struct Application<A, P, S, W, K, M = compensator::Memory, B = Buffer> {
    /// What a data-ready interrupt works with.
    pub compensator: Compensator<A, Keeping<P, K>, M>,
    /// What goes round below it.
    pub task: Task<S, W, K, B>,
}

/// A compensator that a task shares with an interrupt.
pub trait Shared {
    /// Where its sets come from.
    type Acquisition: Acquisition;
    /// What trims.
    type Part: TrimPart;
    /// Where what is large is.
    type Memory: borrow::BorrowMut<compensator::Memory>;

    /// Borrows it; the interrupt waits meanwhile.
    fn lock<R>(&mut self, act: impl FnOnce(&mut Compensator<Self::Acquisition, Self::Part, Self::Memory>) -> R) -> R;
}

/// Without interrupts it is there for the taking.
impl<A: Acquisition, P: TrimPart, M: borrow::BorrowMut<compensator::Memory>> Shared for Compensator<A, P, M> {
    type Acquisition = A;
    type Part = P;
    type Memory = M;

    fn lock<R>(&mut self, act: impl FnOnce(&mut Self) -> R) -> R {
        act(self)
    }
}

impl<A, P, S, W, K, M, B> Application<A, P, S, W, K, M, B>
where
    A: Acquisition,
    P: TrimPart,
    S: RecordStore,
    W: Watchdog,
    K: Deref<Target = Kept> + Clone,
    M: borrow::BorrowMut<compensator::Memory>,
    B: borrow::BorrowMut<Buffer>,
{
    /// The application at start-up: both wipers at the middle tap, and the stored record in use if it is whole and this
    /// unit's.
    ///
    /// A calibrated device takes groups by itself, host or no host, unless its record asks for silence: start-up modes that
    /// are off on both axes. After a restart by the watchdog or by a fault of the program the wipers are held where they are
    /// until the first group. A record with which the program has failed three times in a row is set aside.
    #[must_use]
    pub fn start(parts: Parts<A, P, S, W, K, M, B>) -> Self {
        let Parts { acquisition, trim, store, watchdog, kept, started, unit, timing, board, health, memory, buffer } =
            parts;
        let goes_on = started.reset.is_fault();
        let trim = Keeping::new(trim, kept.clone());
        let mut compensator = if goes_on {
            Compensator::holding(acquisition, trim, memory, timing, started.taps)
        } else {
            Compensator::new(acquisition, trim, memory, timing)
        };
        compensator.built_on(board);
        let console = kept.at_record(|| Console::new(unit, timing, store, buffer, started, health));
        let mut task = Task { console, supervisor: Supervisor::new(watchdog), kept: kept.clone(), taken: 0 };
        if let Some(modes) = kept.at_record(|| task.install(&mut compensator)) {
            compensator.set_modes(modes);
            if modes != [Mode::Off; 2] {
                compensator.begin_alone();
            }
        } else if goes_on {
            // Uncompensated means the middle tap; wherever the wipers were held, it was for a law that is gone.
            compensator.rest();
        }
        Self { compensator, task }
    }

    /// Who the board is, and whether its record is in use.
    #[must_use]
    pub fn identity(&self) -> Identity {
        self.task.console.identity(&self.compensator.status())
    }

    /// The task goes round once, in a home without interrupts, with the bytes that the host has sent.
    pub fn run(&mut self, bytes: impl IntoIterator<Item = u8>, line: &mut impl Transmit) {
        self.task.run(&mut self.compensator, bytes, line);
    }
}

/// The task below the interrupts: console, store and supervision.
pub struct Task<S, W, K, B = Buffer> {
    console: Console<S, B>,
    supervisor: Supervisor<W>,
    kept: K,
    taken: u32,
}

impl<S: RecordStore, W: Watchdog, K: Deref<Target = Kept>, B: borrow::BorrowMut<Buffer>> Task<S, W, K, B> {
    /// Goes round until there is nothing left to say and the host's bytes run dry. Due after every set and whenever bytes have
    /// come.
    ///
    /// A host may ask faster than it can be answered, without end. So in each turn answers and groups go out, the watchdog is
    /// fed if all is well, and then a command is acted on; samples have the turns in which there is none.
    pub fn run(
        &mut self,
        compensator: &mut impl Shared,
        bytes: impl IntoIterator<Item = u8>,
        line: &mut impl Transmit,
    ) {
        let mut bytes = bytes.into_iter();
        loop {
            while let Some(report) = compensator.lock(Compensator::next_but_samples) {
                self.console.report(report, line);
            }
            self.go_on(compensator);
            self.supervise(compensator);
            if let Some(command) = self.hear(&mut bytes) {
                self.obey(command, compensator, line);
            } else if let Some(report) = compensator.lock(Compensator::next_report) {
                self.console.report(report, line);
            } else {
                return;
            }
        }
    }

    /// The next command among the bytes.
    fn hear(&mut self, bytes: &mut impl Iterator<Item = u8>) -> Option<Command> {
        bytes.find_map(|byte| {
            self.taken = self.taken.wrapping_add(1);
            self.console.hear(byte)
        })
    }

    /// Acts on the command that was heard last.
    fn obey(&mut self, command: Command, compensator: &mut impl Shared, line: &mut impl Transmit) {
        let mut status = compensator.lock(|compensator| compensator.status());
        status.faults.supply_dips = self.kept.dips();
        let order = self.console.obey(command, &status, line);
        self.go_on(compensator);
        if let Some(order) = order {
            compensator.lock(|compensator| compensator.order(order));
        }
    }

    fn supervise(&mut self, compensator: &mut impl Shared) {
        let status = compensator.lock(|compensator| compensator.status());
        self.supervisor.task_ran(&status);
        if status.sets >= AT_WORK && self.console.is_calibrated() {
            self.kept.works();
        }
    }

    /// Bytes of the host that have been acted on since the start.
    #[must_use]
    pub const fn taken(&self) -> u32 {
        self.taken
    }

    /// Takes a new record into use, when its group is about to begin.
    fn go_on(&mut self, compensator: &mut impl Shared) {
        if self.install(compensator).is_some() {
            self.kept.works();
        }
    }

    /// Takes the record into use that waits for it; the modes in which it starts. The laws stand on the stack for as long as this
    /// takes, and no longer.
    #[inline(never)]
    fn install(&mut self, compensator: &mut impl Shared) -> Option<[Mode; 2]> {
        self.console.take_laws(|laws| {
            compensator.lock(|compensator| compensator.install(laws));
            laws.start_up_modes
        })
    }
}

#[cfg(test)]
mod tests;
