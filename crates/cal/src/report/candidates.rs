//! The table of candidate models, the same for a calibration and for a log.

use maud::{Markup, html};

use super::calibration::CandidateRow;
use super::number::{decimals_for, fixed, thousandfold};
use super::page::Table;

/// The candidates of one axis; nothing where none are given.
pub(super) fn table(axis: &str, candidates: &[CandidateRow], unit: &str) -> Markup {
    if candidates.is_empty() {
        return html! {};
    }
    let held_out = || candidates.iter().map(|candidate| candidate.held_out_rms);
    let (factor, unit) = thousandfold(held_out().fold(0.0, f64::max), unit);
    let decimals = 1 + decimals_for(held_out().fold(f64::INFINITY, f64::min) / factor);
    let scaled = |value: f64| html! { (fixed(value / factor, decimals)) };
    let heads = ["Model", "In-sample rms", "Held-out rms", "± standard error"];
    let row = |candidate: &CandidateRow| {
        vec![
            html! { (candidate.model) @if candidate.chosen { " ✓" } },
            scaled(candidate.in_sample_rms),
            scaled(candidate.held_out_rms),
            scaled(candidate.standard_error),
        ]
    };
    let caption = html! {
        b { (axis) } ": models compared on contiguous stretches that each was not fitted to; the simplest within one "
        "standard error of the best is taken (✓). In " (unit) "."
    };
    Table { caption, heads: &heads, rows: candidates.iter().map(row).collect(), numbers_from: 1 }.markup()
}
