//! A calibration in short, by the commands that `calibrate` gives, on the image and on the native board: the trim experiment on
//! the supply, the cold end and the ramp, the record, the ramp again in each mode, power off and on.

use anyhow::{Context, Result, ensure};
use zerorate_core::compensate::Mode;
use zerorate_core::units::{Axis, Celsius, Seconds, Taps, Volts};
use zerorate_core::wire::frame;
use zerorate_core::wire::{Command, Message, Request, SampleWindow, Upload};

use super::{Given, paper};
use crate::deployment::{deployment, encoded};
use crate::lock_step::{ChipBoard, LockStep};
use crate::native::NativeBoard;

const SUPPLIES_V: [f64; 3] = [2.45, 2.5, 2.55];
const TAPS: [u16; 4] = [511, 500, 522, 512];
const RAMP_GROUPS: usize = 150;

/// A procedure on a board.
struct Procedure<'a> {
    board: &'a mut dyn LockStep,
    sequence: u16,
    said: Vec<Upload>,
}

impl Procedure<'_> {
    fn order(&mut self, request: Request) -> Result<()> {
        self.sequence += 1;
        let command = Command { sequence: self.sequence, at: None, request };
        let bytes = frame::encode(&command).ok().context("a frame that cannot be")?;
        self.board.send(&bytes)?;
        self.said.extend(self.board.said());
        Ok(())
    }

    fn groups(&mut self, n: usize) -> Result<()> {
        for _ in 0..n {
            self.board.set()?;
            self.said.extend(self.board.said());
        }
        Ok(())
    }

    fn trim_experiment(&mut self) -> Result<()> {
        self.order(Request::SetStream { groups: true, samples: SampleWindow::ALL })?;
        self.order(Request::SetAcquisition { run: true })?;
        for volts in SUPPLIES_V {
            self.board.plant().borrow_mut().connect_supply(Volts(volts));
            for tap in TAPS.into_iter().filter_map(Taps::new) {
                for axis in Axis::BOTH {
                    self.order(Request::SetTap { axis, tap })?;
                }
                self.groups(2)?;
            }
        }
        self.board.plant().borrow_mut().connect_gyro();
        // In the middle of the acquisition, too: its scans go on while the part stores.
        self.order(Request::StorePowerUpTap)?;
        self.groups(1)?;
        self.order(Request::SetAcquisition { run: false })
    }

    /// An hour at the cold end, then a part of the ramp.
    fn ramp(&mut self) -> Result<()> {
        self.board.plant().borrow_mut().chamber_set_point(Celsius(-40.0))?;
        self.board.plant().borrow_mut().wait(Seconds(3600.0));
        self.order(Request::SetStream { groups: true, samples: SampleWindow::NONE })?;
        self.order(Request::SetAcquisition { run: true })?;
        self.board.plant().borrow_mut().chamber_set_point(Celsius(60.0))?;
        self.groups(RAMP_GROUPS)?;
        self.order(Request::SetAcquisition { run: false })
    }

    fn all(&mut self, record: &[Request]) -> Result<()> {
        self.order(Request::Identity)?;
        self.order(Request::StorePowerUpTap)?;
        self.trim_experiment()?;
        self.ramp()?;
        record.iter().try_for_each(|request| self.order(request.clone()))?;
        for mode in [Mode::Trim, Mode::Digital, Mode::Hybrid] {
            for axis in Axis::BOTH {
                self.order(Request::SetMode { axis, mode })?;
            }
            self.ramp()?;
        }
        self.order(Request::Faults)?;
        self.board.power_cycle()?;
        self.order(Request::Identity)?;
        self.order(Request::SetStream { groups: true, samples: SampleWindow::NONE })?;
        self.groups(20)?;
        self.order(Request::Faults)
    }
}

fn run(board: &mut dyn LockStep, record: &[Request]) -> Result<Vec<Upload>> {
    let mut procedure = Procedure { board, sequence: 0, said: Vec::new() };
    procedure.all(record)?;
    Ok(procedure.said)
}

/// All that both boards say in it.
pub fn in_short(given: &Given) -> Result<String> {
    let record = deployment(&encoded(&given.record)?)?;
    let native = run(&mut NativeBoard::new(paper().share())?, &record)?;
    let mut chip = ChipBoard::new(&given.image, paper())?;
    let image = run(&mut chip, &record)?;
    ensure!(chip.wrong().is_empty(), "the program: {}", chip.wrong().join("; "));
    if let Some((image, native)) = image.iter().zip(&native).find(|(image, native)| image != native) {
        anyhow::bail!("image {image:?}\n    native {native:?}");
    }
    ensure!(
        image.len() == native.len(),
        "{} messages of the image's, {} of the native board's",
        image.len(),
        native.len()
    );
    let (mut groups, mut samples, mut moves) = (0, 0, 0);
    for upload in &image {
        match &upload.message {
            Message::Group(report) => {
                groups += 1;
                moves += report.axes.iter().filter(|axis| axis.moved_to.is_some()).count();
            }
            Message::Samples(block) => samples += block.samples.len(),
            Message::Answer { .. } => {}
        }
    }
    ensure!(
        groups == SUPPLIES_V.len() * TAPS.len() * 2 + 1 + 4 * RAMP_GROUPS + 20 && moves > 10,
        "{groups} groups, {moves} moves"
    );
    Ok(format!(
        "{} messages are the same bit for bit: {groups} groups with their sums and taps ({moves} moves), {samples} samples",
        image.len()
    ))
}
