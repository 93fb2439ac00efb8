//! This run beside the paper's.

use maud::{Markup, html};
use zerorate_board_run::summary::TestResult;
use zerorate_cal::recording::Phase;
use zerorate_core::compensate::Mode;

use super::Board;
use super::axis::BoardAxis;
use crate::number::{fixed, significant};
use crate::page::Table;
use crate::paper::PaperAxis;

/// What the paper says of its figures, in words: X's and Y's drift of about 400 counts, of which less than 40 are left on
/// X, the axis it compensated.
const PAPER_DRIFT: &str = "about 400";
const PAPER_RESIDUAL: &str = "less than 40";
const PAPER_RATIO: &str = "10";

/// What stands in a row, of a run's axis and of the paper's.
struct Row {
    name: Markup,
    run: fn(&Board, &BoardAxis) -> Markup,
    paper: fn(&PaperAxis) -> Markup,
}

pub(super) fn chapter(board: &Board) -> Markup {
    let mut heads = vec![String::new()];
    for axis in &board.axes {
        heads.extend([format!("{}, this run", axis.name), format!("{}, paper", axis.name)]);
    }
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let mut rows: Vec<Vec<Markup>> = before_and_after().iter().map(|row| cells(board, row)).collect();
    rows.extend(coefficients(board));
    rows.extend(line().iter().map(|row| cells(board, row)));
    html! {
        @if !board.is_papers() {
            p { "This unit is not the paper’s: its coefficients are its own, and only drift, residual and ratio compare." }
        }
        (Table {
            caption: html! {
                "This run beside the paper’s, in counts and taps. The residual is that of a heating ramp, peak to peak, held out; "
                i { "a" } ", " i { "b" } " and " i { "V" } sub { "0" } " are by the paper’s own formula."
            },
            heads: &heads,
            rows,
            numbers_from: 1,
        }.wide_markup())
        p.small {
            "The residual of a potentiometer alone is about one tap, 31 counts peak to peak, where the drift goes through many: a "
            "saw-tooth of whole taps, and the paper’s “less than 40” is that and a little more. Y’s equation is quoted with the sign of its "
            "linear term turned; as printed it is +0.676531 (see erratum), which the paper’s own figures refute."
        }
    }
}

fn none() -> Markup {
    html! { "\u{2013}" }
}

fn cells(board: &Board, row: &Row) -> Vec<Markup> {
    let mut cells = vec![row.name.clone()];
    for axis in &board.axes {
        cells.push((row.run)(board, axis));
        cells.push((row.paper)(PaperAxis::of(axis.axis)));
    }
    cells
}

/// A figure of an axis's heating test by trim, with one decimal.
fn by_trim(board: &Board, axis: &BoardAxis, figure: fn(&TestResult) -> f64) -> Markup {
    let test = board.summary.test(axis.axis, Mode::Trim, Phase::Heating);
    test.map_or_else(none, |test| html! { (fixed(figure(test), 1)) })
}

fn before_and_after() -> [Row; 3] {
    [
        Row {
            name: html! { "drift, peak to peak" },
            run: |_, axis| html! { (fixed(axis.summary.drift_pp_counts, 1)) },
            paper: |_| html! { (PAPER_DRIFT) },
        },
        Row {
            name: html! { "residual by trim" },
            run: |board, axis| by_trim(board, axis, |test| test.residual_pp_counts),
            paper: |paper| {
                if paper.compensated {
                    html! { (PAPER_RESIDUAL) }
                } else {
                    none()
                }
            },
        },
        Row {
            name: html! { "drift / residual, peak to peak" },
            run: |board, axis| by_trim(board, axis, TestResult::ratio),
            paper: |paper| {
                if paper.compensated {
                    html! { (PAPER_RATIO) }
                } else {
                    none()
                }
            },
        },
    ]
}

/// One row a power of the temperature, the highest first.
fn coefficients(board: &Board) -> Vec<Vec<Markup>> {
    let powers = board.axes.iter().map(|axis| axis.coefficients().len()).max().unwrap_or(0);
    let row = |power: usize| {
        let mut cells = vec![html! {
            "coefficient of "
            @match power { 0 => "1", 1 => i { "T" }, _ => { i { "T" } sup { (power) } } }
        }];
        for axis in &board.axes {
            let written = |coefficient: Option<&f64>| coefficient.map_or_else(none, |value| significant(*value, 6));
            cells.push(written(axis.coefficients().get(power)));
            cells.push(written(PaperAxis::of(axis.axis).drift.get(power)));
        }
        cells
    };
    (0..powers).rev().map(row).collect()
}

fn line() -> [Row; 3] {
    [
        Row {
            name: html! { i { "a" } ", taps per count" },
            run: |_, axis| significant(axis.paper.slope_taps_per_count, 6),
            paper: |paper| significant(paper.slope_taps_per_count, 6),
        },
        Row {
            name: html! { i { "b" } ", taps" },
            run: |_, axis| html! { (fixed(axis.paper.intercept_taps, 4)) },
            paper: |paper| html! { (fixed(paper.intercept_taps, 4)) },
        },
        Row {
            name: html! { i { "V" } sub { "0" } ", counts" },
            run: |_, axis| html! { (fixed(axis.paper.centre_counts, 1)) },
            paper: |paper| html! { (fixed(paper.centre_counts, 1)) },
        },
    ]
}
