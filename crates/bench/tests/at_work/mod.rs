//! A calibrated device at work on a bench on which anything can be broken.

#![allow(dead_code)] // a test takes what it needs

#[path = "../paper_record/mod.rs"]
pub mod paper_record;

use zerorate_bench::client::DeviceClient;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_core::compensate::{Mode, StaticLaw};
use zerorate_core::group::CODES_PER_COUNT;
use zerorate_core::record::{DeviceRecord, UnitSerial};
use zerorate_core::units::{Axis, Taps, TemperatureScale};
use zerorate_core::wire::{GroupReport, Request, SampleWindow};
use zerorate_sim::{Fault, SharedPlant};

pub fn record(valid: [f64; 2]) -> DeviceRecord {
    paper_record::record(valid, None, 0.05)
}

/// A calibrated device at work, X and Y in mode trim.
pub struct Rig {
    pub device: DeviceClient,
    pub plant: SharedPlant,
    /// The law of both axes.
    pub law: StaticLaw,
}

impl Rig {
    pub fn at_work() -> Self {
        Self::calibrated_over([8500.0, 11_900.0])
    }

    pub fn calibrated_over(valid: [f64; 2]) -> Self {
        let unit = UnitSerial::try_from("ZR-1").unwrap();
        let (link, plant) = simulated::bare_device(PlantKind::Paper.build(1), &SetUp::paper(), &unit);
        let law = paper_record::model(valid, None, 0.05).static_law(TemperatureScale::QUARTER_COUNTS);
        let mut rig = Self { device: DeviceClient::new(link), plant, law };
        rig.device.identify().unwrap();
        rig.device.deploy(&record(valid)).unwrap();
        for axis in Axis::BOTH {
            rig.device.order(Request::SetMode { axis, mode: Mode::Trim }).unwrap();
        }
        rig.start();
        rig
    }

    fn start(&mut self) {
        self.device.order(Request::SetStream { groups: true, samples: SampleWindow::NONE }).unwrap();
        self.device.order(Request::SetAcquisition { run: true }).unwrap();
    }

    pub fn inject(&self, fault: Fault) {
        self.plant.borrow_mut().inject(fault);
    }

    pub fn group(&mut self) -> GroupReport {
        self.device.next_group().unwrap().report
    }

    pub fn groups(&mut self, n: usize) -> Vec<GroupReport> {
        (0..n).map(|_| self.group()).collect()
    }

    /// The tap that the model asks for at a group's own temperature.
    pub fn asked(&self, group: &GroupReport, axis: Axis) -> Taps {
        let code = group.axes[axis.index()].sums.temperature_code(CODES_PER_COUNT).unwrap();
        self.law.tap(code).unwrap()
    }

    pub fn wiper(&self, axis: Axis) -> u16 {
        self.plant.borrow().potentiometer().wiper(axis).get()
    }
}
