//! What is left of each of several logs.

use maud::{Markup, html};
use zerorate_cal::log_fit::{AxisFit, FittedLog, LogFit};
use zerorate_cal::units::{RateScale, RateUnit};
use zerorate_fit::drift_fit::LogLeft;

use super::number::{decimals_for, fixed, fixed_or_none};
use super::page::Table;

/// What the figures of each log mean.
#[must_use]
pub fn by_log_sentence(fit: &LogFit) -> String {
    format!(
        "What a device has left of each log, in averages over {}, its zero taken in the {}: without a model; by a fit of the \
         other logs, which has not seen this one, as it has not seen the unit's next run; and by the fit of all, this one \
         among them. Where the last is much the smallest, the log brought what the others did not know. Level: how far its rates lie \
         above the fit of all, on average, against the mean of the logs; a device's zero takes that off.",
        fit.averaged_over(),
        fit.zero_taken_in()
    )
}

/// The axes of a unit, log by log; nothing of one log.
pub(super) fn table(fit: &LogFit, unit: RateUnit, scale: RateScale) -> Markup {
    let left = fit.by_log(unit);
    if left.is_empty() {
        return html! {};
    }
    let least = left.iter().map(|(_, _, left)| left.by_all).fold(f64::INFINITY, f64::min);
    let decimals = decimals_for(scale.of_rate(least));
    let row = |(log, axis, left): &(&FittedLog, &AxisFit, LogLeft)| {
        vec![
            html! { (log.name) },
            html! { (axis.name) },
            html! { (fixed(scale.of_rate(left.uncorrected), decimals)) },
            html! { (fixed_or_none(left.by_the_others.map(|left| scale.of_rate(left)), decimals)) },
            html! { (fixed(scale.of_rate(left.by_all), decimals)) },
            html! { (fixed_or_none(left.offset.map(|offset| scale.of_rate(offset)), decimals)) },
        ]
    };
    Table {
        caption: html! { "Each log as the others predict it, rms in " (scale.unit()) ". " (by_log_sentence(fit)) },
        heads: &["Log", "Axis", "Uncorrected", "By a fit of the others", "By the fit of all", "Level"],
        rows: left.iter().map(row).collect(),
        numbers_from: 2,
    }
    .wide_markup()
}
