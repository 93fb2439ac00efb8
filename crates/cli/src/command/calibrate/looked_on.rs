//! A run's progress, told to the terminal and to the page of those who look on.

use zerorate_bench::board::{Axis, Mode};
use zerorate_bench::plan::Plan;
use zerorate_bench::run::{Progress, Taken};
use zerorate_bench::setup::SetUp;
use zerorate_report::{RunGroup, RunStep, StepState};

use super::dry_run::RampsOf;
use super::{Bar, schedule};
use crate::clock::time;
use crate::looking_on::{LookingOn, clock};

/// Notes that are kept for the page.
const MOST_NOTES: usize = 200;

/// Both.
pub struct LookedOn<'a> {
    bar: &'a mut Bar,
    setup: &'a SetUp,
    ramps: RampsOf,
    live: Option<&'a LookingOn>,
}

impl<'a> LookedOn<'a> {
    pub const fn new(bar: &'a mut Bar, setup: &'a SetUp, ramps: RampsOf, live: Option<&'a LookingOn>) -> Self {
        Self { bar, setup, ramps, live }
    }
}

impl Progress for LookedOn<'_> {
    fn plan(&mut self, plan: &Plan) {
        self.bar.plan(plan);
        let Some(live) = self.live else { return };
        let steps = plan.parts.iter().map(|(part, took)| RunStep {
            name: part.to_string(),
            chamber: part.chamber(self.setup, self.ramps.k_per_min(self.setup)),
            takes: if took.0 > 0.0 { time(took.0) } else { "done before".to_owned() },
            state: if took.0 > 0.0 { StepState::ToCome } else { StepState::Done },
        });
        let (steps, ends) = (steps.collect(), self.bar.takes_its_time.then(|| schedule::end(plan, 0)));
        live.change(|run| (run.steps, run.ends) = (steps, ends));
    }

    fn part(&mut self, plan: &Plan, place: usize) {
        self.bar.part(plan, place);
        let Some(live) = self.live else { return };
        let ends = self.bar.takes_its_time.then(|| schedule::end(plan, place));
        live.change(|run| {
            run.ends = ends;
            run.axes = Default::default();
            for (own, step) in run.steps.iter_mut().enumerate() {
                if own <= place {
                    step.state = if own == place { StepState::Now } else { StepState::Done };
                }
            }
        });
    }

    fn phase(&mut self, name: &str, groups: u32) {
        self.bar.phase(name, groups);
        if let Some(live) = self.live {
            live.change(|run| name.clone_into(&mut run.doing));
        }
    }

    fn step(&mut self, air_c: f64) {
        self.bar.step(air_c);
        if let Some(live) = self.live {
            live.change(|run| run.air_c = air_c);
        }
    }

    fn group(&mut self, taken: &Taken, elapsed_s: f64) {
        let Some(live) = self.live else { return };
        let of = |axis: Axis| RunGroup {
            time_s: elapsed_s,
            temperature_counts: taken.temperature(axis).0,
            reading_counts: taken.corrected(axis).0,
            is_ramp: taken.phase.is_ramp(),
            is_compensated: taken.report.axes[axis.index()].mode != Mode::Off,
        };
        let (heard_at, groups) = (clock(), Axis::BOTH.map(of));
        live.change(|run| {
            run.heard_at = heard_at;
            run.axes.iter_mut().zip(groups).for_each(|(axis, group)| axis.push(group));
        });
    }

    fn note(&mut self, text: &str) {
        self.bar.note(text);
        if let Some(live) = self.live {
            live.change(|run| {
                run.notes.truncate(MOST_NOTES);
                run.notes.insert(0, (clock(), text.to_owned()));
            });
        }
    }

    fn is_interrupted(&self) -> bool {
        self.bar.is_interrupted()
    }
}
