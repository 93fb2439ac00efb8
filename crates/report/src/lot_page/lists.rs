//! What is said of units and files, in lists: who was rejected, what there is to look at, what was skipped.

use maud::{Markup, html};

use crate::alike::{alike, few};
use crate::lot::{LotReport, LotUnit};
use crate::number::{counted, whole};
use crate::page::{Table, told};

/// Rows of a list, at most: the rows that the page was made from have all.
const LISTED: usize = 200;

/// The recording of several units.
const NONE: &str = "\u{2013}";

/// What follows a caption where a list is cut.
fn of_all(all: usize) -> Markup {
    html! { @if all > LISTED { ", the first " (LISTED) " of " (whole(all as u64)) } "." }
}

pub(super) fn rejected(report: &LotReport) -> Markup {
    let rejected = report.units.iter().filter(|unit| !unit.rejected.is_empty());
    let rows = rejected.take(LISTED).map(|unit| {
        vec![
            html! { (unit.serial) },
            html! { span.nobr { (unit.file) } },
            html! { span.nobr { (unit.station) } },
            html! { div.sentence { (told(&unit.rejected.join("; "))) } },
        ]
    });
    let caption = html! { "Units rejected, with the reasons" (of_all(report.rejected())) };
    Table { caption, heads: &["Unit", "Recording", "Station", "Why"], rows: rows.collect(), numbers_from: 9 }
        .wide_markup()
}

/// What there is to look at, of rejected units too; what many units are told in the same words stands once.
pub(super) fn warnings(report: &LotReport) -> Markup {
    let each = report.units.iter().flat_map(|unit| unit.warned.iter().map(move |text| (unit, text.clone())));
    let all = alike(each);
    let row = |(sentence, units): &(String, Vec<&LotUnit>)| {
        let serials: Vec<&str> = units.iter().map(|unit| unit.serial.as_str()).collect();
        let (whom, file) = match units.as_slice() {
            [unit] => (unit.serial.clone(), unit.file.as_str()),
            several if several.len() == report.units.len() => ("all".to_owned(), NONE),
            _ => (few(&serials), NONE),
        };
        vec![
            html! { (whom) },
            html! { (file) },
            html! { div.sentence { (told(sentence)) } },
            html! { (whole(units.len() as u64)) },
        ]
    };
    let caption = html! { "What there is to look at, of rejected units too" (of_all(all.len())) };
    let rows = all.iter().take(LISTED).map(row).collect();
    Table { caption, heads: &["Unit", "Recording", "What", "Units"], rows, numbers_from: 3 }.wide_markup()
}

pub(super) fn skipped(report: &LotReport) -> Markup {
    let skipped = report.skipped();
    let row = |(file, reason): &(String, String)| vec![html! { (file) }, html! { div.sentence { (told(reason)) } }];
    let caption = html! { "Files that were not fitted, and are no unit of this page" (of_all(skipped.len())) };
    let rows = skipped.iter().take(LISTED).map(row).collect();
    Table { caption, heads: &["File", "Why"], rows, numbers_from: 9 }.wide_markup()
}

/// What the lot has beside its units, in a sentence.
pub(super) fn beside(report: &LotReport) -> Markup {
    let Some(beside) = &report.beside else {
        return html! { "Which files were skipped is not told: an earlier version fitted them. " };
    };
    let others = usize::try_from(beside.other_procedures).unwrap_or(usize::MAX);
    html! {
        @if !beside.skipped.is_empty() {
            (counted(beside.skipped.len(), "file")) @if beside.skipped.len() == 1 { " was" } @else { " were" } " skipped. "
        }
        @if others > 0 {
            (counted(others, "recording")) " of other procedures " @if others == 1 { "was" } @else { "were" } " passed over. "
        }
    }
}
