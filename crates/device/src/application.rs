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

use core::ops::Deref;

use zerorate_core::board::BoardNumbers;
use zerorate_core::compensate::Mode;
use zerorate_core::record::UnitSerial;
use zerorate_core::wire::Health;

use crate::acquisition::{Acquisition, Timing};
use crate::compensator::Compensator;
use crate::console::{Console, Transmit};
use crate::restart::{Keeping, Kept, Started};
use crate::store::RecordStore;
use crate::trim_part::TrimPart;
use crate::watchdog::{Supervisor, Watchdog};

/// Sets after which a program that has just started does its work with its record: a minute of the paper's.
const AT_WORK: u32 = 40;

/// What a home gives the application.
pub struct Parts<A, P, S, W, K> {
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
}

/// The application of a home.
pub struct Application<A, P, S, W, K> {
    /// What a data-ready interrupt works with.
    pub compensator: Compensator<A, Keeping<P, K>>,
    /// What goes round below it.
    pub task: Task<S, W, K>,
}

/// A compensator that a task shares with an interrupt.
pub trait Shared {
    /// Where its sets come from.
    type Acquisition: Acquisition;
    /// What trims.
    type Part: TrimPart;

    /// Borrows it; the interrupt waits meanwhile.
    fn lock<R>(&mut self, act: impl FnOnce(&mut Compensator<Self::Acquisition, Self::Part>) -> R) -> R;
}

/// Without interrupts it is there for the taking.
impl<A: Acquisition, P: TrimPart> Shared for Compensator<A, P> {
    type Acquisition = A;
    type Part = P;

    fn lock<R>(&mut self, act: impl FnOnce(&mut Self) -> R) -> R {
        act(self)
    }
}

impl<A, P, S, W, K> Application<A, P, S, W, K>
where
    A: Acquisition,
    P: TrimPart,
    S: RecordStore,
    W: Watchdog,
    K: Deref<Target = Kept> + Clone,
{
    /// The application at start-up: both wipers at the middle tap, and the stored record in use if it is whole and this
    /// unit's.
    ///
    /// A calibrated device takes groups by itself, host or no host, unless its record asks for silence: start-up modes that
    /// are off on both axes. After a restart by the watchdog or by a fault of the program the wipers are held where they are
    /// until the first group. A record with which the program has failed three times in a row is set aside.
    #[must_use]
    pub fn start(parts: Parts<A, P, S, W, K>) -> Self {
        let Parts { acquisition, trim, store, watchdog, kept, started, unit, timing, board, health } = parts;
        let goes_on = started.reset.is_fault();
        let trim = Keeping::new(trim, kept.clone());
        let mut compensator = if goes_on {
            Compensator::holding(acquisition, trim, timing, started.taps)
        } else {
            Compensator::new(acquisition, trim, timing)
        };
        compensator.built_on(board);
        let mut console = Console::new(unit, timing, store, started, health);
        if let Some(laws) = console.take_laws() {
            let modes = laws.start_up_modes;
            compensator.install(laws);
            compensator.set_modes(modes);
            if modes != [Mode::Off; 2] {
                compensator.begin_alone();
            }
        } else if goes_on {
            // Uncompensated means the middle tap; wherever the wipers were held, it was for a law that is gone.
            compensator.rest();
        }
        Self { compensator, task: Task { console, supervisor: Supervisor::new(watchdog), kept, taken: 0 } }
    }

    /// The task goes round once, in a home without interrupts, with the bytes that the host has sent.
    pub fn run(&mut self, bytes: impl IntoIterator<Item = u8>, line: &mut impl Transmit) {
        self.task.run(&mut self.compensator, bytes, line);
    }
}

/// The task below the interrupts: console, store and supervision.
pub struct Task<S, W, K> {
    console: Console<S>,
    supervisor: Supervisor<W>,
    kept: K,
    taken: u32,
}

impl<S: RecordStore, W: Watchdog, K: Deref<Target = Kept>> Task<S, W, K> {
    /// Goes round once: says what there is to say, acts on the bytes that the host has sent, and feeds the watchdog if all is
    /// well. Due after every set and whenever bytes have come.
    pub fn run(
        &mut self,
        compensator: &mut impl Shared,
        bytes: impl IntoIterator<Item = u8>,
        line: &mut impl Transmit,
    ) {
        self.report(compensator, line);
        for byte in bytes {
            self.taken = self.taken.wrapping_add(1);
            let Some(command) = self.console.hear(byte) else { continue };
            let mut status = compensator.lock(|compensator| compensator.status());
            status.faults.supply_dips = self.kept.dips();
            let order = self.console.obey(command, &status, line);
            self.install(compensator);
            if let Some(order) = order {
                compensator.lock(|compensator| compensator.order(order));
                self.report(compensator, line);
            }
        }
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

    /// Sends all that the compensator has to say.
    fn report(&mut self, compensator: &mut impl Shared, line: &mut impl Transmit) {
        while let Some(report) = compensator.lock(Compensator::next_report) {
            self.console.report(report, line);
        }
        self.install(compensator);
    }

    /// Takes a new record into use, when its group is about to begin.
    fn install(&mut self, compensator: &mut impl Shared) {
        if let Some(laws) = self.console.take_laws() {
            self.kept.works();
            compensator.lock(|compensator| compensator.install(laws));
        }
    }
}

#[cfg(test)]
mod tests;
