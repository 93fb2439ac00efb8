//! The same application on this machine, about a plant of its own: what the image's groups are held against.
//!
//! As on `zerorate-bench`'s native device, time passes only while nobody has anything to do, and buses take none.

use anyhow::{Context, Result, ensure};
use zerorate_core::board::BoardNumbers;
use zerorate_core::record::{DeviceRecord, UnitSerial};
use zerorate_core::wire::frame::{self, Receiver};
use zerorate_core::wire::{Command, GroupReport, Health, Message, Request, SampleWindow, ScanReport, Upload};
use zerorate_device::acquisition::Timing;
use zerorate_device::application::{Application, Parts};
use zerorate_device::port::PortAcquisition;
use zerorate_device::restart::{Kept, Started};
use zerorate_device::store::FlashStore;
use zerorate_device::trim_part::Max5494Trim;
use zerorate_device::watchdog::NoWatchdog;
use zerorate_sim::{Flash, FlashPart, PlantDelay, PortSpi, PotentiometerSpi, Scanned, SharedPlant};

use crate::deployment::{deployment, encoded};
use crate::lock_step::LockStep;

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
        unit: UnitSerial::default(),
        timing: Timing::IN_USE,
        board: BoardNumbers::PAPER,
        health: Health::default,
    }))
}

/// A board that holds a record and whose acquisition begins at the plant's present time.
///
/// # Errors
/// The record was not taken.
pub fn at_work(plant: &SharedPlant, record: &DeviceRecord) -> Result<NativeBoard> {
    let flash = Part::new(Flash::erased(4));
    // On a plant of its own: the wipers are written when a board starts.
    let elsewhere = zerorate_sim::Plant::new(zerorate_sim::PlantParameters::paper(), 0).share();
    let mut writer = NativeBoard::with(elsewhere, flash.clone())?;
    let requests = deployment(&encoded(record)?)?;
    writer.hear_all(&requests)?;
    ensure!(writer.said().len() == requests.len(), "the native board did not take the record");
    NativeBoard::with(SharedPlant::clone(plant), flash)
}

/// The first `n` groups of such a board.
///
/// # Errors
/// The record was not taken.
pub fn first_groups(plant: &SharedPlant, record: &DeviceRecord, n: usize) -> Result<Vec<GroupReport>> {
    let mut board = at_work(plant, record)?;
    board.hear_all(&[Request::SetStream { groups: true, samples: SampleWindow::NONE }])?;
    let mut groups = Vec::new();
    while groups.len() < n {
        board.set()?;
        groups.extend(board.said().into_iter().filter_map(|upload| match upload.message {
            Message::Group(report) => Some(report),
            _ => None,
        }));
    }
    Ok(groups)
}

/// A native board that a procedure works with.
pub struct NativeBoard {
    plant: SharedPlant,
    flash: Part,
    native: Native,
    receiver: Receiver,
    said: Vec<Upload>,
}

impl NativeBoard {
    /// A blank board about a plant.
    ///
    /// # Errors
    /// There is none.
    pub fn new(plant: SharedPlant) -> Result<Self> {
        Self::with(plant, Part::new(Flash::erased(4)))
    }

    /// A board about a plant, with what its flash holds.
    fn with(plant: SharedPlant, flash: Part) -> Result<Self> {
        let native = start(&plant, &flash)?;
        Ok(Self { plant, flash, native, receiver: Receiver::new(), said: Vec::new() })
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

impl LockStep for NativeBoard {
    fn plant(&self) -> SharedPlant {
        SharedPlant::clone(&self.plant)
    }

    fn send(&mut self, frame: &[u8]) -> Result<()> {
        self.hear(frame);
        Ok(())
    }

    fn set(&mut self) -> Result<()> {
        self.plant.borrow_mut().run_set().context("the native board's acquisition stands still")?;
        self.native.compensator.service();
        self.hear(&[]);
        Ok(())
    }

    fn power_cycle(&mut self) -> Result<()> {
        self.plant.borrow_mut().power_cycle();
        self.native = start(&self.plant, &self.flash)?;
        self.receiver = Receiver::new();
        Ok(())
    }

    fn said(&mut self) -> Vec<Upload> {
        std::mem::take(&mut self.said)
    }
}
