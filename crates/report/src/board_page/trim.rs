//! Figure 4: the trim experiment, and what each tap does.

use maud::{Markup, html};
use zerorate_core::units::Counts;
use zerorate_fit::trim::{SupplyPoint, TrimEstimate};

use super::axis::BoardAxis;
use super::{Board, indexed};
use crate::figure::{Figure, Ink, Mark, Panel, Sample};
use crate::number::{fixed, significant};
use crate::page::Table;
use crate::paper::PaperAxis;

pub(super) fn chapter(board: &Board) -> Markup {
    html! {
        p {
            "A fine supply took the gyro’s place. At each of its voltages the reading was taken at tap "
            (board.middle_tap()) ", then the tap was sought at which it is nearest " (fixed(board.centre_counts(), 0))
            " counts. A straight line through these points turns an offset into taps."
        }
        (lines(board).markup())
        @for axis in &board.axes { (equation(axis)) }
        (table(board))
        p.small {
            "The paper’s formula takes d" i { "V" } " against " i { "V" } sub { "0" } ", the mean of the trimmed readings, each of "
            "which is off by up to half a tap, and that scatters its slope. The paired one takes each point against its own "
            "trimmed reading. In a linear circuit the intercept is near 0 and " i { "V" } sub { "0" } " near the centre; the "
            "paper’s own values are its sample, not an aim."
        }
        @if board.axes.iter().any(|axis| axis.trim.trim.measured.is_some()) { (taps(board).markup()) }
    }
}

/// dV of a point, from its own trimmed reading, counts.
fn delta_counts(point: &SupplyPoint) -> f64 {
    (point.at_middle - point.trimmed).0
}

/// dN on a line at a point's dV, taps.
fn on_line(line: &TrimEstimate, point: &SupplyPoint) -> f64 {
    line.slope_taps_per_count * delta_counts(point) + line.intercept_taps
}

/// Figure 4 of the paper, with the distance from the line below: the line alone shows nothing.
fn lines(board: &Board) -> Figure {
    let columns = board.axes.iter().map(|axis| {
        let (name, ink, line) = (axis.name, axis.ink, axis.paired);
        let delta = "dV, counts";
        let delta_taps = |point: &SupplyPoint| f64::from(point.tap.get()) - f64::from(board.middle_tap());
        let points = |of: &dyn Fn(&SupplyPoint) -> f64| -> Vec<(f64, f64)> {
            axis.trim.points.iter().map(|point| (delta_counts(point), of(point))).collect()
        };
        let marks =
            [Mark::Line(Ink::Curve, points(&|point| on_line(line, point))), Mark::Dots(ink, points(&delta_taps))];
        let fit = Panel::new(format!("{name}: taps against offset"), delta, format!("{name}: dN, taps"), marks);
        let distance = points(&|point| delta_taps(point) - on_line(line, point));
        let title = format!("{name}: distance from the line");
        let up = format!("{title}, taps");
        let left = Panel::new(title, delta, up, [Mark::Stems(ink, distance)]);
        vec![fit, Panel { height: Panel::SHORT, ..left }]
    });
    let columns = columns.collect();
    let mut key: Vec<_> = board.axes.iter().map(|axis| (axis.ink, Sample::Dot, axis.name.to_owned())).collect();
    key.push((Ink::Curve, Sample::Line, "fitted line".to_owned()));
    let count = board.axes.first().map_or(0, |axis| axis.trim.points.len());
    Figure {
        id: "fig-4".into(),
        name: "Figure 4".into(),
        caption: html! {
            "Taps d" i { "N" } " against offset d" i { "V" } ", " (count) " voltages, with the fitted line; below, how far each "
            "point is from it." (board.as_in_the_paper(4))
        },
        key,
        columns,
    }
}

fn equation(axis: &BoardAxis) -> Markup {
    let line = axis.paired;
    let sign = |value: f64| if value < 0.0 { " \u{2212} " } else { " + " };
    html! {
        div.equation {
            p {
                "d" (indexed("N", axis.axis)) " = " (significant(line.slope_taps_per_count, 6)) "\u{a0}d" (indexed("V", axis.axis))
                (sign(line.intercept_taps)) (fixed(line.intercept_taps.abs(), 4))
                span.small { "  taps; one tap is " (fixed(-1.0 / line.slope_taps_per_count, 2)) " counts" }
            }
        }
    }
}

fn table(board: &Board) -> Markup {
    let mut rows = Vec::new();
    for axis in &board.axes {
        let mut row = |what: &str, slope_taps_per_count: f64, intercept_taps: f64, centre_counts: f64| {
            rows.push(vec![
                html! { (axis.name) ", " (what) },
                significant(slope_taps_per_count, 6),
                html! { (fixed(intercept_taps, 4)) },
                html! { (fixed(centre_counts, 1)) },
                html! { (fixed(-1.0 / slope_taps_per_count, 3)) },
            ]);
        };
        for (what, line) in [("by the paired formula", axis.paired), ("by the paper’s formula", axis.paper)] {
            row(what, line.slope_taps_per_count, line.intercept_taps, line.centre_counts);
        }
        let paper = PaperAxis::of(axis.axis);
        row("as the paper prints", paper.slope_taps_per_count, paper.intercept_taps, paper.centre_counts);
        if let Some(slope) = axis.summary.plant_slope_taps_per_count {
            rows.push(vec![
                html! { (axis.name) ", truth of the simulated plant" },
                significant(slope, 6),
                html! { "\u{2013}" },
                html! { "\u{2013}" },
                html! { (fixed(-1.0 / slope, 3)) },
            ]);
        }
    }
    let heads = ["", "a, taps per count", "b, taps", "V₀, counts", "one tap, counts"];
    let caption = html! { "The line d" i { "N" } " = " i { "a" } " (" i { "V" } " − " i { "V" } sub { "0" } ") + " i { "b" } ", two ways, beside the paper’s." };
    Table { caption, heads: &heads, rows, numbers_from: 1 }.wide_markup()
}

fn taps(board: &Board) -> Figure {
    let column = |axis: &BoardAxis| {
        let (middle, per_tap) = (f64::from(board.middle_tap()), axis.paired.counts_per_tap().0);
        let measured = axis.trim.trim.measured.iter();
        let taps = measured.flat_map(|effects| (effects.first().get()..).zip(effects.effects()));
        let deviation = |(tap, effect): (u16, &Counts)| {
            let tap = f64::from(tap);
            (tap, effect.0 - per_tap * (tap - middle))
        };
        let stems = taps.map(deviation).collect();
        let title = format!("{}: deviation of each tap from the line", axis.name);
        let up = format!("{}: deviation from the line, counts", axis.name);
        let panel = Panel::new(title, "tap", up, [Mark::Stems(axis.ink, stems)]);
        vec![Panel { height: Panel::SHORT + 300, ..panel }]
    };
    Figure {
        id: "fig-taps".into(),
        name: "Taps".into(),
        caption: html! {
            "Each tap of the working range is a little off the line: the potentiometer’s own nonlinearity. The law knows these "
            "offsets and takes them into account."
        },
        key: Vec::new(),
        columns: board.axes.iter().map(column).collect(),
    }
}
