//! The table of candidate models, the same for a calibration and for a log.

use maud::{Markup, html};

use super::calibration::CandidateRow;
use super::number::{decimals_for, fixed, thousandfold};
use super::page::Table;

/// Rows at most: the one chosen, and those that predict best.
const SHOWN: usize = 12;

/// The candidates of one axis; nothing where none are given.
pub(super) fn table(axis: &str, candidates: &[CandidateRow], unit: &str) -> Markup {
    if candidates.is_empty() {
        return html! {};
    }
    let all = candidates.len();
    let candidates = shown(candidates);
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
        @if all > candidates.len() { " The " (candidates.len()) " of " (all) " that predict best." }
    };
    Table { caption, heads: &heads, rows: candidates.into_iter().map(row).collect(), numbers_from: 1 }.markup()
}

/// The candidates worth a row, in their order.
fn shown(candidates: &[CandidateRow]) -> Vec<&CandidateRow> {
    let mut errors: Vec<f64> = candidates.iter().map(|candidate| candidate.held_out_rms).collect();
    errors.sort_by(f64::total_cmp);
    let most = errors.get(SHOWN - 1).copied().unwrap_or(f64::INFINITY);
    candidates.iter().filter(|candidate| candidate.chosen || candidate.held_out_rms <= most).collect()
}
