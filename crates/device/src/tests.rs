//! Parts that behave, and can fail, for the tests of compensator and console.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;
use std::vec::Vec;

use zerorate_core::board::BoardNumbers;
use zerorate_core::compensate::{EdgeTable, LowPass, Mode};
use zerorate_core::drift::{Drift, Polynomial, Scale, Shape, ValidRange};
use zerorate_core::group::GroupSums;
use zerorate_core::record::{AxisModel, DeviceRecord, UnitSerial};
use zerorate_core::trim::{Trim, TrimLine};
use zerorate_core::units::{Axis, Counts, GroupNumber, Taps, TemperatureScale};
use zerorate_core::wire::FaultCounts;

use crate::acquisition::{Acquisition, NumberedScan, Set, Timing};
use crate::compensator::Status;
use crate::store::{RecordStore, StoreFailed, Stored};
use crate::trim_part::TrimPart;

/// Sets that wait to be read, from an acquisition that may not be there.
#[derive(Clone, Default)]
pub struct Sets {
    pub waiting: Rc<RefCell<VecDeque<Set>>>,
    pub missing: Rc<Cell<bool>>,
    /// So many sets come bent; what is read to its end is gone then, too.
    pub bent: Rc<Cell<u32>>,
    /// Sets are read, and are not let go: another one comes in their place first.
    pub overtaking: Rc<RefCell<Option<Set>>>,
    /// Sums come, and scans do not.
    pub scans_missing: Rc<Cell<bool>>,
    /// The scan that was taken last.
    pub latest: Rc<Cell<Option<NumberedScan>>>,
    /// Starts, taken or not.
    pub starts: Rc<Cell<u32>>,
    /// Scans of the first set, as the last start had it.
    pub first: Rc<Cell<u16>>,
}

impl Sets {
    /// A set of equal samples on both axes.
    pub fn push(&self, number: u32, temperature: u16, zro: u16) {
        self.waiting.borrow_mut().push_back(Self::set(number, temperature, zro));
    }

    /// Such a set.
    pub fn set(number: u32, temperature: u16, zro: u16) -> Set {
        let mut sums = GroupSums::default();
        (0..500).for_each(|_| sums.push(temperature, zro));
        let scans = (0..500).map(|_| [temperature, zro, temperature, zro]).collect();
        Set { number, lost: 0, sums: [sums; 2], scans }
    }
}

impl Acquisition for Sets {
    type Error = ();

    fn start(&mut self, _: Timing, first: u16) -> Result<(), ()> {
        self.first.set(first);
        self.starts.set(self.starts.get() + 1);
        self.latest.set(None);
        if self.missing.get() { Err(()) } else { Ok(()) }
    }

    fn stop(&mut self) -> Result<(), ()> {
        Ok(())
    }

    fn read_set(&mut self, set: &mut Set, then_scans: bool) -> Result<bool, ()> {
        let mut waiting = self.waiting.borrow_mut();
        if !then_scans && let Some(another) = self.overtaking.take() {
            *waiting = VecDeque::from([another]);
        }
        let Some(first) = waiting.front().cloned() else { return Ok(false) };
        if !then_scans {
            waiting.pop_front();
        }
        if self.bent.get() > 0 {
            self.bent.set(self.bent.get() - 1);
            return Err(());
        }
        *set = Set { scans: Default::default(), ..first };
        Ok(true)
    }

    fn read_scans(&mut self, set: &mut Set) -> Result<(), ()> {
        if self.scans_missing.get() {
            return Err(());
        }
        set.scans = self.waiting.borrow_mut().pop_front().ok_or(())?.scans;
        Ok(())
    }

    fn latest_scan(&mut self) -> Result<Option<NumberedScan>, ()> {
        if self.missing.get() { Err(()) } else { Ok(self.latest.get()) }
    }
}

/// A trim part that remembers what it was told, and can be unplugged.
#[derive(Clone, Default)]
pub struct Part {
    pub writes: Rc<RefCell<Vec<(Axis, u16)>>>,
    pub stores: Rc<Cell<u32>>,
    pub recalls: Rc<Cell<u32>>,
    pub unplugged: Rc<Cell<bool>>,
}

impl TrimPart for Part {
    type Error = ();

    fn write(&mut self, axis: Axis, tap: Taps) -> Result<(), ()> {
        if self.unplugged.get() {
            return Err(());
        }
        self.writes.borrow_mut().push((axis, tap.get()));
        Ok(())
    }

    fn store_power_up(&mut self) -> Result<(), ()> {
        self.stores.set(self.stores.get() + 1);
        if self.unplugged.get() { Err(()) } else { Ok(()) }
    }

    fn recall_power_up(&mut self) -> Result<(), ()> {
        self.recalls.set(self.recalls.get() + 1);
        if self.unplugged.get() { Err(()) } else { Ok(()) }
    }
}

/// A store in memory: lost with the power.
#[derive(Debug, Clone, Default)]
pub struct MemoryStore {
    bytes: Vec<u8>,
}

impl RecordStore for MemoryStore {
    fn stored(&self) -> Stored {
        match u16::try_from(self.bytes.len()) {
            Ok(0) | Err(_) => Stored::Blank,
            Ok(length) => Stored::Whole(length),
        }
    }

    fn read(&mut self, offset: usize, into: &mut [u8]) -> Result<usize, StoreFailed> {
        let rest = self.bytes.get(offset..).unwrap_or(&[]);
        let n = rest.len().min(into.len());
        into[..n].copy_from_slice(&rest[..n]);
        Ok(n)
    }

    fn commit(&mut self, record: &[u8]) -> Result<(), StoreFailed> {
        self.bytes = record.to_vec();
        Ok(())
    }
}

/// A compensator that stands still.
pub fn idle() -> Status {
    Status {
        group: GroupNumber(0),
        running: false,
        sets: 0,
        taps: [Taps::MIDDLE; 2],
        modes: [Mode::Off; 2],
        faults: FaultCounts::default(),
    }
}

/// Eq. (1), X, on both axes.
pub fn record(unit: &str) -> DeviceRecord {
    record_with(unit, LowPass::NONE)
}

/// The same behind a low-pass.
pub fn record_with(unit: &str, low_pass: LowPass) -> DeviceRecord {
    let scale = Scale::spanning(8500.0, 11_900.0).unwrap();
    let curve = Polynomial::from_raw_coefficients(scale, &[13_435.7, -0.894_782, 0.375_298e-4]).unwrap();
    let mut axis = AxisModel {
        drift: Drift { shape: Shape::Polynomial(curve), valid: ValidRange::new(8500.0, 11_900.0).unwrap() },
        trim: Trim { line: TrimLine::new(-0.032, 0.0, Counts(8200.0), Taps::MIDDLE).unwrap(), measured: None },
        dead_band: 0.05,
        low_pass,
        start_up_mode: Mode::Hybrid,
        edges: None,
        history: None,
    };
    axis.edges = Some(EdgeTable::solve(&axis.static_law(TemperatureScale::QUARTER_COUNTS)).unwrap());
    let unit = UnitSerial::try_from(unit).unwrap();
    DeviceRecord::new(unit, TemperatureScale::QUARTER_COUNTS, BoardNumbers::PAPER, &[axis.clone(), axis]).unwrap()
}
