//! The simulated bench: the device's own application running natively against the plant, spoken to in wire bytes.
//!
//! Time passes only when the host waits: for a group (the plant runs until a set is full, the application is told that
//! data are ready), or for the chamber with the acquisition stopped. So simulated time runs as fast as it can, and
//! every run of the same seed is the same.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Axis, Celsius, Seconds, Taps, Volts};
use zerorate_device::acquisition::{Acquisition, Timing};
use zerorate_device::application::{Application, Parts};
use zerorate_device::direct::DirectAcquisition;
use zerorate_device::port::PortAcquisition;
use zerorate_device::restart::Kept;
use zerorate_device::store::FlashStore;
use zerorate_device::trim_part::Max5494Trim;
use zerorate_device::watchdog::Watchdog;
use zerorate_sim::{ConverterSpi, Flash, FlashPart, Plant, PlantDelay, PortSpi, PotentiometerSpi, SharedPlant, Truth};

use crate::client::DeviceClient;
use crate::instruments::{Bench, Chamber, InstrumentError, Supply, Surroundings, Witness};
use crate::link::{Link, LinkError};
use crate::setup::SetUp;

/// An acquisition that can be connected to the plant.
pub trait OnPlant: Acquisition + Sized {
    /// The acquisition on the plant's bus.
    fn connect(plant: &SharedPlant) -> Self;

    /// Lets the plant run until a set is full; `None` if the acquisition stands still.
    fn run_set(&mut self, plant: &SharedPlant) -> Option<Truth>;
}

impl OnPlant for PortAcquisition<PortSpi> {
    fn connect(plant: &SharedPlant) -> Self {
        Self::new(PortSpi::new(plant))
    }

    fn run_set(&mut self, plant: &SharedPlant) -> Option<Truth> {
        plant.borrow_mut().run_set()
    }
}

impl OnPlant for DirectAcquisition<ConverterSpi, PlantDelay> {
    fn connect(plant: &SharedPlant) -> Self {
        Self::new(ConverterSpi::new(plant), PlantDelay::new(plant))
    }

    fn run_set(&mut self, plant: &SharedPlant) -> Option<Truth> {
        while self.is_running() {
            plant.borrow_mut().next_scan();
            if self.tick() == Ok(true) {
                // The plant counts on over a start, the acquisition begins again.
                let truth = plant.borrow_mut().take_truth()?;
                return Some(Truth { set: self.waiting_number()?, ..truth });
            }
        }
        None
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
    flash: RecordFlash,
    fed_at: Rc<Cell<f64>>,
    /// Memory that a restart of the processor does not clear.
    kept: Rc<Kept>,
}

impl BareBoard {
    /// The application as it starts when power comes, or the watchdog has restarted it.
    fn start<A: OnPlant>(&self, by_watchdog: bool) -> NativeApplication<A> {
        let Ok(store) = FlashStore::new(self.flash.clone(), 0..FLASH_BYTES) else {
            unreachable!("the pages are enough")
        };
        self.fed_at.set(self.plant.borrow().time().0);
        Application::start(Parts {
            acquisition: A::connect(&self.plant),
            trim: Max5494Trim::new(PotentiometerSpi::new(&self.plant), PlantDelay::new(&self.plant)),
            store,
            watchdog: SimulatedWatchdog { plant: Rc::clone(&self.plant), fed_at: Rc::clone(&self.fed_at) },
            kept: Rc::clone(&self.kept),
            by_watchdog,
            unit: self.unit.clone(),
            timing: self.timing,
        })
    }
}

/// The native device: the application, what it runs on, and the bytes on their way to the host.
pub(crate) struct NativeDevice<A> {
    board: BareBoard,
    application: NativeApplication<A>,
    outgoing: Vec<u8>,
    truths: Vec<Truth>,
}

impl<A: OnPlant> NativeDevice<A> {
    /// The device on a plant of its own.
    pub(crate) fn of_plant(plant: Plant, setup: &SetUp, unit: &UnitSerial) -> Self {
        let mut plant = plant;
        plant.scan_every(setup.acquisition.sample_period_us);
        let timing =
            Timing { scan_period_us: setup.acquisition.sample_period_us, set_length: setup.acquisition.group_length };
        let board = BareBoard {
            plant: plant.share(),
            unit: unit.clone(),
            timing,
            flash: FlashPart::new(Flash::erased(PAGES)),
            fed_at: Rc::default(),
            kept: Rc::default(),
        };
        let application = board.start(false);
        Self { board, application, outgoing: Vec::new(), truths: Vec::new() }
    }

    pub(crate) const fn plant(&self) -> &SharedPlant {
        &self.board.plant
    }

    /// What the device has said since the last call; a board in real time has nobody who asks for its truth.
    pub(crate) fn said(&mut self) -> Vec<u8> {
        self.truths.clear();
        core::mem::take(&mut self.outgoing)
    }

    pub(crate) fn group_period(&self) -> Seconds {
        let Timing { set_length, scan_period_us } = self.board.timing;
        Seconds(f64::from(set_length) * f64::from(scan_period_us) * 1e-6)
    }

    pub(crate) fn power_cycle(&mut self) {
        self.plant().borrow_mut().power_cycle();
        self.board.kept = Rc::default();
        self.restart(false);
    }

    fn restart(&mut self, by_watchdog: bool) {
        self.outgoing.clear();
        self.application = self.board.start(by_watchdog);
    }

    /// The task goes round with what the host has sent; the watchdog restarts the processor, and nothing else on the board,
    /// if it was not fed.
    pub(crate) fn hear(&mut self, bytes: &[u8]) {
        let Self { application, outgoing, .. } = self;
        application.run(bytes.iter().copied(), &mut |bytes: &[u8]| {
            outgoing.extend_from_slice(bytes);
            true
        });
        let patience = WATCHDOG_S.max(3.0 * self.group_period().0);
        if self.plant().borrow().time().0 - self.board.fed_at.get() > patience {
            self.restart(true);
        }
    }

    /// Lets the plant run until a set is full, and the application take it.
    pub(crate) fn run_set(&mut self) -> Result<(), LinkError> {
        let compensator = &mut self.application.compensator;
        let Some(truth) = compensator.acquisition().run_set(&self.board.plant) else {
            if compensator.status().running {
                // Sets should come and do not: time passes all the same.
                self.plant().borrow_mut().wait(self.group_period());
                self.hear(&[]);
            }
            return Err(LinkError::Silent);
        };
        self.truths.push(truth);
        compensator.service();
        self.hear(&[]);
        Ok(())
    }
}

/// The line to a native device.
struct NativeLink<A>(Rc<RefCell<NativeDevice<A>>>);

impl<A: OnPlant> Link for NativeLink<A> {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.0.borrow_mut().hear(bytes);
        Ok(())
    }

    fn receive(&mut self, into: &mut Vec<u8>) -> Result<(), LinkError> {
        let mut device = self.0.borrow_mut();
        while device.outgoing.is_empty() {
            device.run_set()?;
        }
        into.append(&mut device.outgoing);
        Ok(())
    }
}

struct SimulatedSurroundings<A>(Rc<RefCell<NativeDevice<A>>>);

impl<A: OnPlant> Surroundings for SimulatedSurroundings<A> {
    fn power_cycle(&mut self) -> Result<(), InstrumentError> {
        self.0.borrow_mut().power_cycle();
        Ok(())
    }

    fn wait(&mut self, time: Seconds) -> Result<(), InstrumentError> {
        let device = self.0.borrow();
        device.plant().borrow_mut().wait(time);
        // The device does its work meanwhile, on a bench that leaves out what nobody looks at.
        device.board.fed_at.set(device.plant().borrow().time().0);
        Ok(())
    }
}

struct SimulatedWitness<A>(Rc<RefCell<NativeDevice<A>>>);

impl<A: OnPlant> Witness for SimulatedWitness<A> {
    fn take(&mut self) -> Vec<Truth> {
        core::mem::take(&mut self.0.borrow_mut().truths)
    }

    fn tap_counts(&self, axis: Axis, tap: Taps) -> f64 {
        self.0.borrow().plant().borrow().true_tap_counts(axis, tap)
    }
}

pub(crate) struct SimulatedChamber {
    plant: SharedPlant,
    set_point: Celsius,
}

impl SimulatedChamber {
    /// The plant's chamber, its set point where its air is.
    pub(crate) fn new(plant: &SharedPlant) -> Self {
        Self { plant: Rc::clone(plant), set_point: plant.borrow().chamber_air() }
    }
}

impl Chamber for SimulatedChamber {
    fn set(&mut self, set_point: Celsius) -> Result<(), InstrumentError> {
        self.plant
            .borrow_mut()
            .chamber_set_point(set_point)
            .map_err(|outside| InstrumentError::SetPoint { set_point_c: set_point.0, reason: outside.to_string() })?;
        self.set_point = set_point;
        Ok(())
    }

    fn set_point(&self) -> Celsius {
        self.set_point
    }

    fn air(&mut self) -> Result<Celsius, InstrumentError> {
        Ok(self.plant.borrow().chamber_air())
    }
}

pub(crate) struct SimulatedSupply(pub(crate) SharedPlant);

impl Supply for SimulatedSupply {
    fn feed(&mut self, volts: Volts) -> Result<(), InstrumentError> {
        self.0.borrow_mut().connect_supply(volts);
        Ok(())
    }

    fn connect_gyros(&mut self) -> Result<(), InstrumentError> {
        self.0.borrow_mut().connect_gyro();
        Ok(())
    }

    fn gyro_output(&mut self, axis: Axis) -> Result<Volts, InstrumentError> {
        Ok(self.0.borrow().rate_volts(axis))
    }
}

/// The simulated bench about a plant, its device reading whole sets from the acquisition port.
#[must_use]
pub fn bench(plant: Plant, setup: &SetUp, unit: &UnitSerial) -> Bench {
    bench_on::<PortAcquisition<PortSpi>>(plant, setup, unit)
}

/// The simulated bench about a plant, its device driving the A/D itself.
#[must_use]
pub fn direct_bench(plant: Plant, setup: &SetUp, unit: &UnitSerial) -> Bench {
    bench_on::<DirectAcquisition<ConverterSpi, PlantDelay>>(plant, setup, unit)
}

/// A native device about a plant with nothing around it: the line to it, and the plant, on which anything can be broken.
#[must_use]
pub fn bare_device(plant: Plant, setup: &SetUp, unit: &UnitSerial) -> (Box<dyn Link>, SharedPlant) {
    let device = NativeDevice::<PortAcquisition<PortSpi>>::of_plant(plant, setup, unit);
    let plant = Rc::clone(device.plant());
    (Box::new(NativeLink(Rc::new(RefCell::new(device)))), plant)
}

/// The simulated bench about a plant, its device on an acquisition of any kind.
#[must_use]
pub fn bench_on<A: OnPlant + 'static>(plant: Plant, setup: &SetUp, unit: &UnitSerial) -> Bench {
    let device = NativeDevice::<A>::of_plant(plant, setup, unit);
    let plant = Rc::clone(device.plant());
    let device = Rc::new(RefCell::new(device));
    Bench {
        device: DeviceClient::new(Box::new(NativeLink(Rc::clone(&device)))),
        chamber: Box::new(SimulatedChamber::new(&plant)),
        supply: Box::new(SimulatedSupply(plant)),
        surroundings: Box::new(SimulatedSurroundings(Rc::clone(&device))),
        witness: Some(Box::new(SimulatedWitness(device))),
    }
}
