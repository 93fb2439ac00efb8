//! The same application on this machine, about a plant of its own: what the image's groups are held against.
//!
//! As on `zerorate-bench`'s native device, a processor takes no time; buses and delays take theirs.

use anyhow::{Context, Result, ensure};
use zerorate_core::board::BoardNumbers;
use zerorate_core::record::{DeviceRecord, UnitSerial};
use zerorate_core::wire::frame::{self, Receiver};
use zerorate_core::wire::{Command, GroupReport, Health, Message, Request, SampleWindow, ScanReport, Upload};
use zerorate_device::acquisition::Timing;
use zerorate_device::application::{Application, Parts};
use zerorate_device::compensator::Memory;
use zerorate_device::console::Buffer;
use zerorate_device::port::PortAcquisition;
use zerorate_device::restart::{Kept, Started};
use zerorate_device::store::{FlashStore, RecordStore};
use zerorate_device::trim_part::Max5494Trim;
use zerorate_device::watchdog::NoWatchdog;
use zerorate_sim::{Flash, FlashPart, PlantDelay, PortSpi, PotentiometerSpi, Scanned, SharedPlant};

use crate::chip::board::SCAN_NS;
use crate::chip::flash::{RECORD_BYTES, SECTOR};
use crate::deployment::{deployment, encoded};
use crate::paper_record;

type Part = FlashPart<4096, 4>;
type Native = Application<
    PortAcquisition<PortSpi>,
    Max5494Trim<PotentiometerSpi, PlantDelay>,
    FlashStore<Part>,
    NoWatchdog,
    Kepts,
>;
type Kepts = std::rc::Rc<Kept>;

fn start(plant: &SharedPlant, flash: &Part) -> Result<Native> {
    let store = FlashStore::new(flash.clone(), 0..4 * 4096).ok().context("a flash that is too small")?;
    Ok(Application::start(Parts {
        acquisition: PortAcquisition::new(PortSpi::new(plant)),
        trim: Max5494Trim::new(PotentiometerSpi::new(plant), PlantDelay::new(plant)),
        store,
        watchdog: NoWatchdog,
        kept: Kepts::default(),
        started: Started::POWER,
        unit: UnitSerial::try_from(paper_record::UNIT).unwrap_or_default(),
        timing: Timing::PAPER,
        board: BoardNumbers::PAPER,
        health: Health::default,
        memory: Memory::new(),
        buffer: Buffer::new(),
    }))
}

/// What the chip's flash for records holds where a record's bytes, whatever they are, were stored in it.
///
/// # Errors
/// They do not find room.
pub fn stored(bytes: &[u8]) -> Result<Vec<u8>> {
    let flash = FlashPart::<SECTOR, 4>::new(Flash::erased(RECORD_BYTES / SECTOR));
    let range = 0..u32::try_from(RECORD_BYTES)?;
    let mut store = FlashStore::new(flash.clone(), range).ok().context("a flash that is too small")?;
    store.commit(bytes).ok().context("a record that finds no room")?;
    Ok(flash.with(|flash| flash.bytes().to_vec()))
}

/// A board that holds a record and whose port starts at an instant of the plant's time.
///
/// # Errors
/// The record was not taken.
pub fn at_work(plant: &SharedPlant, record: &DeviceRecord, started_ns: u64) -> Result<NativeBoard> {
    let flash = Part::new(Flash::erased(4));
    // On plants of its own: a board that starts writes the wipers, and sets the port up before it starts it.
    let elsewhere = || zerorate_sim::Plant::new(zerorate_sim::PlantParameters::paper(), 0).share();
    let mut writer = NativeBoard::with(elsewhere(), flash.clone())?;
    let requests = deployment(&encoded(record)?)?;
    writer.hear_all(&requests)?;
    ensure!(writer.said.len() == requests.len(), "the native board did not take the record");
    let starts = NativeBoard::with(elsewhere(), flash.clone())?.plant.borrow().next_scan_ns();
    let takes_ns = starts.context("the native board does not begin by itself")? - SCAN_NS;
    plant.borrow_mut().pass_until_ns(started_ns - takes_ns);
    NativeBoard::with(SharedPlant::clone(plant), flash)
}

/// The first `n` groups of such a board.
///
/// # Errors
/// The record was not taken.
pub fn first_groups(plant: &SharedPlant, record: &DeviceRecord, started_ns: u64, n: usize) -> Result<Vec<GroupReport>> {
    let mut board = at_work(plant, record, started_ns)?;
    board.hear_all(&[Request::SetStream { groups: true, samples: SampleWindow::NONE }])?;
    let mut groups = Vec::new();
    while groups.len() < n {
        board.set()?;
        groups.extend(std::mem::take(&mut board.said).into_iter().filter_map(|upload| match upload.message {
            Message::Group(report) => Some(report),
            _ => None,
        }));
    }
    Ok(groups)
}

/// A native board that a procedure works with.
pub struct NativeBoard {
    plant: SharedPlant,
    native: Native,
    receiver: Receiver,
    said: Vec<Upload>,
}

impl NativeBoard {
    /// A board about a plant, with what its flash holds.
    fn with(plant: SharedPlant, flash: Part) -> Result<Self> {
        let native = start(&plant, &flash)?;
        Ok(Self { plant, native, receiver: Receiver::new(), said: Vec::new() })
    }

    /// The next scan, corrected; the group that it closes is closed.
    ///
    /// # Errors
    /// None comes.
    pub fn scan(&mut self) -> Result<ScanReport> {
        let scanned = self.plant.borrow_mut().run_scan();
        let report = self.native.compensator.scan();
        if matches!(scanned, Scanned::Set(_)) {
            self.native.compensator.service();
            self.hear(&[]);
        }
        report.context("the native board has no scan")
    }

    /// Lets a set become full, and the board act on it.
    fn set(&mut self) -> Result<()> {
        self.plant.borrow_mut().run_set().context("the native board's acquisition stands still")?;
        self.native.compensator.service();
        self.hear(&[]);
        Ok(())
    }

    /// Hears requests one after the other.
    fn hear_all(&mut self, requests: &[Request]) -> Result<()> {
        for (sequence, request) in (1..).zip(requests) {
            let command = Command { sequence, at: None, request: request.clone() };
            self.hear(&frame::encode(&command).ok().context("a frame that cannot be")?);
        }
        Ok(())
    }

    fn hear(&mut self, bytes: &[u8]) {
        let Self { native, receiver, said, .. } = self;
        native.run(bytes.iter().copied(), &mut |sent: &[u8]| {
            said.extend(sent.iter().filter_map(|&byte| receiver.push::<Upload>(byte)?.ok()));
            true
        });
    }
}
