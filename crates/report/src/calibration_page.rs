//! The report of a calibration as a page: the story in its order, one file a chapter.

mod compensation;
mod drift;
mod headline;
mod reading;
mod soaks;
mod trim;
mod versus;

use maud::{Markup, html};

use super::calibration::CalibrationReport;
use super::figure::Ink;
use super::page::{self, Chapter};

impl CalibrationReport {
    /// The report as one self-contained HTML file. Equal reports make equal bytes.
    #[must_use]
    pub fn to_html(&self) -> String {
        let mut chapters: Vec<Chapter> = vec![
            ("drift", "The drift", drift::chapter(self)),
            ("trim", "The trim", trim::chapter(self)),
            ("compensation", "The compensation test", compensation::chapter(self)),
            ("paper", "Beside the paper", versus::chapter(self)),
        ];
        if let Some(comparison) = &self.soaks {
            chapters.push(("soaks", "One ramp against soaks", soaks::chapter(comparison, self)));
        }
        chapters.push(("checks", "What was checked", reading::checks(self)));
        chapters.push(("reading", "How to read the numbers", reading::definitions(self)));
        page::page(&format!("Calibration of {}", self.unit.serial), &headline::headline(self), &chapters)
    }
}

/// The ink of an axis: the first of the report, or any other.
fn ink_of(report: &CalibrationReport, axis: &str) -> Ink {
    match report.axes.first() {
        Some(first) if first.name == axis => Ink::X,
        _ => Ink::Y,
    }
}

/// An axis's name with a subscript, as in V<sub>X</sub>.
fn indexed(symbol: &str, axis: &str) -> Markup {
    html! { i { (symbol) } sub { (axis) } }
}
