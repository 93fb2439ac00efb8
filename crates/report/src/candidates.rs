//! The table of candidate models, the same for a board and for a log.

use maud::{Markup, html};
use zerorate_fit::drift_fit::{Candidate, FitStatistics};

use super::number::{decimals_for, fixed, fixed_or_none};
use super::page::Table;
use zerorate_cal::units::RateScale;

/// Rows at most: the one chosen, and those that predict best.
const SHOWN: usize = 12;

/// The candidates of one axis; nothing where one model was asked for, for then there was no choice.
pub(super) fn table(axis: &str, statistics: &FitStatistics, scale: RateScale) -> Markup {
    let Some(how) = statistics.how_it_was_chosen() else { return html! {} };
    let all = statistics.candidates.len();
    let candidates = shown(&statistics.candidates);
    let held_out = || candidates.iter().filter_map(|candidate| candidate.held_out_rms);
    let decimals = 1 + decimals_for(scale.of_rate(held_out().fold(f64::INFINITY, f64::min)));
    let scaled = |value: Option<f64>| html! { (fixed_or_none(value.map(|value| scale.of_rate(value)), decimals)) };
    let heads = ["Model", "In-sample rms", "Held-out rms", "± to the best’s", "Zeroed by fold, rms"];
    let row = |candidate: &Candidate| {
        vec![
            // Long names give way to the figures.
            html! { span.wraps { (candidate.model) @if candidate.chosen { " ✓" } } },
            html! { (fixed(scale.of_rate(candidate.in_sample_rms), decimals)) },
            scaled(candidate.held_out_rms),
            scaled(candidate.held_out_excess_standard_error),
            scaled(candidate.deployed_rms),
        ]
    };
    let caption = html! {
        b { (axis) } ": models compared by blocked cross-validation. Held out is within the recording, its drift in time taken off; ± is "
        "one standard error of how far that is from the best one’s. Zeroed by fold is what a device has left in a run as long as "
        "a fold, which knows no drift in time and takes its zero at the fold’s start: over a whole log, deployed, it may be more. Taken (✓) is " (how) ". In " (scale.unit()) "."
        @if all > candidates.len() { " The " (candidates.len()) " of " (all) " that predict best." }
    };
    Table { caption, heads: &heads, rows: candidates.into_iter().map(row).collect(), numbers_from: 1 }.markup()
}

/// The candidates worth a row, in their order.
fn shown(candidates: &[Candidate]) -> Vec<&Candidate> {
    let held_out = |candidate: &Candidate| candidate.held_out_rms.unwrap_or(f64::NAN);
    let mut errors: Vec<f64> = candidates.iter().map(held_out).collect();
    errors.sort_by(f64::total_cmp);
    let most = errors.get(SHOWN - 1).copied().unwrap_or(f64::INFINITY);
    candidates.iter().filter(|candidate| candidate.chosen || held_out(candidate) <= most).collect()
}
