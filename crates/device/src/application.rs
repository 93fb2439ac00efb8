//! The whole application in one piece, for a home without interrupts: the native device.
//!
//! An interrupt-driven board keeps the same parts apart: [`Compensator`] in the interrupt, [`Console`] below it.

use heapless::spsc::Queue;

use crate::acquisition::Acquisition;
use crate::compensator::{Compensator, Report, Scheduled};
use crate::console::{Console, DeviceIdentity, Transmit};
use crate::store::RecordStore;
use crate::trim_part::TrimPart;

/// Commands between console and compensator.
pub const COMMANDS: usize = 8;
/// Reports between compensator and console: a group, some answers, and some blocks of samples at a time.
pub const REPORTS: usize = 12;

/// Compensator and console, joined by their queues.
pub struct Application<A, P, S> {
    compensator: Compensator<A, P>,
    console: Console<S>,
    commands: Queue<Scheduled, COMMANDS>,
    reports: Queue<Report, REPORTS>,
}

impl<A: Acquisition, P: TrimPart, S: RecordStore> Application<A, P, S> {
    /// The application at start-up, with the stored record in use if it is whole and this unit's.
    #[must_use]
    pub fn new(mut compensator: Compensator<A, P>, identity: DeviceIdentity, store: S) -> Self {
        let mut console = Console::new(identity, compensator.timing(), store);
        if let Some((laws, modes)) = console.take_laws() {
            compensator.install(laws);
            compensator.set_modes(modes);
        }
        Self { compensator, console, commands: Queue::new(), reports: Queue::new() }
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
    }

    /// Bytes from the host: acts on the commands in them and answers.
    pub fn receive(&mut self, bytes: &[u8], line: &mut impl Transmit) {
        for &byte in bytes {
            let status = self.compensator.status();
            let has_work = self.console.receive(byte, &status, &mut self.commands.split().0, line);
            if let Some((laws, _)) = self.console.take_laws() {
                self.compensator.install(laws);
            }
            if has_work {
                self.service();
                self.upload(line);
            }
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
