//! Compensator and console in the shape in which interrupts and tasks share them.
//!
//! ```text
//! data ready (high)      Interrupt   set -> group -> law -> wiper
//!     | reports   ^ commands                                          queues, never waited for
//! console (low)          Task        frames, store
//!     ^ bytes
//! host line (middle)     pushes what it receives
//! ```

use heapless::spsc::{Consumer, Producer, Queue};
use rtic::Mutex;
use zerorate_core::compensate::AxisLaw;
use zerorate_device::acquisition::{Acquisition, Timing};
use zerorate_device::application::{COMMANDS, REPORTS};
use zerorate_device::compensator::{Compensator, Report, Scheduled, Status};
use zerorate_device::console::{Console, DeviceIdentity, Transmit};
use zerorate_device::store::RecordStore;
use zerorate_device::trim_part::TrimPart;

use crate::fault::{self, Started};

/// Bytes of the host that may wait for the console: two frames of the longest kind but one.
const RECEIVED: usize = 1024;

/// What joins the parts. It lives as long as the firmware.
pub struct Queues {
    commands: Queue<Scheduled, COMMANDS>,
    reports: Queue<Report, REPORTS>,
    received: Queue<u8, RECEIVED>,
}

impl Queues {
    /// Empty queues.
    #[must_use]
    pub const fn new() -> Self {
        Self { commands: Queue::new(), reports: Queue::new(), received: Queue::new() }
    }
}

impl Default for Queues {
    fn default() -> Self {
        Self::new()
    }
}

/// What the data-ready interrupt works with. The task below borrows it for moments: to look, to go on with samples, and
/// to take laws into use.
pub struct Interrupt<A, P> {
    compensator: Compensator<A, P>,
    commands: Consumer<'static, Scheduled>,
    reports: Producer<'static, Report>,
}

impl<A: Acquisition, P: TrimPart> Interrupt<A, P> {
    /// The work of the interrupt: a set is ready, or a command was queued.
    pub fn service(&mut self) {
        self.compensator.service(&mut self.commands, &mut self.reports);
        fault::keep_taps(self.compensator.status().taps);
    }

    fn stream(&mut self) -> bool {
        self.compensator.stream(&mut self.reports)
    }

    const fn status(&self) -> Status {
        self.compensator.status()
    }

    fn install(&mut self, laws: [AxisLaw; 2]) {
        self.compensator.install(laws);
    }
}

/// What the task below the interrupts works with.
pub struct Task<S> {
    console: Console<S>,
    commands: Producer<'static, Scheduled>,
    reports: Consumer<'static, Report>,
    received: Consumer<'static, u8>,
    taken: u32,
}

/// What the host's line pushes the bytes that it receives into.
pub type Received = Producer<'static, u8>;

/// The compensator at start-up: with both wipers at the middle tap, or, after a panic, where they were.
pub fn compensator<A: Acquisition, P: TrimPart>(
    acquisition: A,
    part: P,
    timing: Timing,
    started: &Started,
) -> Compensator<A, P> {
    if started.reset.is_fault() {
        Compensator::holding(acquisition, part, timing, started.taps)
    } else {
        Compensator::new(acquisition, part, timing)
    }
}

/// The parts at start-up, with the stored record in use if it is whole and this unit's. After a panic the compensation
/// goes on by itself.
pub fn start<A: Acquisition, P: TrimPart, S: RecordStore>(
    queues: &'static mut Queues,
    mut compensator: Compensator<A, P>,
    identity: DeviceIdentity,
    store: S,
    started: &Started,
) -> (Interrupt<A, P>, Task<S>, Received) {
    let mut console = Console::new(identity, compensator.timing(), store);
    console.started(started.reset, started.restarts);
    if let Some((laws, modes)) = console.take_laws() {
        compensator.install(laws);
        compensator.set_modes(modes);
        if started.reset.is_fault() {
            compensator.resume();
        }
    } else if started.reset.is_fault() {
        compensator.rest();
    }
    let (order, obey) = queues.commands.split();
    let (report, reported) = queues.reports.split();
    let (hear, heard) = queues.received.split();
    let interrupt = Interrupt { compensator, commands: obey, reports: report };
    (interrupt, Task { console, commands: order, reports: reported, received: heard, taken: 0 }, hear)
}

impl<S: RecordStore> Task<S> {
    /// Hears what the host has sent and sends what there is to say. `pend` asks for the interrupt's work, which is done
    /// before it returns.
    pub fn run<A: Acquisition, P: TrimPart>(
        &mut self,
        interrupt: &mut impl Mutex<T = Interrupt<A, P>>,
        line: &mut impl Transmit,
        pend: impl Fn(),
    ) {
        self.upload(interrupt, line);
        while let Some(byte) = self.received.dequeue() {
            let status = interrupt.lock(|interrupt| interrupt.status());
            let has_work = self.console.receive(byte, &status, &mut self.commands, line);
            self.taken = self.taken.wrapping_add(1);
            self.install(interrupt);
            if has_work {
                pend();
                self.upload(interrupt, line);
            }
        }
    }

    /// Bytes of the host that have been acted on since the start.
    #[must_use]
    pub const fn taken(&self) -> u32 {
        self.taken
    }

    fn upload<A: Acquisition, P: TrimPart>(
        &mut self,
        interrupt: &mut impl Mutex<T = Interrupt<A, P>>,
        line: &mut impl Transmit,
    ) {
        loop {
            let more = interrupt.lock(Interrupt::stream);
            self.console.upload(&mut self.reports, line);
            if !more {
                break;
            }
        }
        self.install(interrupt);
    }

    /// Takes a new record into use, when its group is about to begin.
    fn install<A: Acquisition, P: TrimPart>(&mut self, interrupt: &mut impl Mutex<T = Interrupt<A, P>>) {
        if let Some((laws, _)) = self.console.take_laws() {
            interrupt.lock(|interrupt| interrupt.install(laws));
        }
    }
}
