//! What was measured before and after, and the limits.

use maud::{Markup, html};
use zerorate_board_run::folder::BoardRun;
use zerorate_board_run::summary::{Check, TestResult};

use zerorate_core::units::Counts;

use super::dps;
use crate::number::fixed;
use crate::page::Table;
use crate::panels::name_of;

pub(super) fn section(run: &BoardRun) -> Markup {
    let summary = &run.summary;
    let row = |test: &TestResult| {
        vec![
            html! { (name_of(test.axis)) " " (test.mode.name()) ", " (test.direction.name()) },
            html! { (fixed(test.uncompensated_pp_counts, 1)) },
            dps(summary, test.uncompensated_pp_counts),
            html! { (fixed(test.residual_pp_counts, 1)) },
            dps(summary, test.residual_pp_counts),
            off_centre(run, test),
            range(run, test),
        ]
    };
    html! {
        section {
            h2 { "Result" }
            @if summary.tests.is_empty() { p { "The drift was fitted; no compensation test was run." } }
            @else {
                (Table {
                    caption: html! {
                        "Zero-rate output, peak to peak of group means: the drift without compensation, and the residual with it in a "
                        "second ramp that no fit has seen; mean is that of the second ramp less the centre, as U below is."
                        @if run.calibration.celsius_scale().is_some() {
                            " Temperatures are the gyro’s own by the set-up’s scale, and a part’s own scale is some degrees off."
                        }
                    },
                    heads: &["Axis, mode, ramp", "Drift, counts", "Drift, deg/s", "Residual, counts", "Residual, deg/s", "Mean, counts", "Temperature"],
                    rows: summary.tests.iter().map(row).collect(),
                    numbers_from: 1,
                }.wide_markup())
            }
            (checks(&summary.checks))
        }
    }
}

/// The mean of a test's ramp less the counts that the axis is led to.
fn off_centre(run: &BoardRun, test: &TestResult) -> Markup {
    let trim = run.calibration.axes.get(test.axis.name()).and_then(|axis| axis.trim.as_ref());
    html! { @match trim {
        Some(trim) => (fixed(test.mean_counts - trim.trim.line.centre().0, 1)),
        None => "\u{2013}",
    } }
}

/// The temperatures of a test's ramp: degrees C where the set-up has a scale, else counts.
fn range(run: &BoardRun, test: &TestResult) -> Markup {
    let Some([cold, hot]) = test.temperature_counts else { return html! { "\u{2013}" } };
    match run.calibration.celsius_scale() {
        Some(scale) => {
            let celsius = |counts: f64| fixed(scale.celsius(Counts(counts)).0, 1);
            html! { (celsius(cold)) " to " (celsius(hot)) "\u{a0}°C" }
        }
        None => html! { (fixed(cold, 0)) " to " (fixed(hot, 0)) " counts" },
    }
}

fn checks(checks: &[Check]) -> Markup {
    html! {
        @if !checks.is_empty() {
            h3 { "Limits" }
            ul.checks { @for check in checks {
                li {
                    @if check.passed { span.good { "✓" } } @else { b.rejected { "✕ failed" } }
                    " " (check.what) ": " (check.measured) ", limit " (check.limit)
                }
            } }
        }
    }
}
