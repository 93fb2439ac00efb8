//! Figure 6: what is left once an axis is compensated, against time and against temperature.

use maud::{Markup, html};
use zerorate_board_run::folder::BoardRun;
use zerorate_board_run::summary::{Summary, TestResult};
use zerorate_cal::recording::{GroupRow, Phase};
use zerorate_core::compensate::Mode;

use super::Board;
use super::reading::Known;
use crate::figure::{Figure, Ink, Mark, Panel, Sample, holding};
use crate::number::{fixed, fixed_or_none, whole};
use crate::page::Table;
use crate::panels::{MINUTE_S, ink_of, name_of};

/// A compensation test with its groups, in order of time: the compensated axis, and the control.
struct Test<'a> {
    result: &'a TestResult,
    groups: Vec<(&'a GroupRow, &'a GroupRow)>,
}

impl<'a> Test<'a> {
    fn of(run: &'a BoardRun, result: &'a TestResult) -> Self {
        let groups = run.tests.iter().flat_map(|recording| recording.rows.chunk_by(|a, b| a.group == b.group));
        let pair = |group: &'a [GroupRow]| {
            let row = |axis| group.iter().find(|row| row.axis == axis && row.phase == result.direction);
            Some((row(result.axis).filter(|row| row.mode == result.mode)?, row(result.control)?))
        };
        Self { result, groups: groups.filter_map(pair).collect() }
    }

    /// Values of the groups over minutes since the ramp began.
    fn over_time(&self, of: impl Fn(&(&GroupRow, &GroupRow)) -> f64) -> Vec<(f64, f64)> {
        let began = self.groups.first().map_or(0.0, |(row, _)| row.t_s);
        self.groups.iter().map(|group| ((group.0.t_s - began) / MINUTE_S, of(group))).collect()
    }
}

/// The reading of an axis that was left alone, counts.
fn reading(row: &GroupRow) -> f64 {
    row.sums.mean_zro().0
}

pub(super) fn chapter(board: &Board) -> Markup {
    let figures = figures(board);
    html! {
        p {
            "The same profile again, with the law on the device: one axis compensated, the other left alone as the control. "
            "Heating repeats the direction of the ramp that was fitted, so hysteresis cancels; cooling is the honest second "
            "test. With the axes swapped, each has been the other’s control."
        }
        @for figure in &figures { (figure.markup()) }
        (table(board.summary))
    }
}

/// Tests of one axis in one direction, or of one axis in both: what stands in one figure.
fn alike<'t, 'a>(tests: &'t [Test<'a>], same: impl Fn(&TestResult, &TestResult) -> bool) -> Vec<Vec<&'t Test<'a>>> {
    let mut sets: Vec<Vec<&Test>> = Vec::new();
    for test in tests.iter().filter(|test| !test.groups.is_empty()) {
        match sets.iter_mut().find(|set| same(set[0].result, test.result)) {
            Some(set) => set.push(test),
            None => sets.push(vec![test]),
        }
    }
    sets
}

fn figures(board: &Board) -> Vec<Figure> {
    let tests: Vec<Test> = board.summary.tests.iter().map(|result| Test::of(board.run, result)).collect();
    let over_time = alike(&tests, |a, b| a.axis == b.axis && a.direction == b.direction);
    let over_temperature = alike(&tests, |a, b| a.axis == b.axis);
    let times = over_time.iter().map(|set| against_time(board, set));
    let mut figures: Vec<Figure> = times.collect();
    figures.extend(over_temperature.iter().map(|set| against_temperature(board, set)));
    for (figure, letter) in figures.iter_mut().zip('a'..) {
        figure.id = format!("fig-6{letter}");
        figure.name = format!("Figure 6{letter}");
    }
    figures
}

fn against_time(board: &Board, set: &[&Test]) -> Figure {
    let first = set[0].result;
    let (axis, control) = (name_of(first.axis), name_of(first.control));
    let groups = set.iter().flat_map(|test| &test.groups);
    let range = holding(groups.flat_map(|(row, control)| [row.corrected_counts, reading(control)]));
    let column = |test: &&Test| {
        let TestResult { mode, direction, .. } = test.result;
        let title = format!("{axis} in mode {}, {}: both axes against time", mode.name(), direction.name());
        let marks = [
            Mark::Level(Ink::Aim, board.centre_counts()),
            Mark::Line(ink_of(first.control), test.over_time(|(_, control)| reading(control))),
            Mark::Line(ink_of(first.axis), test.over_time(|(row, _)| row.corrected_counts)),
        ];
        let up = format!("mode {}: reading, counts", mode.name());
        vec![Panel { y_range: range, ..Panel::new(title, "time, min", up, marks) }]
    };
    let swapped = board.summary.tests.first().is_some_and(|test| test.axis != first.axis);
    Figure {
        id: String::new(),
        name: String::new(),
        caption: html! {
            "Compensation test, " (first.direction.name()) @if swapped { ", axes swapped" } ": "
            (axis) " compensated, " (control) " left alone as the control"
            @for TestResult { mode, residual_pp_counts, control_pp_counts, .. } in set.iter().map(|test| test.result) {
                "; " (mode.name()) ": " (fixed(*residual_pp_counts, 1)) " against " (fixed(*control_pp_counts, 0))
                " counts peak to peak"
            }
            "." @if first.direction == Phase::Heating && !swapped { (board.as_in_the_paper(6)) }
        },
        key: vec![
            (ink_of(first.axis), Sample::Line, format!("{axis}, compensated")),
            (ink_of(first.control), Sample::Line, format!("{control}, control")),
            (Ink::Aim, Sample::Line, "centre".to_owned()),
        ],
        columns: set.iter().map(column).collect(),
    }
}

fn against_temperature(board: &Board, set: &[&Test]) -> Figure {
    let name = name_of(set[0].result.axis);
    let centre = board.centre_counts();
    let directions = |wanted| set.iter().any(|test| test.result.direction == wanted);
    let range = holding(set.iter().flat_map(|test| &test.groups).map(|(row, _)| row.corrected_counts - centre));
    let mut modes: Vec<Mode> = Vec::new();
    for test in set {
        if !modes.contains(&test.result.mode) {
            modes.push(test.result.mode);
        }
    }
    let column = |mode: Mode| {
        let title = format!("{name} in mode {}: residual against temperature", mode.name());
        let mut marks = vec![Mark::Level(Ink::Aim, 0.0)];
        for test in set.iter().filter(|test| test.result.mode == mode) {
            let residual = |(row, _): &(&GroupRow, _)| (row.sums.mean_temperature().0, row.corrected_counts - centre);
            let residuals = test.groups.iter().map(residual).collect();
            marks.push(Mark::Dots(direction_ink(test.result.direction), residuals));
        }
        let across = format!("{name} temperature reading, counts");
        let up = format!("mode {}: residual, counts", mode.name());
        vec![Panel { y_range: range, second: board.celsius(), ..Panel::new(title, across, up, marks) }]
    };
    let mut key = Vec::new();
    for direction in [Phase::Heating, Phase::Cooling] {
        if directions(direction) {
            key.push((direction_ink(direction), Sample::Dot, direction.name().to_owned()));
        }
    }
    Figure {
        id: String::new(),
        name: String::new(),
        caption: html! {
            (name) "’s residual, reading less centre, against temperature."
            @if directions(Phase::Heating) && directions(Phase::Cooling) {
                " The distance between heating and cooling is thermal hysteresis, which no function of temperature alone can "
                "take out."
            }
        },
        key,
        columns: modes.into_iter().map(column).collect(),
    }
}

fn direction_ink(direction: Phase) -> Ink {
    if direction == Phase::Cooling { Ink::Cooling } else { Ink::Heating }
}

fn table(summary: &Summary) -> Markup {
    let Known { floor, taps_crossed } = Known::of(summary);
    let temperatures = summary.tests.iter().any(|test| test.temperature_counts.is_some());
    let row = |test: &TestResult| {
        let writes = match test.taps_crossed {
            Some(crossed) => html! { (whole(test.wiper_writes.into())) "\u{a0}/\u{a0}" (whole(crossed.into())) },
            None => html! { (whole(test.wiper_writes.into())) },
        };
        let mut cells = vec![
            html! { (name_of(test.axis)) " " (test.mode.name()) ", " (test.direction.name()) },
            html! { (name_of(test.control)) },
            html! { (fixed(test.residual_pp_counts, 1)) },
            html! { (fixed(test.residual_rms_counts, 2)) },
            html! { (fixed(test.control_pp_counts, 1)) },
            html! { (fixed(test.uncompensated_pp_counts, 1)) },
            html! { (fixed(test.ratio(), 1)) },
        ];
        cells.extend(temperatures.then(|| match test.temperature_counts {
            Some([cold, hot]) => html! { (fixed(cold, 0)) " to " (fixed(hot, 0)) },
            None => html! { "–" },
        }));
        cells.extend(floor.then(|| html! { (fixed_or_none(test.floor_pp_counts, 1)) }));
        cells.extend([writes, html! { (fixed(test.mean_counts, 1)) }, html! { (fixed(test.largest_step_counts, 2)) }]);
        cells
    };
    let mut heads = vec!["Test", "Control", "Residual, pp", "Residual, rms", "Control, pp", "Without, pp", "Ratio"];
    heads.extend(temperatures.then_some("Temperatures"));
    heads.extend(floor.then_some("Floor, pp"));
    heads.extend([if taps_crossed { "Writes / taps crossed" } else { "Writes" }, "Mean", "Largest step"]);
    Table {
        caption: html! {
            b { "The tests" } ", in counts; pp is peak to peak of group means over the ramp, rms root mean square. All of them are "
            "held out: the law was fitted to another run. Without is what the axis does in the same direction without "
            "compensation, and the ratio is of that to the residual; where the full-temperature test had no ramp in that "
            "direction, or one between other temperatures, it is the test’s own, the measured effect of its taps taken away."
        },
        heads: &heads,
        rows: summary.tests.iter().map(row).collect(),
        numbers_from: 2,
    }
    .wide_markup()
}
