//! What the compensator has to say, in the order in which it came to be, until the task below fetches it.

use heapless::{Deque, Vec};
use zerorate_core::compensate::SampleCorrection;
use zerorate_core::wire::{GroupReport, SampleWindow};

use super::report::{Outcome, Report};
use super::samples::Stream;
use crate::acquisition::Scan;

/// Groups that wait to be fetched; further ones are dropped, and counted.
const GROUPS: usize = 11;
/// Room that is left for answers: more than commands can wait for a group. None is ever dropped, or the host would ask in
/// vain.
const ANSWERS: usize = 9;

/// What waits. Samples are made when they are fetched: those of one group would not find room.
#[allow(clippy::large_enum_variant)] // no heap here
enum Waiting {
    Done(u16, Outcome),
    Group(GroupReport),
}

/// Answers, groups and samples on their way out.
pub(super) struct Outbox {
    waiting: Deque<Waiting, { GROUPS + ANSWERS }>,
    window: SampleWindow,
    /// The last group, while its samples are on their way out. One at most; none of them is zeros, which an option's none need not
    /// be: of what is not zeros a second copy stands in flash.
    stream: Vec<Stream, 1>,
    /// Uploads that found no room.
    pub(super) dropped: u32,
}

impl Outbox {
    pub(super) const fn new() -> Self {
        Self { waiting: Deque::new(), window: SampleWindow::NONE, stream: Vec::new(), dropped: 0 }
    }

    /// Whether any samples are asked for.
    pub(super) const fn wants_samples(&self) -> bool {
        self.window.is_open()
    }

    /// Other samples are asked for from now on.
    pub(super) fn set_window(&mut self, window: SampleWindow) {
        self.window = window;
        self.stream.clear();
    }

    /// The acquisition was stopped or began anew.
    pub(super) fn forget_samples(&mut self) {
        self.stream.clear();
    }

    pub(super) fn answer(&mut self, sequence: u16, outcome: Outcome) {
        self.dropped += u32::from(self.waiting.push_back(Waiting::Done(sequence, outcome)).is_err());
    }

    pub(super) fn group(&mut self, report: GroupReport) {
        let has_room = self.waiting.len() < GROUPS;
        self.dropped += u32::from(!has_room || self.waiting.push_back(Waiting::Group(report)).is_err());
    }

    /// A group of so many scans whose samples go out before it. `before` it the axes were such.
    pub(super) fn group_and_samples(&mut self, report: GroupReport, before: [SampleCorrection; 2], scans: usize) {
        self.stream.clear();
        let _ = self.stream.push(Stream::new(report, before, &self.window, scans));
    }

    /// The samples of a group could not be read.
    pub(super) fn samples_are_missing(&mut self) {
        self.dropped += 1;
    }

    /// The samples of the group before are gone with its set; the group itself is not.
    pub(super) fn set_goes(&mut self) {
        if let Some(stream) = self.stream.pop() {
            self.dropped += stream.left();
            self.group(stream.report);
        }
    }

    /// The next answer or group. What was answered meanwhile comes before further samples.
    pub(super) fn next(&mut self) -> Option<Report> {
        Some(match self.waiting.pop_front()? {
            Waiting::Done(sequence, outcome) => Report::Done(sequence, outcome),
            Waiting::Group(report) => Report::Group(report),
        })
    }

    /// The next samples, and after the last of them their group.
    pub(super) fn next_of_samples(&mut self, scans: &[Scan]) -> Option<Report> {
        match self.stream.first_mut()?.next_block(scans) {
            Some(block) => Some(Report::Samples(block)),
            None => self.stream.pop().map(|stream| Report::Group(stream.report)),
        }
    }
}
