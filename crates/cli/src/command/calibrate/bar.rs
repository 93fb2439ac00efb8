//! Step, phase, temperature, elapsed and remaining time of a run, on a terminal.

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use zerorate_bench::plan::Plan;
use zerorate_bench::run::Progress;
use zerorate_bench::setup::SetUp;

use super::schedule;
use crate::{interrupt, progress, screen};

/// Step, phase, temperature, elapsed and remaining time on a terminal.
pub(super) struct Bar {
    pub(super) bar: ProgressBar,
    /// As `ZR-0001: `, of one among several.
    unit: String,
    /// As `step 2 of 7: `.
    step: String,
    phase: String,
    /// Whether time on the bench is that of the wall clock, so that it matters when the run ends.
    pub(super) takes_its_time: bool,
    /// As `, ends about Mon 18:10`.
    end: String,
}

impl Bar {
    pub(super) fn new(setup: &SetUp) -> Self {
        // Groups are what takes time: a ramp or two for the fit, six for the tests, and the soaks' minutes.
        let of_fit = if setup.chamber.cooling_ramp { 2 } else { 1 };
        let ramps = u64::from(setup.chamber.ramp_groups) * (of_fit + 6) + u64::from(setup.chamber.soak_groups) * 5;
        let bar = ProgressBar::new(ramps + 40 * setup.soaks().len() as u64);
        // A template that does not parse would be ours, and the plain bar is one too.
        if let Ok(style) = ProgressStyle::with_template("{msg:56} {bar:24} {elapsed} gone, {eta} left") {
            bar.set_style(style);
        }
        Self::on(bar, false)
    }

    fn on(bar: ProgressBar, takes_its_time: bool) -> Self {
        Self { bar, unit: String::new(), step: String::new(), phase: String::new(), takes_its_time, end: String::new() }
    }

    /// Nobody knows how long a person takes.
    pub(super) fn without_end() -> Self {
        let bar = progress::without_end();
        bar.set_message("about to begin");
        Self::on(bar, true)
    }

    /// One among several.
    pub(super) fn one_of(bars: &MultiProgress, serial: &str) -> Self {
        let own = Self::without_end();
        Self { bar: bars.add(own.bar), unit: format!("{serial}: "), ..own }
    }

    fn show(&self, at: &str) {
        self.bar.set_message(format!("{}{}{}{at}{}", self.unit, self.step, self.phase, self.end));
    }

    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn plan(&mut self, plan: &Plan) {
        if self.takes_its_time {
            schedule::of(plan).iter().for_each(|line| self.note(line));
        }
    }

    fn part(&mut self, plan: &Plan, place: usize) {
        self.step = format!("step {} of {}: ", place + 1, plan.parts.len());
        if self.takes_its_time {
            self.end = format!(", ends about {}", schedule::end(plan, place));
            self.note(&schedule::step(plan, place));
        }
    }

    fn phase(&mut self, name: &str, _: u32) {
        name.clone_into(&mut self.phase);
        self.show("");
    }

    fn step(&mut self, air_c: f64) {
        // A message for every group would cost more than the group.
        if self.bar.position().is_multiple_of(32) && !self.bar.is_hidden() {
            // A chamber that does not answer is nowhere.
            self.show(&if air_c.is_nan() { String::new() } else { format!(", {air_c:+.0} C") });
        }
        self.bar.inc(1);
    }

    fn note(&mut self, text: &str) {
        self.bar.suspend(|| screen::note(&format!("{}{text}", self.unit)));
    }

    fn is_interrupted(&self) -> bool {
        interrupt::was_asked_for()
    }
}
