//! Figure 6: what is left once an axis is compensated, against time and against temperature.

use maud::{Markup, html};

use super::ink_of;
use crate::calibration::{CalibrationReport, CompensationTest, Direction, TestPoint};
use crate::figure::{Figure, Ink, Mark, Panel, Sample, holding};
use crate::number::{fixed, whole};
use crate::page::Table;

/// Seconds in a minute: figures show time in minutes.
const MINUTE_S: f64 = 60.0;

pub(super) fn chapter(report: &CalibrationReport) -> Markup {
    let figures = figures(report);
    html! {
        p {
            "The same profile again, with the law on the device: one axis compensated, the other left alone as the control. "
            "Heating repeats the direction of the ramp that was fitted, so hysteresis cancels; cooling is the honest second "
            "test. With the axes swapped, each has been the other’s control."
        }
        @for figure in &figures { (figure.markup()) }
        (table(report))
    }
}

/// Tests of one axis in one direction, or of one axis in both: what stands in one figure.
fn alike(
    report: &CalibrationReport,
    same: impl Fn(&CompensationTest, &CompensationTest) -> bool,
) -> Vec<Vec<&CompensationTest>> {
    let mut sets: Vec<Vec<&CompensationTest>> = Vec::new();
    for test in report.tests.iter().filter(|test| !test.points.is_empty()) {
        match sets.iter_mut().find(|set| same(set[0], test)) {
            Some(set) => set.push(test),
            None => sets.push(vec![test]),
        }
    }
    sets
}

fn figures(report: &CalibrationReport) -> Vec<Figure> {
    let over_time = alike(report, |a, b| a.axis == b.axis && a.direction == b.direction);
    let over_temperature = alike(report, |a, b| a.axis == b.axis);
    let times = over_time.iter().map(|set| against_time(report, set));
    let mut figures: Vec<Figure> = times.collect();
    figures.extend(over_temperature.iter().map(|set| against_temperature(report, set)));
    for (figure, letter) in figures.iter_mut().zip('a'..) {
        figure.id = format!("fig-6{letter}");
        figure.name = format!("Figure 6{letter}");
    }
    figures
}

fn points(test: &CompensationTest, of: impl Fn(&TestPoint) -> (f64, f64)) -> Vec<(f64, f64)> {
    test.points.iter().map(of).collect()
}

fn against_time(report: &CalibrationReport, set: &[&CompensationTest]) -> Figure {
    let first = set[0];
    let all = set.iter().flat_map(|test| &test.points).flat_map(|p| [p.compensated_counts, p.control_counts]);
    let range = holding(all);
    let column = |test: &&CompensationTest| {
        let title = format!("{} in mode {}, {}: both axes against time", test.axis, test.mode, test.direction);
        let marks = [
            Mark::Level(Ink::Aim, report.unit.centre_counts),
            Mark::Line(ink_of(report, &test.control), points(test, |p| (p.elapsed_s / MINUTE_S, p.control_counts))),
            Mark::Line(ink_of(report, &test.axis), points(test, |p| (p.elapsed_s / MINUTE_S, p.compensated_counts))),
        ];
        let name = format!("mode {}: reading, counts", test.mode);
        vec![Panel { y_range: range, ..Panel::new(title, "time, min", name, marks) }]
    };
    let swapped = report.tests.first().is_some_and(|test| test.axis != first.axis);
    Figure {
        id: String::new(),
        name: String::new(),
        caption: html! {
            "Compensation test, " (first.direction) @if swapped { ", axes swapped" } ": "
            (first.axis) " compensated, " (first.control) " left alone as the control"
            @for test in set {
                "; " (test.mode) ": " (fixed(test.residual_pp_counts, 1)) " against " (fixed(test.control_pp_counts, 0))
                " counts peak to peak"
            }
            "." @if first.direction == Direction::Heating && !swapped { " (The paper’s figure 6.)" }
        },
        key: vec![
            (ink_of(report, &first.axis), Sample::Line, format!("{}, compensated", first.axis)),
            (ink_of(report, &first.control), Sample::Line, format!("{}, control", first.control)),
            (Ink::Aim, Sample::Line, "centre".to_owned()),
        ],
        columns: set.iter().map(column).collect(),
    }
}

fn against_temperature(report: &CalibrationReport, set: &[&CompensationTest]) -> Figure {
    let centre = report.unit.centre_counts;
    let directions = |wanted| set.iter().any(|test| test.direction == wanted);
    let range = holding(set.iter().flat_map(|test| &test.points).map(|point| point.compensated_counts - centre));
    let mut modes: Vec<_> = set.iter().map(|test| test.mode).collect();
    modes.dedup();
    modes.sort_by_key(|mode| set.iter().position(|test| test.mode == *mode));
    modes.dedup();
    let column = |mode| {
        let name = &set[0].axis;
        let title = format!("{name} in mode {mode}: residual against temperature");
        let mut marks = vec![Mark::Level(Ink::Aim, 0.0)];
        for test in set.iter().filter(|test| test.mode == mode) {
            let residual = points(test, |p| (p.temperature_counts, p.compensated_counts - centre));
            marks.push(Mark::Dots(direction_ink(test.direction), residual));
        }
        let (across, up) = (format!("{name} temperature reading, counts"), format!("mode {mode}: residual, counts"));
        vec![Panel { y_range: range, ..Panel::new(title, across, up, marks) }]
    };
    let mut key = Vec::new();
    for direction in [Direction::Heating, Direction::Cooling] {
        if directions(direction) {
            key.push((direction_ink(direction), Sample::Dot, direction.to_string()));
        }
    }
    Figure {
        id: String::new(),
        name: String::new(),
        caption: html! {
            (set[0].axis) "’s residual, reading less centre, against temperature."
            @if directions(Direction::Heating) && directions(Direction::Cooling) {
                " The distance between heating and cooling is thermal hysteresis, which no function of temperature alone can "
                "take out."
            }
        },
        key,
        columns: modes.into_iter().map(column).collect(),
    }
}

fn direction_ink(direction: Direction) -> Ink {
    match direction {
        Direction::Heating => Ink::Heating,
        Direction::Cooling => Ink::Cooling,
    }
}

fn table(report: &CalibrationReport) -> Markup {
    let row = |test: &CompensationTest| {
        vec![
            html! { (test.axis) " " (test.mode) ", " (test.direction) },
            html! { (test.control) },
            html! { (fixed(test.residual_pp_counts, 1)) },
            html! { (fixed(test.residual_rms_counts, 2)) },
            html! { (fixed(test.control_pp_counts, 1)) },
            html! { (fixed(test.uncompensated_pp_counts, 1)) },
            html! { (fixed(test.ratio(), 1)) },
            html! { (fixed(test.floor_pp_counts, 1)) },
            html! { (whole(test.wiper_writes.into())) "\u{a0}/\u{a0}" (whole(test.taps_crossed.into())) },
            html! { (fixed(test.mean_counts, 1)) },
            html! { (fixed(test.largest_step_counts, 2)) },
        ]
    };
    let heads = [
        "Test",
        "Control",
        "Residual, pp",
        "Residual, rms",
        "Control, pp",
        "Without, pp",
        "Ratio",
        "Floor, pp",
        "Writes / taps crossed",
        "Mean",
        "Largest step",
    ];
    Table {
        caption: html! {
            b { "The tests" } ", in counts; pp is peak to peak of group means over the hour, rms root mean square. All of them are "
            "held out: the law was fitted to another run. Without is what the axis did in the full-temperature test, and the "
            "ratio is of that to the residual."
        },
        heads: &heads,
        rows: report.tests.iter().map(row).collect(),
        numbers_from: 2,
    }
    .markup()
}
