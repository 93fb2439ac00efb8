//! The bench as one thing: everything connected, on one timeline.
//!
//! Time moves only when it is asked to: by a set or a scan, by [`Plant::wait`], by a byte on a bus ([`crate::SPI_BYTE_NS`]) or by
//! a delay of the processor ([`crate::PlantDelay`]). While the acquisition port runs, its scans happen on time whatever moves it.

mod passes;
mod timeline;

use std::cell::RefCell;
use std::rc::Rc;

use zerorate_core::units::{Axis, Celsius, DegreesPerSecond, Seconds, Taps, Volts};

use crate::ad7949::Ad7949;
use crate::chamber::{Chamber, SetPointOutside};
use crate::channel::{Channel, Input};
use crate::converter::Converter;
use crate::divider::Divider;
use crate::fault::{Fault, Faults};
use crate::parameters::PlantParameters;
use crate::port::Port;
use crate::potentiometer::Potentiometer;
use crate::supply::Supply;
use crate::thermal::Lag;
use crate::truth::{Sums, Truth};
use crate::vibration::Vibration;

/// What the acquisition port's next scan came to.
#[derive(Debug, Clone, PartialEq)]
pub enum Scanned {
    /// The port does not run.
    None,
    /// A scan was taken.
    Scan,
    /// The same, and a set was full with it.
    Set(Truth),
}

/// A plant that SPI handles, a delay and a bench share.
pub type SharedPlant = Rc<RefCell<Plant>>;

/// A wiper that has moved, and when.
#[derive(Debug, Clone, Copy)]
struct Moved {
    at_ns: u64,
    axis: Axis,
    tap: Taps,
}

/// The bench.
#[derive(Debug)]
pub struct Plant {
    parameters: PlantParameters,
    now_ns: u64,
    /// The instants to which slow things and the low-passes have been moved on, and of the last scan.
    slow_ns: u64,
    filtered_ns: u64,
    scanned_ns: u64,
    /// When the port scans next, while it runs.
    port_scan_ns: u64,
    /// When a block outside of the plant does, while it runs: [`Plant::block_starts`].
    block_scan_ns: Option<u64>,
    chamber: Chamber,
    board: Lag,
    channels: [Channel; 2],
    dividers: [Divider; 2],
    /// Where the wipers are electrically: behind the registers by the latency.
    taps: [Taps; 2],
    moved: Vec<Moved>,
    supply: Supply,
    input: Input,
    converter: Converter,
    /// The last scan: temperature X, zero-rate X, temperature Y, zero-rate Y.
    held: [u16; 4],
    /// What its zero-rate samples were without noise, X and Y, volts.
    noise_free_v: [f64; 2],
    faults: Faults,
    sums: Sums,
    takes: u32,
    pub(crate) potentiometer: Potentiometer,
    pub(crate) ad7949: Ad7949,
    pub(crate) port: Port,
}

impl Plant {
    /// A unit with the given parameters; all that is drawn, parts and noise, comes from the seed. The chamber has been at
    /// its start temperature and the board powered for long; the port does not run.
    #[must_use]
    pub fn new(parameters: PlantParameters, seed: u64) -> Self {
        let mut parameters = parameters;
        let air_c = parameters.chamber.start_c;
        let converter = Converter::new(parameters.converter.clone(), seed);
        let dividers = Axis::BOTH.map(|axis| Divider::new(&parameters.potentiometer, seed, axis));
        for (axis, divider) in parameters.axes.iter_mut().zip(&dividers) {
            // The centre is adjusted on each board with its own wiper at N0.
            let ideal_v = PlantParameters::ideal_wiper_v(parameters.potentiometer.supply_v, Taps::MIDDLE);
            axis.circuit.centre_v += axis.circuit.gain * (ideal_v - divider.volts(Taps::MIDDLE, crate::gyro::ROOM_C));
        }
        let channels = Axis::BOTH
            .map(|axis| Channel::new(parameters.axes[axis.index()].clone(), air_c, converter.noise_v(), seed, axis));
        let potentiometer = Potentiometer::new(&parameters.potentiometer);
        let mut plant = Self {
            now_ns: 0,
            slow_ns: 0,
            filtered_ns: 0,
            scanned_ns: 0,
            port_scan_ns: 0,
            block_scan_ns: None,
            chamber: Chamber::new(parameters.chamber.clone()),
            board: Lag { temperature_c: air_c },
            channels,
            dividers,
            taps: Axis::BOTH.map(|axis| potentiometer.wiper(axis)),
            moved: Vec::new(),
            supply: Supply::new(parameters.supply.clone(), seed),
            input: Input::Gyro,
            converter,
            held: [0; 4],
            noise_free_v: [0.0; 2],
            faults: Faults::default(),
            sums: Sums::default(),
            takes: 0,
            potentiometer,
            ad7949: Ad7949::default(),
            port: Port::new(),
            parameters,
        };
        plant.converter.warm(air_c);
        plant.refresh();
        plant.channels.iter_mut().for_each(Channel::settle);
        plant
    }

    /// The plant in the form that handles share.
    #[must_use]
    pub fn share(self) -> SharedPlant {
        Rc::new(RefCell::new(self))
    }

    /// What the plant is made of. A circuit's centre is the adjusted one.
    #[must_use]
    pub fn parameters(&self) -> &PlantParameters {
        &self.parameters
    }

    /// Time since the plant was made.
    #[must_use]
    #[allow(clippy::cast_precision_loss)] // 2^53 ns are a hundred days.
    pub fn time(&self) -> Seconds {
        Seconds(self.now_ns as f64 * 1e-9)
    }

    /// The potentiometer's registers and counters.
    #[must_use]
    pub fn potentiometer(&self) -> &Potentiometer {
        &self.potentiometer
    }

    /// The acquisition port's data ready line.
    #[must_use]
    pub fn data_ready(&self) -> bool {
        self.port.data_ready()
    }

    /// When the acquisition port scans next, nanoseconds on the plant's time; `None` while it does not.
    #[must_use]
    pub fn next_scan_ns(&self) -> Option<u64> {
        self.port_scans().then_some(self.port_scan_ns)
    }

    /// Lets time pass up to an instant in nanoseconds; none if it has gone by.
    pub fn pass_until_ns(&mut self, until_ns: u64) {
        self.pass_ns(until_ns.saturating_sub(self.now_ns));
    }

    /// Lets the acquisition port scan until a set is full, and tells that set's truth; `None` if the port does not run.
    pub fn run_set(&mut self) -> Option<Truth> {
        loop {
            match self.run_scan() {
                Scanned::Set(truth) => return Some(truth),
                Scanned::Scan => {}
                Scanned::None => return None,
            }
        }
    }

    /// Lets the acquisition port take its next scan: its line scan ready rises, and data ready where a set is full.
    pub fn run_scan(&mut self) -> Scanned {
        if !self.port_scans() {
            return Scanned::None;
        }
        match self.port_scan() {
            Some(truth) if !self.faults.lets_a_set_go_by() => Scanned::Set(truth),
            _ => Scanned::Scan,
        }
    }

    /// Goes to the next scan when the processor drives the A/D: its four inputs are held for [`crate::ConverterSpi`] until
    /// the scan after it. The scans are [`PlantParameters::direct_scan_period_us`] apart; the port must not run (if it
    /// does, this is the port's next scan).
    ///
    /// Noise is drawn at the scan, not at the conversion, so the port and a processor that drives the A/D itself see the
    /// very same samples from the same seed.
    pub fn next_scan(&mut self) {
        if self.port_scans() {
            _ = self.port_scan();
            return;
        }
        self.next_pass(1, 1);
    }

    /// Sets the time from scan to scan of a processor that drives the A/D, in place of its parameter.
    pub fn scan_every(&mut self, period_us: u32) {
        self.parameters.direct_scan_period_us = period_us;
    }

    /// The truth of all scans since the last take, when the processor drives the A/D; `None` if there were none.
    pub fn take_truth(&mut self) -> Option<Truth> {
        let number = self.takes;
        let truth = (self.sums.scans > 0).then(|| self.truth(number));
        self.takes += u32::from(truth.is_some());
        self.sums = Sums::default();
        truth
    }

    /// Lets time pass. With the port stopped, nothing is sampled and it is quick.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // A negative time is none, and 2^64 ns are centuries.
    pub fn wait(&mut self, time: Seconds) {
        self.pass_ns((time.0 * 1e9).round() as u64);
    }

    /// Takes the board's power away and gives it back: wipers load their non-volatile registers, port and A/D are as after
    /// reset, the gyros draw new turn-on offsets.
    pub fn power_cycle(&mut self) {
        self.potentiometer.power_cycle();
        self.reset_port();
        self.ad7949 = Ad7949::default();
        self.moved.clear();
        self.taps = Axis::BOTH.map(|axis| self.potentiometer.wiper(axis));
        self.channels.iter_mut().for_each(|channel| channel.gyro.power_up());
        self.refresh();
        self.channels.iter_mut().for_each(Channel::settle);
    }

    /// Starts the acquisition port anew, and nothing else: an upset of whatever runs it.
    pub fn reset_port(&mut self) {
        self.port = Port::new();
        self.sums = Sums::default();
    }

    /// Lets the analogue supply dip: the wipers load their non-volatile registers, and nothing else notices.
    pub fn brown_out(&mut self) {
        self.potentiometer.power_cycle();
        self.wipers_written();
    }

    /// Gives the chamber a new set point.
    ///
    /// # Errors
    /// The set point is outside the chamber's limits; the old one stays.
    pub fn chamber_set_point(&mut self, set_point: Celsius) -> Result<(), SetPointOutside> {
        self.chamber.set_point(set_point)
    }

    /// Where the chamber was sent.
    #[must_use]
    pub fn chamber_sent_to(&self) -> Celsius {
        Celsius(self.chamber.set_point_c())
    }

    /// The chamber's air.
    #[must_use]
    pub fn chamber_air(&self) -> Celsius {
        Celsius(self.chamber.air_c())
    }

    /// Puts the fine supply in place of both gyros.
    pub fn connect_supply(&mut self, volts: Volts) {
        self.input = Input::Supply(self.supply.output_v(volts.0), self.supply.noise_v());
        self.refresh();
    }

    /// Puts the gyros back.
    pub fn connect_gyro(&mut self) {
        self.input = Input::Gyro;
        self.refresh();
    }

    /// What a voltmeter shows at a gyro's output.
    #[must_use]
    pub fn rate_volts(&self, axis: Axis) -> Volts {
        Volts(self.channels[axis.index()].gyro_output_v())
    }

    /// Turns the platform at a constant rate about an axis.
    pub fn turn(&mut self, axis: Axis, rate: DegreesPerSecond) {
        self.channels[axis.index()].gyro.rate_dps = rate.0;
        self.refresh();
    }

    /// Has the platform vibrate about an axis from now on, beside its turning; `None` ends it.
    pub fn vibrate(&mut self, axis: Axis, vibration: Option<Vibration>) {
        self.channels[axis.index()].vibration = vibration;
    }

    /// Breaks something, until [`Self::clear_faults`].
    pub fn inject(&mut self, fault: Fault) {
        self.faults.push(fault);
        self.potentiometer.wear(self.faults.contains(Fault::WornMemory));
    }

    /// Mends everything.
    pub fn clear_faults(&mut self) {
        if self.faults.contains(Fault::NoScans) {
            self.port_scan_ns = self.now_ns + self.port.scan_period_ns();
        }
        self.faults.clear();
        self.potentiometer.wear(false);
    }

    /// What the last scan's zero-rate readings would have been without noise, flicker, random walk and the converter's steps, X
    /// and Y: drift, wiper and turning behind the low-pass. In counts.
    #[must_use]
    pub fn noise_free_counts(&self) -> [f64; 2] {
        self.noise_free_v.map(|volts| self.converter.stepless(volts))
    }

    /// By how much a tap moves the settled, noise-free reading against N0, at the present temperature and input. In
    /// counts.
    #[must_use]
    pub fn true_tap_counts(&self, axis: Axis, tap: Taps) -> f64 {
        self.steady_counts(axis, tap) - self.steady_counts(axis, Taps::MIDDLE)
    }
}
