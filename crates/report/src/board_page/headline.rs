//! The top of the page: the verdict, and the numbers that matter.

use maud::{Markup, html};
use zerorate_board_run::summary::TestResult;

use super::Board;
use super::reading::Known;
use crate::number::{fixed, fixed_or_none, significant};
use crate::page::{self, Table};
use crate::panels::name_of;

/// A bar: class, name, counts, how many times less than before.
struct Bar {
    class: &'static str,
    name: &'static str,
    counts: f64,
    times: Option<String>,
}

pub(super) fn headline(board: &Board) -> Markup {
    let summary = board.summary;
    let failed: Vec<_> = summary.checks.iter().filter(|check| !check.passed).collect();
    html! {
        p.over { "Calibration of a gyroscope’s zero-rate output" }
        h1 { "Unit " (summary.serial) }
        p.over { (which(board)) }
        p { (page::verdict(summary.verdict)) }
        // What speaks against the unit stands before every number that speaks for it.
        @if !failed.is_empty() {
            p { a href="#checks" { (failed.len()) " of " (summary.checks.len()) " checks failed" } ":" }
            ul.reasons { @for check in &failed {
                li { (check.what) ": " b.rejected { (check.measured) } ", limit " (check.limit) "." }
            } }
        }
        @if !summary.warnings.is_empty() {
            ul.reasons { @for warning in &summary.warnings { li { (warning) } } }
        }
        p.lead { (lead(board)) }
        (bars(board))
        (left(board))
        (unit_facts(board))
    }
}

/// Which board it was: of a real one its firmware and when the run began, of a simulated one the plant.
fn which(board: &Board) -> String {
    let (summary, recorded) = (board.summary, &board.run.full_temperature.info);
    let mut words = match &summary.plant {
        Some(plant) => vec![format!("Simulated board, plant {plant}")],
        None => vec!["Real board".to_owned()],
    };
    words.extend(summary.seed.map(|seed| format!("seed {seed}")));
    words.extend(Some(&recorded.firmware).filter(|firmware| !firmware.is_empty()).map(|f| format!("firmware {f}")));
    // A simulated run has no date, so that it gives the same bytes again.
    words.extend(recorded.started.map(|started| started.format("begun %Y-%m-%d %H:%M UTC").to_string()));
    words.join(", ")
}

fn lead(board: &Board) -> Markup {
    let [trim, hybrid] = board.summary.headline();
    let Some(test) = trim.or(hybrid) else {
        return html! { "The drift was fitted; no compensation test was run." };
    };
    let drift = board.summary.drift_pp_counts(test.axis);
    html! {
        "Over one heating ramp" @if let Some(axis) = board.summary.axes.get(test.axis.name()) {
            @let [cold, hot] = axis.drift_temperature_counts();
            ", from " (board.temperature(cold)) " to " (board.temperature(hot)) ","
        }
        " " (name_of(test.axis)) "’s zero-rate output drifted "
        (fixed(drift, 0)) " counts. "
        @if let Some(trim) = trim {
            "Trimmed by the potentiometer, as in the paper, it moves " (fixed(trim.residual_pp_counts, 1))
            " counts, " (trim.times_beside(drift))
            @if hybrid.is_some() { "; " } @else { "." }
        }
        @if let Some(hybrid) = hybrid {
            @if trim.is_none() { "With " } @else { "with " }
            "the remainder subtracted in numbers, " (fixed(hybrid.residual_pp_counts, 1)) " counts, "
            (hybrid.times_beside(drift)) "."
        }
        @if let Some(cooling) = board.summary.cooling() {
            " On the way back down, in mode " (cooling.mode.name()) ", it moves "
            (fixed(cooling.residual_pp_counts, 1)) " counts, " (cooling.times_beside(drift)) "."
        }
    }
}

fn bars(board: &Board) -> Markup {
    let [trim, hybrid] = board.summary.headline();
    let Some(test) = hybrid.or(trim) else {
        return html! {};
    };
    // Of the test's temperatures, as what is left is.
    let before = test.uncompensated_pp_counts;
    let mut bars = vec![Bar { class: "before", name: "before", counts: before, times: None }];
    let after = [("trim", trim), ("hybrid", hybrid)];
    bars.extend(after.into_iter().filter_map(|(name, test)| {
        test.map(|test| Bar { class: "x", name, counts: test.residual_pp_counts, times: Some(test.times()) })
    }));
    bars.extend(test.floor_pp_counts.map(|counts| Bar { class: "floor", name: "floor", counts, times: None }));
    let widest = bars.iter().map(|bar| bar.counts).fold(0.0, f64::max);
    html! {
        dl.bars aria-label={ (name_of(test.axis)) ", peak to peak, heating, held out" } {
            @for bar in &bars {
                dt { (bar.name) }
                dd {
                    span.room { span class={ "bar " (bar.class) } style=(width(bar.counts / widest)) {} }
                    span {
                        b { (fixed(bar.counts, 1)) " counts" }
                        @if let Some(times) = &bar.times { " · " (times) }
                        " " small { (board.rate(bar.counts)) " " (board.rate_unit()) }
                    }
                }
            }
        }
        p.small {
            (name_of(test.axis)) ", peak to peak of group means over the heating ramp; trim and hybrid in second "
            "runs that no fit has seen. "
            @if test.floor_pp_counts.is_some() { "The floor is what noise alone makes; below it is chance." }
            @else { "What of it is noise, which no compensation could take out, is not known on a real bench." }
        }
    }
}

/// What a deployed device has left of each axis: the tests on second ramps, heating and cooling.
fn left(board: &Board) -> Markup {
    let summary = board.summary;
    let limits = summary.checks.len();
    let row = |test: &TestResult| {
        let mut cells = vec![
            html! { (name_of(test.axis)) " " (test.mode.name()) ", " (test.direction.name()) },
            html! { (fixed(test.residual_pp_counts, 1)) },
            html! { (fixed(test.ratio(), 1)) },
            html! { (fixed(test.uncompensated_pp_counts, 1)) },
        ];
        cells.extend(Known::of(summary).floor.then(|| html! { (fixed_or_none(test.floor_pp_counts, 1)) }));
        cells.extend([html! { (board.rate(test.residual_pp_counts)) }, html! { (fixed(test.residual_rms_counts, 2)) }]);
        let by_quadratic = [test.quadratic_pp_counts, test.ratio_to_quadratic()];
        cells.extend(by_quadratic.map(|figure| html! { (fixed_or_none(figure, 1)) }));
        cells
    };
    // What it comes to stands where a narrow screen shows it.
    let mut heads = vec!["Axis, mode, ramp", "Left, pp, counts", "Without / left", "Without, pp, counts"];
    heads.extend(Known::of(summary).floor.then_some("Floor, pp, counts"));
    let in_rates = format!("Left, pp, {}", board.rate_unit());
    heads.extend([in_rates.as_str(), "Left, rms, counts"]);
    heads.extend(["Quadratic, pp, counts", "Quadratic / left"]);
    html! {
        @if !summary.tests.is_empty() {
            (Table {
                caption: html! {
                    b { "What a deployed device has left" } ", in second ramps that no fit has seen, of the axes and ways that were tested; without is the same "
                    "without compensation, and quadratic what a plain quadratic of the full-temperature test, of all its ramps, would have left, taken off in numbers. Against its limits: " a href="#checks" { (limits) " checks" } "."
                },
                heads: &heads,
                rows: summary.tests.iter().map(row).collect(),
                numbers_from: 1,
            }.wide_markup())
        }
    }
}

/// A bar's width, of the room it has.
fn width(share: f64) -> String {
    format!("width:{:.2}%", 100.0 * share.clamp(0.0, 1.0))
}

fn unit_facts(board: &Board) -> Markup {
    let (calibration, summary) = (&board.run.calibration, board.summary);
    let groups = fixed(60.0 / calibration.group_period_s.unwrap_or(f64::NAN), 0);
    let mut facts: Vec<(&str, Markup)> = vec![
        ("Trim part", html! { (summary.trim_part.to_uppercase()) }),
        ("Centre", html! { (fixed(board.centre_counts(), 0)) " counts" }),
        ("Middle tap", html! { (board.middle_tap()) }),
        ("Groups", html! { (board.group_samples()) " samples, " (groups) " a minute" }),
        ("Scale factor", html! { (significant(summary.counts_per_dps, 4)) " counts per deg/s" }),
    ];
    if board.run.full_temperature.rows.iter().all(|row| row.chamber_c.is_nan()) {
        facts.push((
            "Chamber",
            html! { "not driven by the bench: soaks and ramps are seen in the board’s own reading" },
        ));
    }
    facts.extend(calibration.labels.iter().map(|(name, label)| (name.as_str(), html! { (label) })));
    facts.push(("Made by", html! { (calibration.created_by) }));
    page::facts(&facts)
}
