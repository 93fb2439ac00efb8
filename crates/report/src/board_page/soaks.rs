//! One ramp against many soaks: the same curve, in fewer hours?

use maud::{Markup, html};
use zerorate_board_run::summary::{SoakPoint, Soaks};

use super::Board;
use super::axis::BoardAxis;
use crate::figure::{Figure, Ink, Mark, Panel, Sample, holding};
use crate::number::{counted, fixed};
use crate::page::Table;

/// The soaks of an axis.
fn points<'a>(soaks: &'a Soaks, axis: &BoardAxis) -> &'a [SoakPoint] {
    soaks.axes.get(axis.axis.name()).map_or(&[], |axis| &axis.points)
}

/// The largest distances of a soak from the ramp's curve, in words; `None` where no axis has a soak to compare.
fn largest_differences(soaks: &Soaks, axes: &[BoardAxis]) -> Option<String> {
    let largest = |axis: &BoardAxis| {
        let counts = soaks.axes.get(axis.axis.name())?.max_difference_counts?;
        Some(format!("{} counts ({})", fixed(counts, 1), axis.name))
    };
    let largest: Vec<String> = axes.iter().filter_map(largest).collect();
    (!largest.is_empty()).then(|| largest.join(" and "))
}

/// The set points of the soaks that are not compared with the ramp, on any axis.
fn outside(soaks: &Soaks) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for soak in soaks.axes.values().flat_map(|axis| &axis.points).filter(|soak| soak.outside_ramp) {
        let set_point = fixed(soak.chamber_c, 0);
        if !found.contains(&set_point) {
            found.push(set_point);
        }
    }
    found
}

pub(super) fn chapter(soaks: &Soaks, board: &Board) -> Markup {
    let count = board.axes.first().map_or(0, |axis| points(soaks, axis).len());
    let outside = outside(soaks);
    html! {
        p {
            "The paper’s claim is that one ramp replaces many soaks. Here it is tried: the unit was also held at "
            (counted(count, "temperature")) ", as the traditional test does. "
            @if outside.is_empty() { "All of them lie on the ramp, or within half a kelvin of an end of it." }
            @else {
                @match count - outside.len() { 0 => "None", on_the_ramp => (on_the_ramp) }
                " of them can be compared with the ramp: at " (outside.join(", "))
                "\u{a0}°C the board was colder or warmer than at any time of the ramp. Where it had not yet come to the chamber’s \
                 temperature, hold soaks longer (" code { "chamber.soak_s" } ")."
            }
        }
        p.lead {
            "The ramp took " (fixed(soaks.ramp_hours, 1)) " hours of chamber time, the soaks "
            (fixed(soaks.soak_hours, 1))
            @if !outside.is_empty() { ", those on the ramp " (fixed(soaks.ramp_hours + soaks.hours_saved, 1)) }
            ": " @if soaks.hours_saved > 0.0 { (fixed(soaks.hours_saved, 1)) " hours saved. " } @else { "none saved. " }
            @if let Some(largest) = largest_differences(soaks, &board.axes) { "The curves differ by at most " (largest) "." }
        }
        (figure(soaks, board).markup())
        div.pair { @for axis in &board.axes { (table(soaks, axis, board)) } }
    }
}

fn figure(soaks: &Soaks, board: &Board) -> Figure {
    let column = |axis: &BoardAxis| {
        let (name, ink, soaks) = (axis.name, axis.ink, points(soaks, axis));
        let temperature = "temperature reading, counts";
        let at: Vec<(f64, f64)> = soaks.iter().map(|soak| (soak.temperature_counts, soak.zro_counts)).collect();
        let on_the_ramp = soaks.iter().filter(|soak| !soak.outside_ramp);
        let difference = on_the_ramp.map(|soak| (soak.temperature_counts, soak.zro_counts - soak.ramp_counts));
        let title = format!("{name}: soaks and the ramp’s curve");
        let curve = axis.curve();
        let ends = holding(curve.iter().chain(&at).map(|point| point.0));
        let up = format!("{name}: zero-rate output, counts");
        let both = Panel::new(title, temperature, up, [Mark::Line(Ink::Curve, curve), Mark::Dots(ink, at)]);
        let title = format!("{name}: soak less ramp");
        let up = format!("{title}, counts");
        let apart = Panel::new(title, temperature, up, [Mark::Stems(ink, difference.collect())]);
        vec![
            Panel { x_range: ends, second: board.celsius(), ..both },
            Panel { x_range: ends, height: Panel::SHORT, ..apart },
        ]
    };
    let mut key: Vec<_> =
        board.axes.iter().map(|axis| (axis.ink, Sample::Dot, format!("{}, soaks", axis.name))).collect();
    key.push((Ink::Curve, Sample::Line, "curve of the ramp".to_owned()));
    Figure {
        id: "fig-soaks".into(),
        name: "Soaks".into(),
        caption: html! { "Means of the soaks on the curve fitted to the ramp; below, how far each is from it." },
        key,
        columns: board.axes.iter().map(column).collect(),
    }
}

fn table(soaks: &Soaks, axis: &BoardAxis, board: &Board) -> Markup {
    let celsius = board.celsius();
    let mut heads = vec!["Chamber", "Temperature"];
    heads.extend(celsius.as_ref().map(|_| "The same, °C"));
    heads.extend(["Zero-rate output", "Curve of the ramp", "Soak less ramp"]);
    let row = |soak: &SoakPoint| {
        let places = usize::from(soak.chamber_c.fract() != 0.0);
        let mut cells =
            vec![html! { (fixed(soak.chamber_c, places)) "\u{a0}°C" }, html! { (fixed(soak.temperature_counts, 1)) }];
        cells.extend(celsius.as_ref().map(|scale| html! { (fixed(scale.of(soak.temperature_counts), 1)) }));
        cells.extend([
            html! { (fixed(soak.zro_counts, 1)) },
            html! { (fixed(soak.ramp_counts, 1)) },
            html! {
                @if soak.outside_ramp { "outside the ramp" } @else { (fixed(soak.zro_counts - soak.ramp_counts, 2)) }
            },
        ]);
        cells
    };
    Table {
        caption: html! { b { (axis.name) } ", the soaks, counts." },
        heads: &heads,
        rows: points(soaks, axis).iter().map(row).collect(),
        numbers_from: 1,
    }
    .wide_markup()
}
