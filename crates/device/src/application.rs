//! The whole application in one piece, for a home without interrupts: the native device.
//!
//! An interrupt-driven board keeps the same parts apart: [`Compensator`] in the interrupt, [`Console`] below it.

use heapless::spsc::Queue;
use zerorate_core::wire::ResetCause;

use crate::acquisition::Acquisition;
use crate::compensator::{Compensator, Report, Scheduled, Status};
use crate::console::{Console, DeviceIdentity, Transmit};
use crate::store::RecordStore;
use crate::trim_part::TrimPart;
use crate::watchdog::{NoWatchdog, Supervisor, Watchdog};

/// Commands between console and compensator.
pub const COMMANDS: usize = 8;
/// Reports between compensator and console: a group, some answers, and some blocks of samples at a time.
pub const REPORTS: usize = 12;

/// Compensator and console, joined by their queues.
pub struct Application<A, P, S, W = NoWatchdog> {
    compensator: Compensator<A, P>,
    console: Console<S>,
    commands: Queue<Scheduled, COMMANDS>,
    reports: Queue<Report, REPORTS>,
    supervisor: Supervisor<W>,
}

impl<A: Acquisition, P: TrimPart, S: RecordStore> Application<A, P, S> {
    /// The application at start-up, with the stored record in use if it is whole and this unit's.
    #[must_use]
    pub fn new(compensator: Compensator<A, P>, identity: DeviceIdentity, store: S) -> Self {
        Self::supervised(compensator, identity, store, NoWatchdog, ResetCause::Power, 0)
    }
}

impl<A: Acquisition, P: TrimPart, S: RecordStore, W: Watchdog> Application<A, P, S, W> {
    /// The application at start-up with a watchdog over it. After a restart by the watchdog or by a fault of the program,
    /// a calibrated device takes groups again by itself: compensation goes on, host or no host. The compensator is then one
    /// that [holds](Compensator::holding) the wipers.
    #[must_use]
    pub fn supervised(
        mut compensator: Compensator<A, P>,
        identity: DeviceIdentity,
        store: S,
        watchdog: W,
        reset: ResetCause,
        restarts: u32,
    ) -> Self {
        let mut console = Console::new(identity, compensator.timing(), store);
        console.started(reset, restarts);
        if let Some((laws, modes)) = console.take_laws() {
            compensator.install(laws);
            compensator.set_modes(modes);
            if reset.is_fault() {
                compensator.resume();
            }
        } else if reset.is_fault() {
            // Uncompensated means the middle tap; wherever the wipers were held, it was for a law that is gone.
            compensator.rest();
        }
        let supervisor = Supervisor::new(watchdog);
        Self { compensator, console, commands: Queue::new(), reports: Queue::new(), supervisor }
    }

    /// What the compensator says of itself.
    #[must_use]
    pub fn status(&self) -> Status {
        self.compensator.status()
    }

    /// The task goes round once more: feeds the watchdog if all is well.
    pub fn task_ran(&mut self) {
        self.supervisor.task_ran(&self.compensator.status());
    }

    /// The watchdog.
    pub const fn watchdog(&mut self) -> &mut W {
        self.supervisor.watchdog()
    }

    /// The compensator's acquisition, for whoever drives its ticks.
    pub const fn acquisition(&mut self) -> &mut A {
        self.compensator.acquisition()
    }

    /// Where the record is kept.
    pub const fn store(&self) -> &S {
        self.console.store()
    }

    /// Data ready: closes the group and sends what there is to say.
    pub fn data_ready(&mut self, line: &mut impl Transmit) {
        self.service();
        self.upload(line);
        self.install();
    }

    /// Bytes from the host: acts on the commands in them and answers.
    pub fn receive(&mut self, bytes: &[u8], line: &mut impl Transmit) {
        for &byte in bytes {
            let status = self.compensator.status();
            let has_work = self.console.receive(byte, &status, &mut self.commands.split().0, line);
            self.install();
            if has_work {
                self.service();
                self.upload(line);
            }
        }
    }

    /// Takes a new record into use, when its group is about to begin.
    fn install(&mut self) {
        if let Some((laws, _)) = self.console.take_laws() {
            self.compensator.install(laws);
        }
    }

    /// Sends what there is, and the samples that had no room in the queue.
    fn upload(&mut self, line: &mut impl Transmit) {
        loop {
            let (mut reports, mut reported) = self.reports.split();
            let more = self.compensator.stream(&mut reports);
            self.console.upload(&mut reported, line);
            if !more {
                break;
            }
        }
    }

    fn service(&mut self) {
        let (mut reports, _) = self.reports.split();
        self.compensator.service(&mut self.commands.split().1, &mut reports);
    }
}
