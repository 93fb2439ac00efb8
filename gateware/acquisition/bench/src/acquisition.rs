//! The acquisition gateware itself in the simulated bench: the verilated block between the plant's A/D inputs and the
//! device's port.
//!
//! Its clock is simulated edge by edge, so it scans as fast as its SPI port lets it ([`scan_period_us`]), while the plant
//! goes on with every scan by the period that the set-up asks for, and with every byte on the bus by its clock's time: the
//! plant's time is the plant's. What the device reads does not depend on the block's, as long as a set is read before the next
//! scan begins.
//!
//! Whole sets are read with their samples, so a group costs as the square of its length: 0.2 s of a processor's time at
//! 50 scans, 10 s at 500. A shortened test has few and short groups, further apart.

use core::convert::Infallible;
use std::cell::{Cell, RefCell};
use std::rc::Rc;

use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use zerorate_bench::simulated::OnPlant;
use zerorate_device::acquisition::{Acquisition, NumberedScan, Set, Timing};
use zerorate_device::port::{PortAcquisition, PortError};
use zerorate_gateware::{Bench, Port, Scale, SharedPort, Timing as Clocking};
use zerorate_sim::{SPI_BYTE_NS, Scanned, SharedPlant, Truth};

/// Scan to scan at the block, for sets of so many scans: a scan takes 38 us, reading status and head at 10 MHz 58 us, the
/// head once more with the scans 53 us, a scan's samples 6.4 us, and starting anew 30 us. So a tap that follows from a
/// set, or one that the host then asks for, is there before the next scan. With several passes a scan it is so from pass to pass.
#[must_use]
pub fn scan_period_us(set_length: u16, oversampling: u8) -> u32 {
    (190 + u32::from(set_length) * 13 / 2) * u32::from(oversampling)
}

/// For the phases in which the clocks of block and processor meet. What is read does not depend on it.
const SEED: u32 = 1;

/// The block's port as the board's bus reaches it: its bytes take their time on the plant.
struct BoardBus {
    block: SharedPort,
    plant: SharedPlant,
}

/// A write to CONTROL begins so, and its last byte has RUN.
const CONTROL_WRITTEN: [u8; 5] = [0x82, 0, 0, 0, 0];
const RUN: u8 = 1;

impl ErrorType for BoardBus {
    type Error = Infallible;
}

impl SpiDevice for BoardBus {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        self.block.transaction(operations)?;
        let bytes: usize = operations.iter().map(length).sum();
        let plant = &mut *self.plant.borrow_mut();
        plant.pass_ns(bytes as u64 * SPI_BYTE_NS);
        if let Some(Operation::Write(written)) = operations.first()
            && let Some([control, ..]) = written.strip_prefix(&CONTROL_WRITTEN)
        {
            if control & RUN == 0 { plant.block_stops() } else { plant.block_starts() }
        }
        Ok(())
    }
}

/// Bytes of an operation on the bus.
fn length(operation: &Operation<'_, u8>) -> usize {
    match operation {
        Operation::Read(words) | Operation::TransferInPlace(words) => words.len(),
        Operation::Write(words) => words.len(),
        Operation::Transfer(read, write) => read.len().max(write.len()),
        Operation::DelayNs(_) => 0,
    }
}

/// The device's port with the verilated block at its other end.
pub struct GatewareAcquisition {
    port: PortAcquisition<BoardBus>,
    board: SharedPort,
    /// Scans a set, while it runs.
    running: Option<Timing>,
    /// Sets since it was started.
    sets: u32,
    /// The pass that the block is at, and of how many a scan.
    pass: Rc<Cell<(u32, u32)>>,
}

impl Acquisition for GatewareAcquisition {
    type Error = PortError<Infallible>;

    fn start(&mut self, timing: Timing, first: u16) -> Result<(), Self::Error> {
        self.pass.set((0, u32::from(timing.oversampling)));
        let scan_period_us = scan_period_us(timing.set_length, timing.oversampling);
        self.port.start(Timing { scan_period_us, ..timing }, first)?;
        self.running = Some(timing);
        self.sets = 0;
        Ok(())
    }

    fn stop(&mut self) -> Result<(), Self::Error> {
        self.running = None;
        self.port.stop()
    }

    fn read_set(&mut self, set: &mut Set, then_scans: bool) -> Result<bool, Self::Error> {
        self.port.read_set(set, then_scans)
    }

    fn read_scans(&mut self, set: &mut Set) -> Result<(), Self::Error> {
        self.port.read_scans(set)
    }

    fn latest_scan(&mut self) -> Result<Option<NumberedScan>, Self::Error> {
        self.port.latest_scan()
    }
}

impl OnPlant for GatewareAcquisition {
    fn connect(plant: &SharedPlant) -> Self {
        let inputs = Rc::clone(plant);
        let mut board = Bench::new(Scale::Board, SEED, move |channel| inputs.borrow().held()[channel]);
        let moving = Rc::clone(plant);
        let pass = Rc::new(Cell::new((0, 1)));
        let counted = Rc::clone(&pass);
        board.at_each_pass(move || {
            let (before, of) = counted.get();
            let number = before % of + 1;
            counted.set((number, of));
            moving.borrow_mut().next_pass(number, of);
        });
        let board = SharedPort(Rc::new(RefCell::new(Port::new(board, Clocking::FASTEST, u64::from(SEED)))));
        let bus = BoardBus { block: board.clone(), plant: Rc::clone(plant) };
        Self { port: PortAcquisition::new(bus), board, running: None, sets: 0, pass }
    }

    /// A whole set: within one the block's clock goes on by itself.
    fn run_scan(&mut self, plant: &SharedPlant) -> Scanned {
        self.wait_for_set(plant).map_or(Scanned::None, Scanned::Set)
    }
}

impl GatewareAcquisition {
    fn wait_for_set(&mut self, plant: &SharedPlant) -> Option<Truth> {
        // The set, and the period before its first scan.
        let Timing { set_length, oversampling, .. } = self.running?;
        let at_most_us = (u64::from(set_length) + 2) * u64::from(scan_period_us(set_length, oversampling));
        let is_ready = self.board.0.borrow_mut().wait_for_data_ready(at_most_us);
        let truth = is_ready.then(|| plant.borrow_mut().take_truth()).flatten()?;
        // The plant counts on over a start, the port begins again.
        self.sets += 1;
        Some(Truth { set: self.sets - 1, ..truth })
    }
}
