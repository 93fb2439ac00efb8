//! Figures 2 and 3: the full-temperature test and the fitted drift.

use maud::{Markup, html};
use zerorate_cal::units::{RateScale, RateUnit};
use zerorate_fit::intervals;

use super::axis::BoardAxis;
use super::{Board, indexed};
use crate::candidates;
use crate::figure::{Figure, Ink, Mark, Panel, Sample};
use crate::number::{fixed, polynomial, with_error};
use crate::panels;
use crate::paper::PaperAxis;

pub(super) fn chapter(board: &Board) -> Markup {
    html! {
        p {
            "The chamber warmed the unit from cold to hot in one ramp" @if came_back(board) { " and cooled it again" } ", with the potentiometer left at tap "
            (board.middle_tap()) ". Each point is the mean of a group of " (board.group_samples()) " samples."
        }
        (over_time(board).markup())
        (over_temperature(board).markup())
        h3 { "The fitted equation" }
        p { "Zero-rate output " i { "V" } " in counts, as a function of the temperature reading " i { "T" } " in counts." }
        @for axis in &board.axes { (equation(axis)) }
        (what_fits(board))
        div.pair { @for axis in &board.axes { (candidates::table(axis.name, &axis.calibration.fit.statistics, in_counts())) } }
    }
}

/// A board's rates are in counts.
fn in_counts() -> RateScale {
    RateScale::own(RateUnit::Counts)
}

/// Whether the recording ends on the cold side again.
fn came_back(board: &Board) -> bool {
    board.axes.first().is_some_and(|axis| {
        let all = &axis.ramp.temperatures;
        let (min, max) = intervals::ends(all.iter().copied());
        all.last().is_some_and(|last| *last < f64::midpoint(min, max))
    })
}

fn axis_key(board: &Board, sample: Sample) -> Vec<(Ink, Sample, String)> {
    board.axes.iter().map(|axis| (axis.ink, sample, axis.name.to_owned())).collect()
}

/// Figure 2 of the paper.
fn over_time(board: &Board) -> Figure {
    let panel = |title, up, of: fn(&BoardAxis) -> Vec<f64>| {
        let line = |axis: &BoardAxis| Mark::Line(axis.ink, axis.over_time(&of(axis)));
        Panel::new(title, "time, min", up, board.axes.iter().map(line).collect::<Vec<_>>())
    };
    let zero = panel("Zero-rate output against time", "zero-rate output, counts", |axis| axis.ramp.readings.clone());
    let temperature =
        panel("Temperature against time", "temperature reading, counts", |axis| axis.ramp.temperatures.clone());
    let groups = board.axes.first().map_or(0, |axis| axis.ramp.groups.len());
    Figure {
        id: "fig-2".into(),
        name: "Figure 2".into(),
        caption: html! {
            "Full-temperature test: zero-rate output and temperature against time, " (groups) " groups an axis, from "
            (range(board)) "." (board.as_in_the_paper(2))
        },
        key: axis_key(board, Sample::Line),
        columns: vec![vec![zero], vec![temperature]],
    }
}

/// Figure 3 of the paper, with the residual below.
fn over_temperature(board: &Board) -> Figure {
    let residual_range = board.axes.iter().flat_map(BoardAxis::residuals).map(f64::abs).fold(0.0, f64::max);
    let columns = board.axes.iter().map(|axis| {
        let readings = axis.over_temperature(axis.ramp.readings.iter().copied());
        let fit = panels::over_temperature(axis.axis, readings, Some(axis.curve()), board.celsius());
        let left = Panel {
            y_range: (residual_range > 0.0).then_some((-1.1 * residual_range, 1.1 * residual_range)),
            ..panels::residual(axis.axis, axis.over_temperature(axis.residuals()), "the fit")
        };
        vec![fit, left]
    });
    let columns = columns.collect();
    let mut key = axis_key(board, Sample::Dot);
    key.push((Ink::Curve, Sample::Line, "fitted curve".to_owned()));
    Figure {
        id: "fig-3".into(),
        name: "Figure 3".into(),
        caption: html! {
            "Zero-rate output against temperature with the fitted curve; below, what the fit leaves of the run it was made "
            "from (in-sample)." (board.as_in_the_paper(3))
        },
        key,
        columns,
    }
}

fn equation(axis: &BoardAxis) -> Markup {
    let paper = PaperAxis::of(axis.axis);
    html! {
        div.equation {
            p {
                span.from { "This run" } " "
                (indexed("V", axis.axis)) " = "
                @if axis.coefficients().is_empty() { "a table (" (axis.summary.model) ")" }
                @else { (polynomial(axis.coefficients(), "T", 6)) }
            }
            p { span.from { "Paper, eq. (1)" } " " (indexed("V", axis.axis)) " = " (polynomial(&paper.drift, "T", 6)) }
            @if let Some(printed) = paper.printed_linear {
                p.small {
                    "As printed: + " (printed) "\u{a0}" i { "T" } ". See erratum: with the printed sign the reading would "
                    "rise beyond the converter’s range, against the paper’s own text and figures; the sign is turned here."
                }
            }
        }
    }
}

/// The held-out rms with its standard error.
fn held_out(axis: &BoardAxis) -> String {
    let error = axis.calibration.fit.statistics.held_out.and_then(|held_out| held_out.rms_standard_error);
    with_error(axis.summary.held_out_rms_counts.unwrap_or(f64::NAN), error, 2)
}

/// The temperatures of the ramp, of both axes.
fn range(board: &Board) -> String {
    let ends = board.axes.iter().map(|axis| axis.summary.temperature_counts);
    let (cold, hot) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(cold, hot), [a, b]| (cold.min(a), hot.max(b)));
    format!("{} to {}", board.temperature(cold), board.temperature(hot))
}

fn what_fits(board: &Board) -> Markup {
    html! {
        ul {
            @for axis in &board.axes {
                @let drift = axis.summary;
                @let heated = drift.drift_temperature_counts();
                li {
                    b { (axis.name) } ": " (drift.model) ", valid from " (board.temperature(drift.temperature_counts[0])) " to "
                    (board.temperature(drift.temperature_counts[1])) " of temperature"
                    @if let Some(share) = drift.share_of_asked_range {
                        ", " (fixed(100.0 * share, 0)) "\u{a0}% of the way that the set-up asks for"
                    }
                    "; drift " (fixed(drift.drift_pp_counts, 1)) " counts peak to peak over the heating ramp, from "
                    (board.temperature(heated[0])) " to " (board.temperature(heated[1])) "; residual "
                    (fixed(drift.fit_rms_counts, 2)) " counts rms in-sample, "
                    (held_out(axis)) " rms held out"
                    @if let Some(error) = drift.curve_error_counts {
                        "; at most " (fixed(error, 2)) " counts from the simulated plant’s true curve"
                    }
                    "."
                    @if axis.calibration.fit.model.history.is_some() {
                        " It remembers its temperatures: the curve is what is left of it once they have stood still."
                    }
                }
            }
        }
        p.small {
            "Held out: each eighth of the ramp as a fit of the rest predicts it. The ends lie beyond what such a fit has seen, which a "
            "second ramp does not ask for."
        }
    }
}
