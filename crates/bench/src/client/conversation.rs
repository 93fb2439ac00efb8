//! Frames out and in: what is not answered is sent again, what is lost is counted and named, silence is an error.

use std::collections::VecDeque;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::ops::RangeInclusive;
use std::time::{Duration, Instant};

use zerorate_core::units::{Axis, GroupNumber};
use zerorate_core::wire::frame::{self, FrameError, Receiver};
use zerorate_core::wire::{Answer, Command, GroupReport, Message, Request, Sample, SampleBlock, SampleWindow, Upload};

use super::{ClientError, Group, LineCounts};
use crate::link::{Link, LinkError};

/// A command that changes nothing between groups is answered at once: at 115 200 baud the longest frame takes 45 ms, a
/// sector's erasure before a commit one second and a half at most.
const ANSWER: Duration = Duration::from_millis(500);
/// How often a command is sent before it is given up: with [`ANSWER`], four seconds.
const TRIES: u32 = 8;
/// Silence after which the device is asked whether it is still there.
const QUIET: Duration = Duration::from_secs(1);
/// Silence, that question included, after which it is not.
const DEAD: Duration = Duration::from_millis(4500);
/// How often the clock is looked at while bytes come and no message is among them.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Whoever has not listened for so long begins to wait anew.
const AWAY: Duration = Duration::from_secs(1);
/// Groups that may be late before their absence is an error, though the device answers.
const LATE_GROUPS: u32 = 3;

/// Both directions of a line.
pub(super) struct Conversation {
    link: Box<dyn Link>,
    receiver: Receiver,
    bytes: Vec<u8>,
    sequence: u16,
    next_upload: Option<u32>,
    groups: VecDeque<Group>,
    samples: Samples,
    pub(super) counts: LineCounts,
    pub(super) lost_groups: Vec<RangeInclusive<u32>>,
    next_group: Option<u32>,
    /// How long a group takes, as the device says.
    pub(super) group_period: Duration,
    pub(super) acquiring: bool,
    /// Whether the device has answered since the line was opened: before, what cannot be read is no loss.
    pub(super) open: bool,
    unknown_frames: u32,
    restarted: bool,
    heard: Instant,
    asked: Instant,
    /// Since when somebody listens without a break, and when last.
    listening_since: Instant,
    listened: Instant,
}

impl Conversation {
    pub(super) fn new(link: Box<dyn Link>) -> Self {
        let now = link.now();
        Self {
            link,
            receiver: Receiver::new(),
            bytes: Vec::new(),
            // A device remembers the answers to the last numbers: another program's must not be taken for ours.
            #[allow(clippy::cast_possible_truncation)]
            sequence: RandomState::new().build_hasher().finish() as u16,
            next_upload: None,
            groups: VecDeque::new(),
            samples: Samples::default(),
            counts: LineCounts::default(),
            lost_groups: Vec::new(),
            next_group: None,
            group_period: Duration::from_millis(1500),
            acquiring: false,
            open: false,
            unknown_frames: 0,
            restarted: false,
            heard: now,
            asked: now,
            listening_since: now,
            listened: now,
        }
    }

    pub(super) fn in_real_time(&self) -> bool {
        self.link.in_real_time()
    }

    /// The time on the line's clock.
    pub(super) fn now(&self) -> Instant {
        self.link.now()
    }

    fn since(&self, moment: Instant) -> Duration {
        self.now().saturating_duration_since(moment)
    }

    /// Another line to the same device; what was under way is gone.
    pub(super) fn replace_link(&mut self, link: Box<dyn Link>) {
        self.link = link;
        self.forget();
    }

    /// What was under way is gone, and the device counts from 0.
    pub(super) fn forget(&mut self) {
        self.receiver = Receiver::new();
        self.bytes.clear();
        self.next_upload = None;
        self.groups.clear();
        self.samples.clear();
        self.next_group = None;
        self.acquiring = false;
        self.open = false;
        self.restarted = false;
    }

    /// Hands were shaken. What was on its way before them was said to somebody else: a board goes on alone.
    pub(super) fn opened(&mut self, group_period: Duration, acquiring: bool) {
        self.discard_groups();
        self.lost_groups.clear();
        self.next_group = None;
        (self.group_period, self.acquiring) = (group_period, acquiring);
    }

    /// Sends a command and waits for its answer; groups that come meanwhile are kept.
    pub(super) fn ask(
        &mut self,
        request: Request,
        at: Option<GroupNumber>,
    ) -> Result<(GroupNumber, Answer), ClientError> {
        let sent = self.send(request, at)?;
        self.answer_to(&sent)
    }

    /// Sends a command.
    pub(super) fn send(&mut self, request: Request, at: Option<GroupNumber>) -> Result<Sent, ClientError> {
        self.sequence = self.sequence.wrapping_add(1);
        match request {
            Request::Identity => (self.next_upload, self.restarted) = (None, false),
            Request::SetAcquisition { run } => (self.next_group, self.acquiring) = (run.then_some(0), run),
            Request::SetStream { samples, .. } => {
                self.samples.window = samples;
                if self.acquiring {
                    self.next_group = None;
                }
            }
            _ => {}
        }
        let retry = self.patience(&request, at);
        let command = Command { sequence: self.sequence, at, request };
        let frame = frame::encode(&command).map_err(|_| ClientError::Confused)?;
        self.link.send(&frame)?;
        Ok(Sent { sequence: self.sequence, frame: frame.to_vec(), retry, name: name(&command.request) })
    }

    /// How long an answer may take.
    fn patience(&self, request: &Request, at: Option<GroupNumber>) -> Duration {
        let waits = matches!(
            request,
            Request::SetMode { .. } | Request::SetTap { .. } | Request::StorePowerUpTap | Request::RecallPowerUpTap
        );
        if !waits || !self.acquiring {
            return ANSWER;
        }
        let from = self.next_group.unwrap_or(0);
        ANSWER + self.group_period * (1 + at.map_or(0, |at| at.0.saturating_sub(from)))
    }

    /// Waits for the answer to a command, which is sent again with the same number when none comes.
    pub(super) fn answer_to(&mut self, sent: &Sent) -> Result<(GroupNumber, Answer), ClientError> {
        let began = self.now();
        let mut last_sent = began;
        let mut tries = 1;
        loop {
            match self.next_answer()? {
                Some((to, group, answer)) if to == sent.sequence => {
                    self.open = true;
                    return Ok((group, answer));
                }
                _ if !self.in_real_time() => continue,
                _ => {}
            }
            self.stay_patient(Some(last_sent))?;
            if self.since(last_sent) < sent.retry {
                continue;
            }
            if tries == TRIES {
                return Err(self.unanswered(sent, began));
            }
            // A zero before it: where the end of the one before was damaged, the device is in step again.
            self.link.send(&[0])?;
            self.link.send(&sent.frame)?;
            self.counts.sent_again += 1;
            tries += 1;
            last_sent = self.now();
        }
    }

    fn unanswered(&self, sent: &Sent, began: Instant) -> ClientError {
        let is_silent = self.heard <= began;
        match (self.open, self.unknown_frames) {
            // Of one that says nothing at all it is not the line that is to be looked at.
            (true, _) | (false, 0) if is_silent => LinkError::Silent.into(),
            (true, _) => ClientError::Unanswered { what: sent.name, tries: TRIES },
            (false, 0) => ClientError::Noise,
            (false, _) => ClientError::OtherTongue,
        }
    }

    /// Takes what has come: an answer is returned, a group kept. In real time it returns without an answer after a
    /// tenth of a second.
    pub(super) fn next_answer(&mut self) -> Result<Option<(u16, GroupNumber, Answer)>, ClientError> {
        let Some(upload) = self.next_upload()? else { return Ok(None) };
        if let Some(expected) = self.next_upload.filter(|_| self.open) {
            match upload.sequence.wrapping_sub(expected) {
                lost if lost <= u32::MAX / 2 => {
                    self.counts.lost_uploads = self.counts.lost_uploads.saturating_add(lost)
                }
                // A device counts down only when it has begun anew.
                _ => self.restarted = true,
            }
        }
        self.next_upload = Some(upload.sequence.wrapping_add(1));
        if self.restarted {
            return Err(ClientError::Restarted);
        }
        match upload.message {
            Message::Answer { to, group, answer } => return Ok(Some((to, group, answer))),
            Message::Samples(block) => self.samples.take_in(block),
            Message::Group(report) => self.keep(report),
        }
        Ok(None)
    }

    fn keep(&mut self, report: GroupReport) {
        let group = report.group.0;
        if let Some(expected) = self.next_group.filter(|&expected| expected < group) {
            self.lost_groups.push(expected..=group - 1);
        }
        self.next_group = Some(group.wrapping_add(1));
        self.acquiring = true;
        let samples = self.samples.of(&report);
        self.groups.push_back(Group { report, samples });
    }

    fn next_upload(&mut self) -> Result<Option<Upload>, ClientError> {
        let began = self.now();
        loop {
            let mut taken = 0;
            let mut found = None;
            for &byte in &self.bytes {
                taken += 1;
                found = self.receiver.push::<Upload>(byte);
                if found.is_some() {
                    break;
                }
            }
            self.bytes.drain(..taken);
            match found {
                Some(Ok(upload)) => return Ok(Some(upload)),
                Some(Err(FrameError::Content)) => {
                    self.unknown_frames += 1;
                    self.counts.damaged_frames += u32::from(self.open);
                }
                Some(Err(_)) => self.counts.damaged_frames += u32::from(self.open),
                // Somebody talks all the time and says nothing: the clock must be looked at even so.
                None if self.in_real_time() && self.since(began) > LOOK_EVERY => return Ok(None),
                None => {
                    self.link.receive(&mut self.bytes)?;
                    if self.bytes.is_empty() && self.in_real_time() {
                        return Ok(None);
                    }
                    self.heard = self.now();
                }
            }
        }
    }

    /// Asks a quiet device whether it is there. Silence counts from when somebody listens, and from the last question.
    ///
    /// # Errors
    /// [`LinkError::Silent`], when it has not said anything for [`DEAD`].
    fn stay_patient(&mut self, last_sent: Option<Instant>) -> Result<(), ClientError> {
        if self.since(self.listened) > AWAY {
            self.listening_since = self.now();
        }
        self.listened = self.now();
        let quiet = self.since(self.heard.max(self.listening_since));
        if quiet > DEAD {
            return Err(LinkError::Silent.into());
        }
        if self.open && quiet > QUIET && self.since(last_sent.map_or(self.asked, |sent| sent.max(self.asked))) > QUIET {
            self.asked = self.now();
            self.send(Request::Faults, None)?;
        }
        Ok(())
    }

    /// Waits for a group until `deadline`.
    pub(super) fn group_before(&mut self, deadline: Instant) -> Result<Option<Group>, ClientError> {
        loop {
            if let Some(group) = self.groups.pop_front() {
                return Ok(Some(group));
            }
            // An answer that comes meanwhile is one that nobody waits for any more.
            self.next_answer()?;
            if self.in_real_time() && self.groups.is_empty() {
                self.stay_patient(None)?;
                if self.now() >= deadline {
                    return Ok(None);
                }
            }
        }
    }

    /// A group that has arrived already.
    pub(super) fn arrived_group(&mut self) -> Option<Group> {
        self.groups.pop_front()
    }

    /// Forgets the groups that have arrived.
    pub(super) fn discard_groups(&mut self) {
        self.groups.clear();
        self.samples.clear();
    }

    /// When a group is later than it can be.
    pub(super) fn too_late(&self) -> Duration {
        DEAD + self.group_period * LATE_GROUPS
    }
}

/// A command on its way.
pub(super) struct Sent {
    sequence: u16,
    frame: Vec<u8>,
    retry: Duration,
    name: &'static str,
}

fn name(request: &Request) -> &'static str {
    match request {
        Request::Identity => "who it is",
        Request::SetMode { .. } => "to change its mode",
        Request::SetTap { .. } => "to write a wiper",
        Request::SetAcquisition { run: true } => "to start the acquisition",
        Request::SetAcquisition { run: false } => "to stop the acquisition",
        Request::SetStream { .. } => "to stream groups",
        Request::WriteCalibration { .. } => "to take a part of a calibration",
        Request::CommitCalibration { .. } => "to commit the calibration",
        Request::ReadCalibration { .. } => "for its calibration",
        Request::Faults => "for its fault counters",
        Request::StorePowerUpTap => "to store the power-up tap",
        Request::RecallPowerUpTap => "to recall the power-up tap",
        #[allow(unreachable_patterns)] // What the table may have besides.
        _ => "something",
    }
}

/// The samples of the group that is coming in: all that were asked for, or none. An index that is taken for another
/// would move every jump.
#[derive(Default)]
struct Samples {
    window: SampleWindow,
    group: GroupNumber,
    axes: [Vec<Sample>; 2],
}

impl Samples {
    fn clear(&mut self) {
        self.axes = Default::default();
    }

    fn take_in(&mut self, block: SampleBlock) {
        if block.group != self.group {
            self.clear();
            self.group = block.group;
        }
        self.axes[block.axis.index()].extend(block.samples);
    }

    fn of(&mut self, report: &GroupReport) -> [Vec<Sample>; 2] {
        let axes = std::mem::take(&mut self.axes);
        let whole = Axis::BOTH.into_iter().all(|axis| {
            let n = u16::try_from(report.axes[axis.index()].sums.n).unwrap_or(u16::MAX);
            let (before, from) = self.window.of(axis, n);
            axes[axis.index()].len() == usize::from(before) + usize::from(n - from)
        });
        if self.group == report.group && whole { axes } else { Default::default() }
    }
}
