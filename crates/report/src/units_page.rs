//! The page of many units: their calibrations in a table, and how those that were calibrated more than once have changed.

mod trend;

use maud::{Markup, html};
use zerorate_cal::quality::Verdict;

use super::number::{counted, fixed_or_none, whole};
use super::page::{self, Chapter, Table};

/// The units that lie in a folder.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitsReport {
    /// The folder, as it was named.
    pub folder: String,
    /// The units in the order of the table.
    pub units: Vec<UnitCalibrations>,
    /// A sentence for each result that cannot be read.
    pub unreadable: Vec<String>,
}

/// A unit and its calibrations, the first first.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitCalibrations {
    /// Its serial.
    pub serial: String,
    /// At least one.
    pub calibrations: Vec<UnitCalibration>,
}

/// One calibration in the numbers that are listed.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitCalibration {
    /// When it was made, in words.
    pub made: String,
    /// When it was made, days since 1970; `None` where that is not known.
    pub day: Option<f64>,
    /// What it came to.
    pub verdict: Verdict,
    /// X and Y, as far as they are known.
    pub axes: [Option<UnitAxis>; 2],
}

/// One axis of it, counts; peak to peak over a heating ramp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitAxis {
    /// Without compensation.
    pub drift: f64,
    /// What mode trim leaves.
    pub trim: Option<f64>,
    /// What mode hybrid leaves, or digital.
    pub hybrid: Option<f64>,
    /// The curve's largest distance from the calibration before.
    pub change: Option<f64>,
}

fn title(folder: &str) -> String {
    format!("Units in {folder}")
}

impl UnitsReport {
    /// The report as one self-contained HTML file. Equal reports make equal bytes.
    #[must_use]
    pub fn to_html(&self) -> String {
        let chapters: Vec<Chapter> = vec![
            ("trend", "What has changed", trend::chapter(&self.units)),
            ("units", "The calibrations", self.table()),
        ];
        page::page(&title(&self.folder), &self.headline(), &chapters)
    }

    /// Whether a page is the report of a folder.
    #[must_use]
    pub fn is_page_of(page: &str, folder: &str) -> bool {
        page.contains(&html! { title { (title(folder)) } }.into_string())
    }

    fn headline(&self) -> Markup {
        let runs: usize = self.units.iter().map(|unit| unit.calibrations.len()).sum();
        let last = self.units.iter().filter_map(|unit| unit.calibrations.last());
        let rejected = last.filter(|last| last.verdict == Verdict::Rejected).count();
        html! {
            h1 { (counted(self.units.len(), "unit")) }
            p.lead { (counted(runs, "calibration")) "; " (whole(rejected as u64)) " rejected by the last." }
            p { "From " code { (self.folder) } "." }
            @if !self.unreadable.is_empty() { ul.reasons { @for sentence in &self.unreadable { li { (sentence) } } } }
        }
    }

    fn table(&self) -> Markup {
        let rows = self.units.iter().flat_map(|unit| {
            unit.calibrations.iter().enumerate().map(|(place, calibration)| row(&unit.serial, place + 1, calibration))
        });
        Table {
            caption: html! {
                "Counts, X / Y: drift and residuals peak to peak over a heating ramp; changed is the curve’s largest distance from the "
                "calibration before, over the temperatures of both."
            },
            heads: &["Serial", "Made, UTC", "Verdict", "Calibration", "Drift", "Trim left", "Hybrid left", "Changed"],
            rows: rows.collect(),
            numbers_from: 3,
        }
        .wide_markup()
    }
}

fn row(serial: &str, number: usize, calibration: &UnitCalibration) -> Vec<Markup> {
    let pair = |of: fn(&UnitAxis) -> Option<f64>| {
        let told = calibration.axes.iter().map(|axis| fixed_or_none(axis.as_ref().and_then(of), 1));
        html! { (told.collect::<Vec<_>>().join(" / ")) }
    };
    vec![
        html! { (serial) },
        html! { span.nobr { (calibration.made) } },
        page::verdict(calibration.verdict),
        html! { (number) },
        pair(|axis| Some(axis.drift)),
        pair(|axis| axis.trim),
        pair(|axis| axis.hybrid),
        pair(|axis| axis.change),
    ]
}
