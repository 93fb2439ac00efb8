//! A chip on the simulated bench, and the host on its line: speaks the device's own protocol, in virtual time.

use anyhow::{Context, Result, bail, ensure};
use zerorate_core::record::DeviceRecord;
use zerorate_core::wire::frame::{self, Receiver};
use zerorate_core::wire::{
    Answer, Command, FaultCounts, GroupReport, Identity, Message, Request, SampleWindow, ScanReport, Stop, Upload,
};
use zerorate_sim::{Plant, SharedPlant};

use crate::chip::board::Board;
use crate::chip::flash::Flash;
use crate::chip::memory::Image;
use crate::chip::rcc::Reset;
use crate::chip::time::{MILLISECOND, SECOND, Ticks};
use crate::deployment::{deployment, encoded};
use crate::machine::Machine;

/// How long an answer may take: longer than a commit.
const PATIENCE: Ticks = 20 * SECOND;

/// After which a command is sent again, as `zerorate-bench` does it on a line in real time.
const ANSWER: Ticks = 500 * MILLISECOND;

/// A chip, its plant, and the host.
pub struct Bench {
    pub machine: Machine,
    pub plant: SharedPlant,
    receiver: Receiver,
    scans: Receiver,
    sequence: u16,
    /// The groups that have come and nobody has taken.
    groups: Vec<GroupReport>,
    /// Blocks of samples that have come.
    pub blocks: u32,
    /// Frames that could not be read since they were last looked at.
    pub damaged: u32,
    /// Commands that were sent again.
    pub sent_again: u32,
}

impl Bench {
    /// A chip whose power has just come, with what its flash for records holds.
    ///
    /// # Errors
    /// What Unicorn says.
    pub fn new(image: &Image, plant: Plant, records: Option<&[u8]>) -> Result<Self> {
        let plant = plant.share();
        let mut machine = Machine::new(image, Board::new(&plant))?;
        if let Some(records) = records {
            let flash = &mut machine.chip().flash;
            flash.records.copy_from_slice(records);
            flash.set_brown_out_level(0);
        }
        Ok(Self {
            machine,
            plant,
            receiver: Receiver::new(),
            scans: Receiver::new(),
            sequence: 0,
            groups: Vec::new(),
            blocks: 0,
            damaged: 0,
            sent_again: 0,
        })
    }

    /// Power goes, and comes again.
    ///
    /// # Errors
    /// What Unicorn says.
    pub fn power_cycle(&mut self) -> Result<()> {
        self.plant.borrow_mut().power_cycle();
        (self.receiver, self.scans) = (Receiver::new(), Receiver::new());
        self.machine.power_on()
    }

    pub fn now(&mut self) -> Ticks {
        self.machine.chip().clock
    }

    /// Lets time pass.
    ///
    /// # Errors
    /// What the machine cannot go on from.
    pub fn pass(&mut self, time: Ticks) -> Result<()> {
        let until = self.now() + time;
        self.machine.run_until(until)
    }

    /// A request as a frame, and the number that its answer has.
    fn command(&mut self, request: Request) -> Result<(u16, Vec<u8>)> {
        self.sequence += 1;
        let command = Command { sequence: self.sequence, at: None, request };
        Ok((self.sequence, frame::encode(&command).ok().context("a frame that cannot be")?.to_vec()))
    }

    /// Asks, and does not wait for the answer.
    ///
    /// # Errors
    /// There is no such frame.
    pub fn call(&mut self, request: Request) -> Result<()> {
        let (_, bytes) = self.command(request)?;
        self.send(&bytes);
        Ok(())
    }

    /// Asks, and waits for the answer.
    ///
    /// # Errors
    /// None comes.
    pub fn ask(&mut self, request: Request) -> Result<Answer> {
        let (sequence, bytes) = self.command(request)?;
        let until = self.now() + PATIENCE;
        while self.now() < until {
            let again = self.now() + ANSWER;
            self.send(&[0]);
            self.send(&bytes);
            while self.now() < again {
                if let Some((to, answer)) = self.hear(again)?
                    && to == sequence
                {
                    return Ok(answer);
                }
            }
            self.sent_again += 1;
        }
        bail!("no answer within {} s", PATIENCE / SECOND)
    }

    /// The host sends bytes.
    pub fn send(&mut self, bytes: &[u8]) {
        let chip = self.machine.chip();
        chip.usart.send(bytes, chip.clock);
    }

    /// Asks for something to be done.
    ///
    /// # Errors
    /// It was refused, or no answer came.
    pub fn order(&mut self, request: Request) -> Result<()> {
        match self.ask(request)? {
            Answer::Done => Ok(()),
            other => bail!("not done: {other:?}"),
        }
    }

    /// # Errors
    /// No answer, or another.
    pub fn identify(&mut self) -> Result<Identity> {
        match self.ask(Request::Identity)? {
            Answer::Identity(identity) => Ok(identity),
            other => bail!("an answer to another question: {other:?}"),
        }
    }

    /// # Errors
    /// No answer, or another.
    pub fn faults(&mut self) -> Result<FaultCounts> {
        match self.ask(Request::Faults)? {
            Answer::Faults(faults) => Ok(faults),
            other => bail!("an answer to another question: {other:?}"),
        }
    }

    /// # Errors
    /// No answer, or another.
    pub fn stop(&mut self) -> Result<Option<Stop>> {
        match self.ask(Request::Stop)? {
            Answer::Stop(stop) => Ok(stop),
            other => bail!("an answer to another question: {other:?}"),
        }
    }

    /// Writes a record and has it committed.
    ///
    /// # Errors
    /// It was refused, or no answer came.
    pub fn deploy(&mut self, record: &DeviceRecord) -> Result<()> {
        let commit = self.write(&encoded(record)?)?;
        self.order(commit)
    }

    /// Writes a record's bytes to the board's buffer; what commits them.
    fn write(&mut self, bytes: &[u8]) -> Result<Request> {
        let mut requests = deployment(bytes)?;
        let commit = requests.pop().context("a record without a commit")?;
        requests.into_iter().try_for_each(|write| self.order(write))?;
        Ok(commit)
    }

    /// Has a record committed, up to where something holds of the flash.
    ///
    /// # Errors
    /// It does not come to hold.
    pub fn deploy_until(&mut self, record: &DeviceRecord, holds: impl Fn(&Flash) -> bool) -> Result<()> {
        let request = self.write(&encoded(record)?)?;
        self.call(request)?;
        let until = self.now() + PATIENCE;
        ensure!(self.machine.run(until, |machine| holds(&machine.chip().flash))?, "the commit went another way");
        Ok(())
    }

    /// Writes a record's bytes, whatever they are; the answer to the commit.
    ///
    /// # Errors
    /// No answer came.
    pub fn offer(&mut self, bytes: &[u8]) -> Result<Answer> {
        let commit = self.write(bytes)?;
        self.ask(commit)
    }

    /// Asks for groups.
    ///
    /// # Errors
    /// No answer came.
    pub fn stream(&mut self) -> Result<()> {
        self.order(Request::SetStream { groups: true, samples: SampleWindow::NONE })
    }

    /// The next group, waited for so long.
    ///
    /// # Errors
    /// None came.
    pub fn group_within(&mut self, time: Ticks) -> Result<GroupReport> {
        let until = self.now() + time;
        while self.groups.is_empty() {
            ensure!(self.now() < until, "no group within {} ms", time / MILLISECOND);
            self.hear(until)?;
        }
        Ok(self.groups.remove(0))
    }

    /// The next groups.
    ///
    /// # Errors
    /// One did not come within four seconds.
    pub fn groups(&mut self, n: usize) -> Result<Vec<GroupReport>> {
        (0..n).map(|_| self.group_within(4 * SECOND)).collect()
    }

    /// The next frame on the second line, waited for up to an instant, and when its last byte came.
    ///
    /// # Errors
    /// One came that cannot be read.
    pub fn scan(&mut self, until: Ticks) -> Result<Option<(ScanReport, Ticks)>> {
        while self.machine.run(until, |machine| !machine.chip().scan_line.heard.is_empty())? {
            let line = &mut self.machine.chip().scan_line;
            let (mut bytes, at) = (std::mem::take(&mut line.heard).into_iter(), line.heard_at);
            while let Some(byte) = bytes.next() {
                match self.scans.push::<ScanReport>(byte) {
                    Some(Ok(report)) => {
                        self.machine.chip().scan_line.heard = bytes.collect();
                        return Ok(Some((report, at)));
                    }
                    Some(Err(error)) => bail!("a scan's frame: {error:?}"),
                    None => {}
                }
            }
        }
        Ok(None)
    }

    /// Forgets the groups that have come.
    pub fn forget_groups(&mut self) {
        self.groups.clear();
    }

    /// Runs until the host has bytes, and takes them in; an answer among them.
    fn hear(&mut self, until: Ticks) -> Result<Option<(u16, Answer)>> {
        self.machine.run(until, |machine| !machine.chip().usart.heard.is_empty())?;
        let mut bytes = std::mem::take(&mut self.machine.chip().usart.heard).into_iter();
        while let Some(byte) = bytes.next() {
            match self.receiver.push::<Upload>(byte) {
                Some(Ok(Upload { message: Message::Answer { to, answer, .. }, .. })) => {
                    self.machine.chip().usart.heard = bytes.collect();
                    return Ok(Some((to, answer)));
                }
                Some(Ok(Upload { message: Message::Group(report), .. })) => self.groups.push(report),
                Some(Ok(Upload { message: Message::Samples(_), .. })) => self.blocks += 1,
                Some(Err(_)) => self.damaged += 1,
                None => {}
            }
        }
        Ok(None)
    }

    /// How often a kind of reset has come since power came to the bench.
    pub fn resets(&self, kind: Reset) -> usize {
        self.machine.resets.iter().filter(|&&reset| reset == kind).count()
    }

    /// Fails if the program did what the chip would not have taken, or what is not modelled.
    ///
    /// # Errors
    /// It did.
    pub fn nothing_wrong(&mut self) -> Result<()> {
        let wrong = &self.machine.chip().wrong;
        ensure!(wrong.is_empty(), "the program: {}", wrong.join("; "));
        Ok(())
    }
}
