//! What was checked, and what the words mean.

use maud::{Markup, html};
use zerorate_board_run::summary::{Check, Summary, TestResult};

use super::Board;
use crate::page::{self, Table};

pub(super) fn checks(checks: &[Check]) -> Markup {
    let failed = checks.iter().filter(|check| !check.passed).count();
    let row = |check: &Check| {
        vec![
            html! { span.wrap { (check.what) } },
            html! { (check.limit) },
            html! { (check.measured) },
            html! { @if check.passed { span.good { "✓\u{a0}passed" } } @else { span.rejected { "✕\u{a0}failed" } } },
        ]
    };
    html! {
        p {
            @if checks.is_empty() { "Nothing was checked against a limit." }
            @else if failed == 0 { "All " (checks.len()) " checks passed." }
            @else { (failed) " of " (checks.len()) " checks failed." }
        }
        @if !checks.is_empty() {
            (Table {
                caption: html! { "Checks and their limits." },
                heads: &["What", "Limit", "Measured", "Result"],
                rows: checks.iter().map(row).collect(),
                numbers_from: 4,
            }.markup())
        }
    }
}

/// What the tests know that a real bench does not.
pub(super) struct Known {
    pub floor: bool,
    pub taps_crossed: bool,
}

impl Known {
    pub(super) fn of(summary: &Summary) -> Self {
        let any = |of: fn(&TestResult) -> bool| summary.tests.iter().any(of);
        Self {
            floor: any(|test| test.floor_pp_counts.is_some()),
            taps_crossed: any(|test| test.taps_crossed.is_some()),
        }
    }
}

pub(super) fn definitions(board: &Board) -> Markup {
    let Known { floor, taps_crossed } = Known::of(board.summary);
    let mut terms: Vec<(&str, Markup)> = vec![
        ("Zero-rate output", html! { "The reading at rest. Its change with temperature is the drift." }),
        (
            "Counts",
            html! {
                "Steps of the A/D converter. Temperature is in counts of its own channel; the device never converts it."
                @if board.celsius().is_some() { " Degrees C beside them are by the set-up’s scale; a part’s own is some degrees off." }
            },
        ),
        (
            "Group",
            html! { "The mean of " (board.group_samples()) " successive samples. All peak to peak and rms figures are of group means." },
        ),
        (
            "Peak to peak",
            html! { "The highest less the lowest group mean of the ramp. One outlying group is enough to raise it." },
        ),
        ("rms", html! { "Root mean square. Of a fit: about the curve. Of a test: about the axis’s mean." }),
        ("In-sample", html! { "Measured on the data that a fit was made from: as a rule a little too good." }),
        (
            "Held out",
            html! { "Measured on data that the fit has not seen: a contiguous fold predicted by the fit of the others, or another run." },
        ),
    ];
    terms.push((
        "Floor",
        html! {
            @if floor {
                "The same groups once the simulated plant’s own true drift and true wiper voltage are taken away: noise, flicker "
                "and random walk. A compensation comes below it by chance alone."
            } @else {
                "What noise alone would leave. A real bench cannot know it, and none is given: mode hybrid is held against what "
                "mode trim leaves."
            }
        },
    ));
    terms.push((
        "Trim, hybrid",
        html! {
            "Trim is the paper’s way: the potentiometer alone, in whole taps, so a saw-tooth of one tap is left. Hybrid subtracts "
            "what is left between taps in numbers."
        },
    ));
    terms.push((
        if taps_crossed { "Writes / taps crossed" } else { "Writes" },
        html! {
            @if taps_crossed {
                "Writes to the wiper beside the taps that the law without noise crosses from where the ramp began. More writes than "
                "taps crossed is chatter: each is a step of one tap. At an end of the ramp noise may save one."
            } @else {
                "Writes to the wiper. How many the law without noise would make needs the temperature without noise, which a real "
                "bench does not know."
            }
        },
    ));
    terms.push((
        "Largest step",
        html! {
            "The largest jump of the corrected samples, low-passed by 20, in the second after a tap change, less its size "
            "elsewhere: what a control loop would feel."
        },
    ));
    page::terms(&terms)
}
