//! The top of the page: the verdict, and the numbers that matter.

use maud::{Markup, html};

use crate::calibration::{CalibrationReport, CompensationTest, Direction, Mode};
use crate::number::{fixed, significant};
use crate::page;

/// A bar: class, name, counts, how many times smaller than before.
struct Bar {
    class: &'static str,
    name: &'static str,
    counts: f64,
    ratio: Option<f64>,
}

pub(super) fn headline(report: &CalibrationReport) -> Markup {
    let unit = &report.unit;
    let failed: Vec<_> = report.checks.iter().filter(|check| !check.pass).collect();
    html! {
        p.over { "Calibration of a gyroscope’s zero-rate output" }
        h1 { "Unit " (unit.serial) }
        p { (page::verdict(report.verdict)) }
        p.lead { (lead(report)) }
        (bars(report))
        @if !failed.is_empty() {
            p { a href="#checks" { (failed.len()) " of " (report.checks.len()) " checks failed" } ":" }
            ul.reasons { @for check in &failed {
                li { (check.what) ": " b.rejected { (check.measured) } ", limit " (check.limit) "." }
            } }
        }
        @if !report.warnings.is_empty() {
            ul.reasons { @for warning in &report.warnings { li { (warning) } } }
        }
        (unit_facts(report))
    }
}

/// The first axis's test in a mode, heating.
fn heating(report: &CalibrationReport, mode: Mode) -> Option<&CompensationTest> {
    let axis = &report.tests.first()?.axis;
    let is_it =
        |test: &&CompensationTest| test.mode == mode && test.axis == *axis && test.direction == Direction::Heating;
    report.tests.iter().find(is_it)
}

fn lead(report: &CalibrationReport) -> Markup {
    let (trim, hybrid) = (heating(report, Mode::Trim), heating(report, Mode::Hybrid));
    let Some(test) = trim.or(hybrid) else {
        return html! { "The drift was fitted; no compensation test was run." };
    };
    html! {
        "Over one heating ramp, " (test.axis) "’s zero-rate output drifted "
        (fixed(test.uncompensated_pp_counts, 0)) " counts. "
        @if let Some(trim) = trim {
            "Trimmed by the potentiometer, as in the paper, it moves " (fixed(trim.residual_pp_counts, 1))
            " counts, " (fixed(trim.ratio(), 0)) " times less"
            @if hybrid.is_some() { "; " } @else { "." }
        }
        @if let Some(hybrid) = hybrid {
            @if trim.is_none() { "With " } @else { "with " }
            "the remainder subtracted in numbers, " (fixed(hybrid.residual_pp_counts, 1)) " counts, "
            (fixed(hybrid.ratio(), 0)) " times less."
        }
    }
}

fn bars(report: &CalibrationReport) -> Markup {
    let (trim, hybrid) = (heating(report, Mode::Trim), heating(report, Mode::Hybrid));
    let Some(test) = hybrid.or(trim) else {
        return html! {};
    };
    let before = test.uncompensated_pp_counts;
    let mut bars = vec![Bar { class: "before", name: "before", counts: before, ratio: None }];
    let after = [("trim", trim), ("hybrid", hybrid)];
    bars.extend(after.into_iter().filter_map(|(name, test)| {
        test.map(|test| Bar { class: "x", name, counts: test.residual_pp_counts, ratio: Some(test.ratio()) })
    }));
    bars.push(Bar { class: "floor", name: "floor", counts: test.floor_pp_counts, ratio: None });
    html! {
        dl.bars aria-label={ (test.axis) ", peak to peak, heating, held out" } {
            @for bar in &bars {
                dt { (bar.name) }
                dd {
                    span.room { span class={ "bar " (bar.class) } style=(width(bar.counts / before)) {} }
                    span {
                        b { (fixed(bar.counts, 1)) " counts" }
                        @if let Some(ratio) = bar.ratio { " · " (fixed(ratio, 1)) " ×" }
                        @if let Some(scale) = report.unit.scale_counts_per_dps {
                            " " small { (significant(bar.counts / scale.abs(), 3)) " deg/s" }
                        }
                    }
                }
            }
        }
        p.small {
            (test.axis) ", peak to peak of group means over the hour of the heating ramp; trim, hybrid and floor in a second "
            "run that no fit has seen. × is how many times less than before. The floor is noise: what no compensation "
            "could beat."
        }
    }
}

/// A bar's width, of the room it has.
fn width(share: f64) -> String {
    format!("width:{:.2}%", 100.0 * share.clamp(0.0, 1.0))
}

fn unit_facts(report: &CalibrationReport) -> Markup {
    let unit = &report.unit;
    let mut facts: Vec<(&str, Markup)> = vec![("Serial number", html! { (unit.serial) })];
    facts.push(("Device", html! { (unit.device) }));
    if let Some(plant) = &unit.plant {
        facts.push(("Plant, simulated", html! { (plant) @if let Some(seed) = unit.seed { ", seed " (seed) } }));
    }
    facts.push(("Centre", html! { (fixed(unit.centre_counts, 0)) " counts" }));
    facts.push(("Middle tap", html! { (unit.middle_tap) }));
    let groups = fixed(unit.groups_per_minute, 0);
    facts.push(("Groups", html! { (unit.group_samples) " samples, " (groups) " a minute" }));
    if let Some(scale) = unit.scale_counts_per_dps {
        facts.push(("Scale factor", html! { (significant(scale, 4)) " counts per deg/s" }));
    }
    for (name, value) in &unit.further {
        facts.push((name, html! { (value) }));
    }
    page::facts(&facts)
}
