//! Figures 2 and 3: the full-temperature test and the fitted drift.

use maud::{Markup, html};

use super::{indexed, ink_of};
use crate::calibration::{CalibratedAxis, CalibrationReport, RampPoint};
use crate::candidates;
use crate::figure::{Figure, Ink, Mark, Panel, Sample};
use crate::number::{fixed, polynomial};
use crate::paper::PaperAxis;

/// Seconds in a minute: figures show time in minutes.
const MINUTE_S: f64 = 60.0;

pub(super) fn chapter(report: &CalibrationReport) -> Markup {
    html! {
        p {
            "The chamber warmed the unit from cold to hot in one ramp" @if came_back(report) { " and cooled it again" } ", with the potentiometer left at tap "
            (report.unit.middle_tap) ". Each point is the mean of a group of " (report.unit.group_samples) " samples."
        }
        (over_time(report).markup())
        (over_temperature(report).markup())
        h3 { "The fitted equation" }
        p { "Zero-rate output " i { "V" } " in counts, as a function of the temperature reading " i { "T" } " in counts." }
        @for axis in &report.axes { (equation(axis)) }
        (what_fits(report))
        div.pair { @for axis in &report.axes { (candidates::table(&axis.name, &axis.drift.candidates, "counts")) } }
    }
}

/// Whether the recording ends on the cold side again.
fn came_back(report: &CalibrationReport) -> bool {
    let temperatures = |axis: &CalibratedAxis| -> Vec<f64> { axis.ramp.iter().map(|p| p.temperature_counts).collect() };
    report.axes.first().map(temperatures).is_some_and(|all| {
        let (min, max) = all.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), t| (t.min(min), t.max(max)));
        all.last().is_some_and(|last| *last < f64::midpoint(min, max))
    })
}

fn series(axis: &CalibratedAxis, of: impl Fn(&RampPoint) -> (f64, f64)) -> Vec<(f64, f64)> {
    axis.ramp.iter().map(of).collect()
}

fn axis_key(report: &CalibrationReport, sample: Sample) -> Vec<(Ink, Sample, String)> {
    report.axes.iter().map(|axis| (ink_of(report, &axis.name), sample, axis.name.clone())).collect()
}

/// Figure 2 of the paper.
fn over_time(report: &CalibrationReport) -> Figure {
    let lines = |of: fn(&RampPoint) -> f64| -> Vec<Mark> {
        let line = |axis: &CalibratedAxis| {
            Mark::Line(ink_of(report, &axis.name), series(axis, |p| (p.elapsed_s / MINUTE_S, of(p))))
        };
        report.axes.iter().map(line).collect()
    };
    let zero = lines(|p| p.zro_counts);
    let zero = Panel::new("Zero-rate output against time", "time, min", "zero-rate output, counts", zero);
    let temperature = lines(|p| p.temperature_counts);
    let temperature = Panel::new("Temperature against time", "time, min", "temperature reading, counts", temperature);
    let groups = report.axes.first().map_or(0, |axis| axis.ramp.len());
    Figure {
        id: "fig-2".into(),
        name: "Figure 2".into(),
        caption: html! {
            "Full-temperature test: zero-rate output and temperature against time, " (groups)
            " groups an axis. (The paper’s figure 2.)"
        },
        key: axis_key(report, Sample::Line),
        columns: vec![vec![zero], vec![temperature]],
    }
}

/// Figure 3 of the paper, with the residual below.
fn over_temperature(report: &CalibrationReport) -> Figure {
    let residual_range = report
        .axes
        .iter()
        .flat_map(|axis| axis.ramp.iter().map(|point| (point.zro_counts - point.fitted_counts).abs()))
        .fold(0.0, f64::max);
    let columns = report.axes.iter().map(|axis| {
        let ink = ink_of(report, &axis.name);
        let name = &axis.name;
        let temperature = "temperature reading, counts";
        let fit = Panel::new(
            format!("{name}: zero-rate output against temperature"),
            temperature,
            format!("{name}: zero-rate output, counts"),
            [
                Mark::Dots(ink, series(axis, |p| (p.temperature_counts, p.zro_counts))),
                Mark::Line(Ink::Curve, axis.fitted_curve()),
            ],
        );
        let residual = [
            Mark::Dots(ink, series(axis, |p| (p.temperature_counts, p.zro_counts - p.fitted_counts))),
            Mark::Level(Ink::Aim, 0.0),
        ];
        let (title, up) = (format!("{name}: residual of the fit"), format!("{name}: residual, counts"));
        let left = Panel {
            height: Panel::SHORT,
            y_range: (residual_range > 0.0).then_some((-1.1 * residual_range, 1.1 * residual_range)),
            ..Panel::new(title, temperature, up, residual)
        };
        vec![fit, left]
    });
    let columns = columns.collect();
    let mut key = axis_key(report, Sample::Dot);
    key.push((Ink::Curve, Sample::Line, "fitted curve".to_owned()));
    Figure {
        id: "fig-3".into(),
        name: "Figure 3".into(),
        caption: html! {
            "Zero-rate output against temperature with the fitted curve; below, what the fit leaves of the run it was made "
            "from (in-sample). (The paper’s figure 3.)"
        },
        key,
        columns,
    }
}

fn equation(axis: &CalibratedAxis) -> Markup {
    let paper = PaperAxis::named(&axis.name);
    let drift = &axis.drift;
    html! {
        div.equation {
            p {
                span.from { "This run" } " "
                (indexed("V", &axis.name)) " = "
                @if drift.raw_coefficients.is_empty() { "a table (" (drift.model) ")" }
                @else { (polynomial(&drift.raw_coefficients, "T", 6)) }
            }
            @if let Some(paper) = paper {
                p { span.from { "Paper, eq. (1)" } " " (indexed("V", &axis.name)) " = " (polynomial(&paper.drift, "T", 6)) }
                @if let Some(printed) = paper.printed_linear {
                    p.small {
                        "As printed: + " (printed) "\u{a0}" i { "T" } ". See erratum: with the printed sign the reading would "
                        "rise beyond the converter’s range, against the paper’s own text and figures; the sign is turned here."
                    }
                }
            }
        }
    }
}

fn what_fits(report: &CalibrationReport) -> Markup {
    html! {
        ul {
            @for axis in &report.axes {
                @let drift = &axis.drift;
                li {
                    b { (axis.name) } ": " (drift.model) ", valid from " (fixed(drift.temperature_counts[0], 0)) " to "
                    (fixed(drift.temperature_counts[1], 0)) " counts of temperature; drift "
                    (fixed(drift.drift_pp_counts, 1)) " counts peak to peak; residual "
                    (fixed(drift.fit_rms_counts, 2)) " counts rms in-sample, "
                    (fixed(drift.held_out_rms_counts, 2)) " rms held out"
                    @if let Some(error) = drift.curve_error_counts {
                        "; at most " (fixed(error, 2)) " counts from the simulated plant’s true curve"
                    }
                    "."
                    @if drift.remembers {
                        " It remembers its temperatures: the equation is what it leans on until it has seen enough of them."
                    }
                }
            }
        }
    }
}
