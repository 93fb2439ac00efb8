//! The device's own application on a plant: what it runs on, its watchdog and its tick.

use std::cell::Cell;
use std::rc::Rc;

use zerorate_core::board::BoardNumbers;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::Seconds;
use zerorate_core::wire::Health;
use zerorate_device::acquisition::{Acquisition, Timing};
use zerorate_device::application::{Application, Parts};
use zerorate_device::compensator::Memory;
use zerorate_device::console::Buffer;
use zerorate_device::direct::DirectAcquisition;
use zerorate_device::port::PortAcquisition;
use zerorate_device::restart::{Kept, Reset};
use zerorate_device::store::FlashStore;
use zerorate_device::trim_part::Max5494Trim;
use zerorate_device::watchdog::Watchdog;
use zerorate_sim::{
    ConverterSpi, Flash, FlashPart, Plant, PlantDelay, PortSpi, PotentiometerSpi, Scanned, SharedPlant, Truth,
};

use crate::link::LinkError;
use crate::setup::SetUp;
use crate::tick::Tick;

/// An acquisition that can be connected to the plant.
pub trait OnPlant: Acquisition + Sized {
    /// The acquisition on the plant's bus.
    fn connect(plant: &SharedPlant) -> Self;

    /// Lets the plant run to the next scan that the acquisition has; one that has whole sets alone, to the next set.
    fn run_scan(&mut self, plant: &SharedPlant) -> Scanned;

    /// Lets the plant run until a set is full; `None` if the acquisition stands still.
    fn run_set(&mut self, plant: &SharedPlant) -> Option<Truth> {
        loop {
            match self.run_scan(plant) {
                Scanned::Set(truth) => return Some(truth),
                Scanned::Scan => {}
                Scanned::None => return None,
            }
        }
    }

    /// Whether its data ready line is high. It interrupts as it rises, and where a set still waits it does not rise.
    fn data_ready(_: &SharedPlant) -> bool {
        false
    }
}

impl OnPlant for PortAcquisition<PortSpi> {
    fn connect(plant: &SharedPlant) -> Self {
        Self::new(PortSpi::new(plant))
    }

    fn run_scan(&mut self, plant: &SharedPlant) -> Scanned {
        plant.borrow_mut().run_scan()
    }

    fn data_ready(plant: &SharedPlant) -> bool {
        plant.borrow().data_ready()
    }
}

impl OnPlant for DirectAcquisition<ConverterSpi, PlantDelay> {
    fn connect(plant: &SharedPlant) -> Self {
        Self::new(ConverterSpi::new(plant), PlantDelay::new(plant))
    }

    fn run_scan(&mut self, plant: &SharedPlant) -> Scanned {
        if !self.is_running() {
            return Scanned::None;
        }
        plant.borrow_mut().next_scan();
        if self.tick() != Ok(true) {
            return Scanned::Scan;
        }
        // The plant counts on over a start, the acquisition begins again.
        let truth = plant.borrow_mut().take_truth().zip(self.waiting_number());
        truth.map_or(Scanned::None, |(truth, set)| Scanned::Set(Truth { set, ..truth }))
    }
}

type Potentiometer = Max5494Trim<PotentiometerSpi, PlantDelay>;

/// The flash that the native device keeps its record in: erased in pages of 4 KiB, written in words of four bytes.
type RecordFlash = FlashPart<PAGE, 4>;
const PAGE: usize = 4096;
/// The fewest pages that two of the longest records fit in.
const PAGES: usize = 4;
#[allow(clippy::cast_possible_truncation)] // 16 KiB
const FLASH_BYTES: u32 = (PAGES * PAGE) as u32;

/// The native device's application.
type NativeApplication<A> = Application<A, Potentiometer, FlashStore<RecordFlash>, SimulatedWatchdog, Rc<Kept>>;

/// The simulated watchdog restarts a board that has not fed it for so many seconds, or for three groups where they are
/// longer.
const WATCHDOG_S: f64 = 8.0;

/// A watchdog on the plant's time.
struct SimulatedWatchdog {
    plant: SharedPlant,
    fed_at: Rc<Cell<f64>>,
}

impl Watchdog for SimulatedWatchdog {
    fn feed(&mut self) {
        self.fed_at.set(self.plant.borrow().time().0);
    }
}

/// What the board has on it, besides its processor.
struct BareBoard {
    plant: SharedPlant,
    unit: UnitSerial,
    timing: Timing,
    numbers: BoardNumbers,
    flash: RecordFlash,
    fed_at: Rc<Cell<f64>>,
    /// Memory that a restart of the processor does not clear.
    kept: Rc<Kept>,
}

impl BareBoard {
    fn now(&self) -> Seconds {
        self.plant.borrow().time()
    }

    /// The application as it starts when power comes, or the watchdog has restarted it.
    fn start<A: OnPlant>(&self, reset: Reset) -> NativeApplication<A> {
        let Ok(store) = FlashStore::new(self.flash.clone(), 0..FLASH_BYTES) else {
            unreachable!("the pages are enough")
        };
        self.fed_at.set(self.now().0);
        Application::start(Parts {
            acquisition: A::connect(&self.plant),
            trim: Max5494Trim::new(PotentiometerSpi::new(&self.plant), PlantDelay::new(&self.plant)),
            store,
            watchdog: SimulatedWatchdog { plant: Rc::clone(&self.plant), fed_at: Rc::clone(&self.fed_at) },
            kept: Rc::clone(&self.kept),
            started: self.kept.started(reset),
            unit: self.unit.clone(),
            timing: self.timing,
            board: self.numbers,
            health: Health::default,
            memory: Memory::new(),
            buffer: Buffer::new(),
        })
    }
}

/// The native device: the application, what it runs on, and the bytes on their way to the host.
pub struct NativeDevice<A> {
    board: BareBoard,
    application: NativeApplication<A>,
    tick: Tick,
    pub(super) outgoing: Vec<u8>,
    pub(super) truths: Vec<Truth>,
    /// The frames on the second line; none where nobody listens, for a scan read alone costs more than all else in it.
    scan_line: Option<Vec<u8>>,
}

impl<A: OnPlant> NativeDevice<A> {
    /// The device on a plant of its own.
    #[must_use]
    pub fn of_plant(plant: Plant, setup: &SetUp, unit: &UnitSerial) -> Self {
        let mut plant = plant;
        plant.scan_every(setup.acquisition.sample_period_us);
        let timing = Timing {
            scan_period_us: setup.acquisition.sample_period_us,
            set_length: setup.acquisition.group_length,
            oversampling: setup.acquisition.oversampling,
        };
        let board = BareBoard {
            plant: plant.share(),
            unit: unit.clone(),
            timing,
            numbers: setup.numbers(),
            flash: FlashPart::new(Flash::erased(PAGES)),
            fed_at: Rc::default(),
            kept: Rc::default(),
        };
        let application = board.start(Reset::Power);
        let tick = Tick::after(board.now(), setup.group_period());
        Self { board, application, tick, outgoing: Vec::new(), truths: Vec::new(), scan_line: None }
    }

    /// The plant that it stands on.
    #[must_use]
    pub const fn plant(&self) -> &SharedPlant {
        &self.board.plant
    }

    /// What the device has said since the last call; a board in real time has nobody who asks for its truth.
    pub fn said(&mut self) -> Vec<u8> {
        self.truths.clear();
        core::mem::take(&mut self.outgoing)
    }

    /// What has gone out on the second line since the last call, scan by scan, if there is a listener.
    pub fn scans_said(&mut self, listens: bool) -> Vec<u8> {
        let said = self.scan_line.take().unwrap_or_default();
        self.scan_line = listens.then(Vec::new);
        said
    }

    /// The time of a group.
    #[must_use]
    pub fn group_period(&self) -> Seconds {
        let Timing { set_length, scan_period_us, .. } = self.board.timing;
        Seconds(f64::from(set_length) * f64::from(scan_period_us) * 1e-6)
    }

    /// Switches it off and on.
    pub fn power_cycle(&mut self) {
        self.plant().borrow_mut().power_cycle();
        self.restart(Reset::Power);
    }

    fn restart(&mut self, reset: Reset) {
        self.outgoing.clear();
        self.application = self.board.start(reset);
    }

    /// The task goes round with what the host has sent. Before it does, the watchdog has restarted the processor, and nothing
    /// else on the board, if it was not fed in time.
    pub fn hear(&mut self, bytes: &[u8]) {
        let patience = WATCHDOG_S.max(3.0 * self.group_period().0);
        if self.board.now().0 - self.board.fed_at.get() > patience {
            self.restart(Reset::Watchdog);
        }
        let Self { application, outgoing, .. } = self;
        application.run(bytes.iter().copied(), &mut |bytes: &[u8]| {
            outgoing.extend_from_slice(bytes);
            true
        });
    }

    /// Lets the plant run until a set is full, and the application take it if data ready rises.
    ///
    /// # Errors
    /// [`LinkError::Silent`], when no set comes.
    pub fn run_set(&mut self) -> Result<(), LinkError> {
        self.tick();
        let was_ready = A::data_ready(&self.board.plant);
        let Some(truth) = self.until_set_is_full() else {
            if self.application.compensator.status().running {
                // Sets should come and do not: time passes all the same.
                self.plant().borrow_mut().wait(self.group_period());
                self.tick();
            }
            return Err(LinkError::Silent);
        };
        self.truths.push(truth);
        if !was_ready {
            self.application.compensator.service();
            self.hear(&[]);
        }
        Ok(())
    }

    fn until_set_is_full(&mut self) -> Option<Truth> {
        let compensator = &mut self.application.compensator;
        let Some(line) = &mut self.scan_line else {
            return compensator.acquisition().run_set(&self.board.plant);
        };
        loop {
            let scanned = compensator.acquisition().run_scan(&self.board.plant);
            if let Some(frame) = compensator.scan().and_then(|report| report.frame().ok()) {
                line.extend(frame);
            }
            match scanned {
                Scanned::Set(truth) => return Some(truth),
                Scanned::Scan => {}
                Scanned::None => return None,
            }
        }
    }

    /// Lets time pass with the acquisition standing still and nobody speaking: the board has its tick alone.
    pub fn stand(&mut self, time: Seconds) {
        let until = self.board.now() + time;
        while self.tick.next().0 <= until.0 {
            let left = self.tick.next() - self.board.now();
            self.plant().borrow_mut().wait(left);
            self.tick();
        }
        let left = until - self.board.now();
        self.plant().borrow_mut().wait(left);
    }

    /// Lets time pass that the bench leaves out, since nobody looks at it: the device has done its work meanwhile.
    pub(super) fn leave_out(&mut self, time: Seconds) {
        self.plant().borrow_mut().wait(time);
        let now = self.board.now();
        self.board.fed_at.set(now.0);
        self.tick = Tick::after(now, self.group_period());
    }

    /// The ticks that are due.
    fn tick(&mut self) {
        while self.tick.is_due(self.board.now()) {
            self.application.compensator.tick();
            self.hear(&[]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plants::PlantKind;

    #[test]
    fn the_tick_comes_at_whatever_fraction_of_a_second_a_board_was_started() {
        // From 8192 s on a second's fraction has a binary digit less: a tick may be a trillionth of a second off the plant's time.
        for nanoseconds in (0..200).map(|n| f64::from(n) * 4_999_961.0) {
            let plant = PlantKind::Paper.build(1);
            let mut device =
                NativeDevice::<PortAcquisition<PortSpi>>::of_plant(plant, &SetUp::paper(), &UnitSerial::default());
            device.leave_out(Seconds(8180.0 + nanoseconds * 1e-9));
            device.stand(Seconds(20.0));
            assert!(device.tick.next().0 > device.board.now().0);
        }
    }

    #[test]
    fn a_board_that_stands_still_on_a_quiet_line_is_not_reset() {
        let plant = PlantKind::Paper.build(1);
        let mut device =
            NativeDevice::<PortAcquisition<PortSpi>>::of_plant(plant, &SetUp::paper(), &UnitSerial::default());
        device.stand(Seconds(60.0));
        device.hear(&[]);
        assert_eq!(device.board.kept.started(Reset::Untold).restarts, 0);
    }
}
