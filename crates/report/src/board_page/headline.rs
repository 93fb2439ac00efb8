//! The top of the page: the verdict, and the numbers that matter.

use maud::{Markup, html};

use super::{Board, name_of};
use crate::number::{fixed, significant};
use crate::page;

/// A bar: class, name, counts, how many times smaller than before.
struct Bar {
    class: &'static str,
    name: &'static str,
    counts: f64,
    ratio: Option<f64>,
}

pub(super) fn headline(board: &Board) -> Markup {
    let summary = board.summary;
    let failed: Vec<_> = summary.checks.iter().filter(|check| !check.pass).collect();
    html! {
        p.over { "Calibration of a gyroscope’s zero-rate output" }
        h1 { "Unit " (summary.serial) }
        p { (page::verdict(summary.verdict)) }
        p.lead { (lead(board)) }
        (bars(board))
        @if !failed.is_empty() {
            p { a href="#checks" { (failed.len()) " of " (summary.checks.len()) " checks failed" } ":" }
            ul.reasons { @for check in &failed {
                li { (check.what) ": " b.rejected { (check.measured) } ", limit " (check.limit) "." }
            } }
        }
        @if !summary.warnings.is_empty() {
            ul.reasons { @for warning in &summary.warnings { li { (warning) } } }
        }
        (unit_facts(board))
    }
}

fn lead(board: &Board) -> Markup {
    let [trim, hybrid] = board.summary.headline();
    let Some(test) = trim.or(hybrid) else {
        return html! { "The drift was fitted; no compensation test was run." };
    };
    html! {
        "Over one heating ramp, " (name_of(test.axis)) "’s zero-rate output drifted "
        (fixed(board.summary.drift_pp_counts(test.axis), 0)) " counts. "
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

fn bars(board: &Board) -> Markup {
    let [trim, hybrid] = board.summary.headline();
    let Some(test) = hybrid.or(trim) else {
        return html! {};
    };
    let before = board.summary.drift_pp_counts(test.axis);
    let mut bars = vec![Bar { class: "before", name: "before", counts: before, ratio: None }];
    let after = [("trim", trim), ("hybrid", hybrid)];
    bars.extend(after.into_iter().filter_map(|(name, test)| {
        test.map(|test| Bar { class: "x", name, counts: test.residual_pp_counts, ratio: Some(test.ratio()) })
    }));
    bars.extend(test.floor_pp_counts.map(|counts| Bar { class: "floor", name: "floor", counts, ratio: None }));
    html! {
        dl.bars aria-label={ (name_of(test.axis)) ", peak to peak, heating, held out" } {
            @for bar in &bars {
                dt { (bar.name) }
                dd {
                    span.room { span class={ "bar " (bar.class) } style=(width(bar.counts / before)) {} }
                    span {
                        b { (fixed(bar.counts, 1)) " counts" }
                        @if let Some(ratio) = bar.ratio { " · " (fixed(ratio, 1)) " ×" }
                        " " small { (significant(bar.counts / board.summary.counts_per_dps.abs(), 3)) " deg/s" }
                    }
                }
            }
        }
        p.small {
            (name_of(test.axis)) ", peak to peak of group means over the heating ramp; trim and hybrid in second "
            "runs that no fit has seen. × is how many times less than before. "
            @if test.floor_pp_counts.is_some() { "The floor is noise: what no compensation could beat." }
            @else { "What of it is noise, which no compensation could take out, is not known on a real bench." }
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
    let hashes: Vec<(String, &str)> = calibration
        .sources
        .iter()
        .map(|source| (format!("SHA-256 of {}", source.file), source.sha256.as_str()))
        .collect();
    let mut facts: Vec<(&str, Markup)> = vec![
        ("Serial number", html! { (summary.serial) }),
        ("Board", html! { @if summary.plant.is_some() { "simulated, " } (summary.trim_part.to_uppercase()) }),
    ];
    if let Some(plant) = &summary.plant {
        facts.push(("Plant, simulated", html! { (plant) @if let Some(seed) = summary.seed { ", seed " (seed) } }));
    }
    facts.extend([
        ("Centre", html! { (fixed(board.centre_counts(), 0)) " counts" }),
        ("Middle tap", html! { (board.middle_tap()) }),
        ("Groups", html! { (board.group_samples()) " samples, " (groups) " a minute" }),
        ("Scale factor", html! { (significant(summary.counts_per_dps, 4)) " counts per deg/s" }),
    ]);
    facts.extend(hashes.iter().map(|(name, hash)| (name.as_str(), html! { (hash) })));
    page::facts(&facts)
}
