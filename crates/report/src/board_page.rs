//! The page of a board's run, made from the files that it left: the story in its order, one file a chapter.

mod axis;
mod compensation;
mod drift;
mod headline;
mod reading;
mod soaks;
mod trim;
mod versus;

use maud::{Markup, html};
use zerorate_board_run::folder::BoardRun;
use zerorate_board_run::summary::Summary;
use zerorate_cal::units::{RateScale, RateUnit, WrittenRate};
use zerorate_core::units::Axis;

use self::axis::BoardAxis;
use super::figure::Second;
use super::number::{fixed, significant};
use super::page::{self, Chapter};
use super::panels::name_of;

/// A run and its axes, X first.
struct Board<'a> {
    run: &'a BoardRun,
    summary: &'a Summary,
    /// The unit of what is told as a rate beside its counts.
    rate: RateScale,
    axes: Vec<BoardAxis<'a>>,
}

/// The page of a board's run as one self-contained HTML file. Equal files make equal bytes. What is told as a rate beside its
/// counts is in deg/s, or in the unit asked for.
#[must_use]
pub fn board_page(run: &BoardRun, units: Option<WrittenRate>) -> String {
    let axes = Axis::BOTH.into_iter().filter_map(|axis| BoardAxis::of(run, axis)).collect();
    let rate = RateScale::of(RateUnit::Dps, &[f64::INFINITY], units);
    let board = Board { run, summary: &run.summary, rate, axes };
    let mut chapters: Vec<Chapter> = vec![
        ("drift", "The drift", drift::chapter(&board)),
        ("trim", "The trim", trim::chapter(&board)),
        ("compensation", "The compensation test", compensation::chapter(&board)),
        ("paper", "Beside the paper", versus::chapter(&board)),
    ];
    if let Some(soaks) = &run.summary.soaks {
        chapters.push(("soaks", "One ramp against soaks", soaks::chapter(soaks, &board)));
    }
    chapters.push(("checks", "What was checked", reading::checks(&run.summary.checks)));
    chapters.push(("reading", "How to read the numbers", reading::definitions(&board)));
    let sources = page::sources(&run.calibration.created_by, &run.summary.recordings);
    chapters.push(("sources", "What this page is made of", sources));
    page::page(&format!("Calibration of {}", run.summary.serial), &headline::headline(&board), &chapters)
}

impl Board<'_> {
    /// The reading aimed at, counts.
    fn centre_counts(&self) -> f64 {
        self.axes.first().map_or(f64::NAN, |axis| axis.trim.trim.line.centre().0)
    }

    /// Degrees C beside the counts of a temperature axis, where the set-up says what a count is.
    fn celsius(&self) -> Option<Second> {
        let scale = self.run.calibration.celsius_scale()?;
        Some(Second { unit: "°C", zero: scale.at_zero.0, one: scale.counts_per_celsius })
    }

    /// A temperature in counts as it is written: degrees C behind it, where they are known.
    fn temperature(&self, counts: f64) -> String {
        let celsius = self.celsius().map(|scale| format!(" ({}\u{a0}°C)", fixed(scale.of(counts), 1)));
        format!("{} counts{}", fixed(counts, 0), celsius.unwrap_or_default())
    }

    /// Counts as a rate, without its unit.
    fn rate(&self, counts: f64) -> Markup {
        significant(self.rate.of_rate(counts / self.summary.counts_per_dps.abs()), 3)
    }

    /// The unit of that.
    fn rate_unit(&self) -> &'static str {
        match self.rate.unit() {
            "dps" => "deg/s",
            unit => unit,
        }
    }

    /// The tap at which the drift was recorded.
    fn middle_tap(&self) -> u16 {
        self.axes.first().map_or(0, |axis| axis.trim.trim.line.middle().get())
    }

    /// Whether the unit is the paper's, simulated.
    fn is_papers(&self) -> bool {
        self.summary.plant.as_deref() == Some("paper")
    }

    /// Which figure of the paper shows the same. Of another unit none does.
    fn as_in_the_paper(&self, figure: u8) -> Markup {
        html! { @if self.is_papers() { " (As figure " (figure) " of the paper.)" } }
    }

    /// Samples averaged to a group, each channel.
    fn group_samples(&self) -> u32 {
        self.run.full_temperature.rows.first().map_or(0, |row| row.sums.n)
    }
}

/// An axis's name with a subscript, as in V<sub>X</sub>.
fn indexed(symbol: &str, axis: Axis) -> Markup {
    html! { i { (symbol) } sub { (name_of(axis)) } }
}
