//! The page of a run as it goes, for who looks on, and of several. The page itself never changes; its parts do, each by its id.

mod boards;
mod figures;
mod groups;

use maud::{Markup, html};
use zerorate_fit::drift_fit::DriftFit;
use zerorate_fit::model::Model;
use zerorate_fit::ramp::fit_drift;

pub use self::boards::{LiveBoard, LiveBoards};
pub use self::groups::{RunGroup, RunGroups};
use super::figure::Second;
use super::number::fixed;
use super::page::{self, Chapter, Table, told};

/// Replaces parts as they come, and says whether they still do.
const SCRIPT: &str = include_str!("live_page/script.js");

/// A run as far as it has got.
#[derive(Debug, Clone, Default)]
pub struct LiveRun {
    /// What runs, in a line: a procedure and a unit.
    pub title: String,
    /// The clock on the wall, at what came last.
    pub heard_at: String,
    /// What is being done.
    pub doing: String,
    /// The chamber's air, or what stands for it, degrees C; NaN while it is not known.
    pub air_c: f64,
    /// When all of it ends.
    pub ends: Option<String>,
    /// The steps of the plan; none where nothing is planned.
    pub steps: Vec<RunStep>,
    /// What was told, each with the time by the clock, the newest first.
    pub notes: Vec<(String, String)>,
    /// How it ended, once it has.
    pub ended: Option<String>,
    /// X's and Y's groups of the step that runs.
    pub axes: [RunGroups; 2],
    /// Counts of the temperature channel at 0 C, and those of one degree, by the set-up.
    pub celsius: Option<(f64, f64)>,
    /// The model that is fitted as the ramp goes; `auto` is for when it is over, and a cubic stands for it.
    pub model: Model,
}

/// A step of the plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunStep {
    /// Its name.
    pub name: String,
    /// What the chamber does in it.
    pub chamber: String,
    /// How long it takes, in words.
    pub takes: String,
    /// How far it is.
    pub state: StepState,
}

/// How far a step is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepState {
    /// It is over.
    Done,
    /// It runs.
    Now,
    /// It was the last that ran.
    Ended,
    /// It is to come.
    ToCome,
}

/// Where the parts are put.
const NOW: &str = "now";
const FIGURES: &str = "figures";
const PLAN: &str = "plan";
const NOTES: &str = "notes";

impl LiveRun {
    /// It has ended: nothing runs any more.
    pub fn end(&mut self, how: String) {
        self.ended = Some(how);
        let now = self.steps.iter_mut().filter(|step| step.state == StepState::Now);
        now.for_each(|step| step.state = StepState::Ended);
    }

    /// The page around the parts, for a run of this title.
    #[must_use]
    pub fn page(title: &str) -> String {
        let chapters = [
            ("so-far", "What has come so far", FIGURES),
            ("the-plan", "The plan", PLAN),
            ("told", "What was told", NOTES),
        ];
        page_of_parts("A run as it goes", title, &chapters)
    }

    /// The parts as they are now, by their ids.
    #[must_use]
    pub fn parts(&self) -> Vec<(&'static str, String)> {
        let fits = self.axes.each_ref().map(|axis| self.fit(axis));
        vec![
            (NOW, self.now(&fits).into_string()),
            (FIGURES, figures::figures(self, &fits).into_string()),
            (PLAN, self.plan().into_string()),
            (NOTES, self.told().into_string()),
        ]
    }

    /// The model that is fitted as the ramp goes.
    const fn running_model(&self) -> Model {
        match self.model {
            Model::Auto => Model::Poly(3),
            model => model,
        }
    }

    /// The fit of what an axis has of its ramp, where it is uncompensated and there is enough of it.
    fn fit(&self, axis: &RunGroups) -> Option<DriftFit> {
        let (temperatures, readings) = axis.uncompensated_ramp();
        fit_drift(&temperatures, &readings, self.running_model()).ok()
    }

    fn now(&self, fits: &[Option<DriftFit>; 2]) -> Markup {
        let mut facts: Vec<(&str, Markup)> = Vec::new();
        let is_over = self.ended.is_some();
        facts.extend(self.ended.iter().map(|ended| ("State", told(ended))));
        facts.extend(self.step().map(|step| ("Step", html! { (step) })));
        if !is_over && !self.doing.is_empty() {
            facts.push(("Now", html! { (self.doing) }));
        }
        facts.extend(self.ends.iter().filter(|_| !is_over).map(|ends| ("Ends about", html! { (ends) })));
        facts.extend(self.air().map(|air| ("Chamber", html! { (air) })));
        facts.extend(self.temperature().map(|reading| ("Temperature reading", html! { (reading) })));
        facts.extend(self.output().map(|output| ("Zero-rate output", html! { (output) " counts" })));
        facts.extend(left(fits).map(|left| {
            ("Residual of the fit so far", html! { (left) " counts rms, in-sample, " (self.running_model()) })
        }));
        html! {
            (page::facts(&facts))
            @if !self.heard_at.is_empty() { p.small { "The last group came at " (self.heard_at) "." } }
        }
    }

    /// The step that runs, as `2 of 7: trim experiment`.
    fn step(&self) -> Option<String> {
        let place = self.steps.iter().position(|step| step.state == StepState::Now)?;
        Some(format!("{} of {}: {}", place + 1, self.steps.len(), self.steps[place].name))
    }

    /// The chamber's air.
    fn air(&self) -> Option<String> {
        self.air_c.is_finite().then(|| format!("{}\u{a0}°C", fixed(self.air_c, 1)))
    }

    /// The newest temperature reading.
    fn temperature(&self) -> Option<String> {
        let counts = self.axes.iter().find_map(RunGroups::last)?.temperature_counts;
        let celsius = self.celsius().map(|scale| format!(" ({}\u{a0}°C)", fixed(scale.of(counts), 1)));
        Some(format!("{} counts{}", fixed(counts, 0), celsius.unwrap_or_default()))
    }

    /// The newest zero-rate output of each axis, counts.
    fn output(&self) -> Option<String> {
        of_axes(self.axes.each_ref().map(|axis| Some(fixed(axis.last()?.reading_counts, 1))))
    }

    fn plan(&self) -> Markup {
        let row = |(place, step): (usize, &RunStep)| {
            let state = match step.state {
                StepState::Done => html! { span.good { "✓\u{a0}done" } },
                StepState::Now => html! { b { "now" } },
                StepState::Ended => html! { "the last" },
                StepState::ToCome => html! { "to come" },
            };
            let name = html! { (place + 1) ". " (step.name) };
            vec![name, html! { (step.chamber) }, html! { (step.takes) }, state]
        };
        html! {
            @if self.steps.is_empty() { p { "There is no plan: groups are shown as they come." } } @else {
                (Table {
                    caption: html! { "The steps. Times are estimates: how fast the chamber goes is assumed." },
                    heads: &["Step", "Chamber", "Takes about", "State"],
                    rows: self.steps.iter().enumerate().map(row).collect(),
                    numbers_from: 4,
                }.wide_markup())
            }
        }
    }

    fn told(&self) -> Markup {
        html! {
            @if self.notes.is_empty() { p { "Nothing so far." } } @else {
                ul.reasons { @for (at, note) in &self.notes { li { span.small { (at) } " " (told(note)) } } }
            }
        }
    }

    /// Degrees C beside the counts of a temperature axis.
    fn celsius(&self) -> Option<Second> {
        self.celsius.map(|(zero, one)| Second { unit: "°C", zero, one })
    }
}

/// The page around parts that are put where they belong as they come: what is now, then chapters, each of one part.
fn page_of_parts(over: &str, title: &str, chapters: &[(&'static str, &'static str, &str)]) -> String {
    let headline = html! {
        p.over { (over) }
        h1 { (title) }
        p #line.small role="status" { "Not connected yet." }
        noscript { p { "This page renews itself by a script; without one it stays empty." } }
        div id=(NOW) {}
    };
    let chapters: Vec<Chapter> =
        chapters.iter().map(|(id, name, part)| (*id, *name, html! { div id=(part) {} })).collect();
    page::page_with_script(&format!("{title}, as it goes"), &headline, &chapters, SCRIPT)
}

/// What fits of a ramp leave, counts rms.
fn left(fits: &[Option<DriftFit>; 2]) -> Option<String> {
    of_axes(fits.each_ref().map(|fit| Some(fixed(fit.as_ref()?.statistics.in_sample.rms, 2))))
}

/// A figure of each axis that has one, as `X 1.2, Y 3.4`.
fn of_axes(figures: [Option<String>; 2]) -> Option<String> {
    let named =
        figures.into_iter().zip(["X", "Y"]).filter_map(|(figure, name)| Some(format!("{name}\u{a0}{}", figure?)));
    let named: Vec<String> = named.collect();
    (!named.is_empty()).then(|| named.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's X axis (eq. 1) up to a share of its ramp, each group one count above the curve or below it.
    fn ramp(share: f64) -> LiveRun {
        let mut run = LiveRun { celsius: Some((9860.0, 34.0)), model: Model::Poly(2), ..LiveRun::default() };
        let groups = (0..2400_u32).take_while(|group| f64::from(*group) < 2400.0 * share);
        for group in groups {
            let t = 8500.0 + 3400.0 * f64::from(group) / 2399.0;
            let noise = if group % 2 == 0 { 1.0 } else { -1.0 };
            run.axes[0].push(RunGroup {
                time_s: 1.5 * f64::from(group),
                temperature_counts: t,
                reading_counts: 13_435.7 - 0.894_782 * t + 0.375_298e-4 * t * t + noise,
                is_ramp: true,
                is_compensated: false,
            });
        }
        run
    }

    fn part(run: &LiveRun, id: &str) -> String {
        run.parts().into_iter().find(|(own, _)| *own == id).unwrap().1
    }

    #[test]
    fn the_residual_of_a_ramp_that_is_one_count_off_is_one_count_at_every_share_of_it() {
        for share in [0.1, 0.5, 1.0] {
            let now = part(&ramp(share), NOW);
            assert!(now.contains("X\u{a0}1.00 counts rms, in-sample, poly:2"), "{now}");
        }
        // Two groups settle no quadratic, and none is shown.
        assert!(!part(&ramp(0.0008), NOW).contains("Residual"));
    }

    #[test]
    fn a_run_that_has_not_begun_is_shown_and_the_page_has_a_place_for_every_part() {
        let run = LiveRun { air_c: f64::NAN, ..LiveRun::default() };
        let page = LiveRun::page("Calibration of ZR-0001");
        for (id, html) in run.parts() {
            assert!(page.contains(&format!("<div id=\"{id}\"></div>")), "{id}");
            assert!(!html.contains("NaN"), "{html}");
        }
    }

    #[test]
    fn what_others_have_written_is_text() {
        let notes = vec![("10:00".into(), "the chamber is <script>alert(1)</script>".into())];
        let told = part(&LiveRun { notes, ..LiveRun::default() }, NOTES);
        assert!(told.contains("&lt;script&gt;") && !told.contains("<script"), "{told}");
        assert!(LiveRun::page("<b>").contains("<h1>&lt;b&gt;</h1>"));
    }
}
