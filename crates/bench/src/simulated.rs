//! The simulated bench: the device's own application running natively against the plant, spoken to in wire bytes.
//!
//! Time passes only when the host waits: for a group (the plant runs until a set is full, the application is told that
//! data are ready), or for the chamber with the acquisition stopped. So simulated time runs as fast as it can, and
//! every run of the same seed is the same.

mod native;

use std::cell::RefCell;
use std::rc::Rc;

use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Axis, Celsius, Seconds, Taps, Volts};
use zerorate_device::direct::DirectAcquisition;
use zerorate_device::port::PortAcquisition;
use zerorate_sim::{ConverterSpi, Plant, PlantDelay, PortSpi, SharedPlant, Truth};

use crate::client::DeviceClient;
use crate::instruments::{Bench, Chamber, Clock, Cycled, InstrumentError, Power, Supply, Witness};
use crate::link::{Link, LinkError, MOST_UNHEARD};
use crate::setup::SetUp;

pub use native::{NativeDevice, OnPlant};

/// The line to a native device.
struct NativeLink<A>(Rc<RefCell<NativeDevice<A>>>);

impl<A: OnPlant> Link for NativeLink<A> {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.0.borrow_mut().hear(bytes);
        Ok(())
    }

    fn receive(&mut self, into: &mut Vec<u8>) -> Result<(), LinkError> {
        let mut device = self.0.borrow_mut();
        for _ in 0..MOST_UNHEARD {
            if !device.outgoing.is_empty() {
                into.append(&mut device.outgoing);
                return Ok(());
            }
            device.run_set()?;
        }
        Err(LinkError::Silent)
    }
}

struct SimulatedPower<A>(Rc<RefCell<NativeDevice<A>>>);

impl<A: OnPlant> Power for SimulatedPower<A> {
    fn cycle(&mut self) -> Result<Cycled, InstrumentError> {
        self.0.borrow_mut().power_cycle();
        Ok(Cycled::Done)
    }
}

struct PlantClock<A>(Rc<RefCell<NativeDevice<A>>>);

impl<A: OnPlant> Clock for PlantClock<A> {
    fn wait(&mut self, time: Seconds) -> Result<(), InstrumentError> {
        self.0.borrow_mut().leave_out(time);
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
        power: Box::new(SimulatedPower(Rc::clone(&device))),
        clock: Some(Box::new(PlantClock(Rc::clone(&device)))),
        witness: Some(Box::new(SimulatedWitness(device))),
    }
}
