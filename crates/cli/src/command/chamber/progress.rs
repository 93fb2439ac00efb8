//! What a profile's run tells at the terminal and keeps in its recording.

use std::path::PathBuf;

use indicatif::ProgressBar;
use zerorate_bench::error::BenchError;
use zerorate_bench::profile::{Profile, Seconds, Watcher};
use zerorate_cal::recording::{ChamberMoment, ChamberWriter, WriteError};
use zerorate_report::number::counted;

use crate::clock::{self, from_now, time};
use crate::progress;
use crate::screen;

/// Of a profile of more steps the plan has a line for these alone.
const MOST_LINES: usize = 40;

/// The plan: a line for all of it and one for each step.
pub fn plan(profile: &Profile, times: &[Seconds]) -> Vec<String> {
    let whole: f64 = times.iter().map(|time| time.0).sum();
    let count = profile.steps.len();
    let head = clock::plan(&counted(count, "step"), whole);
    let steps = profile.steps.iter().zip(times).enumerate();
    let lines = steps.map(|(place, (step, took))| format!("{}. {step}: about {}", place + 1, time(took.0)));
    let more = count.saturating_sub(MOST_LINES);
    let more = (more > 0).then(|| format!("and {more} more"));
    std::iter::once(head).chain(lines.take(MOST_LINES)).chain(more).collect()
}

/// The recording and the terminal.
pub struct Told<'a> {
    profile: &'a Profile,
    times: Vec<Seconds>,
    writer: ChamberWriter,
    bar: ProgressBar,
    doing: String,
}

impl<'a> Told<'a> {
    /// Of a run that is about to begin.
    pub fn new(profile: &'a Profile, times: Vec<Seconds>, writer: ChamberWriter) -> Self {
        Self { profile, times, writer, bar: progress::without_end(), doing: String::new() }
    }

    /// Finishes the recording, and says where it is.
    pub fn finish(self) -> Result<PathBuf, WriteError> {
        self.bar.finish_and_clear();
        self.writer.finish()
    }
}

impl Watcher for Told<'_> {
    fn step(&mut self, place: usize) {
        let left: f64 = self.times[place..].iter().map(|time| time.0).sum();
        let (number, all) = (place + 1, self.times.len());
        self.doing =
            format!("step {number} of {all}: {}, the end is about {}", self.profile.steps[place], from_now(left));
        let told = self.doing.clone();
        self.note(&told);
    }

    fn moment(&mut self, moment: &ChamberMoment) -> Result<(), BenchError> {
        let air = if moment.air_c.is_nan() { "not known".to_owned() } else { format!("{:.1} C", moment.air_c) };
        self.bar.set_message(format!("{}; set to {:.1} C, air {air}", self.doing, moment.set_c));
        self.bar.tick();
        Ok(self.writer.write(moment)?)
    }

    fn note(&mut self, text: &str) {
        self.bar.suspend(|| screen::note(text));
    }
}
