//! Figure 4: the trim experiment, and what each tap does.

use maud::{Markup, html};

use super::{indexed, ink_of};
use crate::calibration::{CalibratedAxis, CalibrationReport, TrimLine, TrimPoint};
use crate::figure::{Figure, Ink, Mark, Panel, Sample};
use crate::number::{fixed, significant};
use crate::page::Table;
use crate::paper::PaperAxis;

pub(super) fn chapter(report: &CalibrationReport) -> Markup {
    html! {
        p {
            "A fine supply took the gyro’s place. At each of its voltages the reading was taken at tap "
            (report.unit.middle_tap) ", then the tap was sought at which it is nearest " (fixed(report.unit.centre_counts, 0))
            " counts. A straight line through these points turns an offset into taps."
        }
        (lines(report).markup())
        @for axis in &report.axes { (equation(axis)) }
        (table(report))
        p.small {
            "The paper’s formula takes d" i { "V" } " against " i { "V" } sub { "0" } ", the mean of the trimmed readings, each of "
            "which is off by up to half a tap, and that scatters its slope. The better one takes each point against its own "
            "trimmed reading. In a linear circuit the intercept is near 0 and " i { "V" } sub { "0" } " near the centre; the "
            "paper’s own values are its sample, not an aim."
        }
        @if report.axes.iter().any(|axis| !axis.trim.taps.is_empty()) { (taps(report).markup()) }
    }
}

/// d(N) of a line at an offset from its own trimmed reading.
fn on_line(line: &TrimLine, delta_counts: f64) -> f64 {
    line.slope_taps_per_count * delta_counts + line.intercept_taps
}

/// Figure 4 of the paper, with the distance from the line below: the line alone shows nothing.
fn lines(report: &CalibrationReport) -> Figure {
    let columns = report.axes.iter().map(|axis| {
        let ink = ink_of(report, &axis.name);
        let (name, trim) = (&axis.name, &axis.trim);
        let delta = "dV, counts";
        let points = |of: fn(&TrimLine, &TrimPoint) -> f64| -> Vec<(f64, f64)> {
            trim.points.iter().map(|point| (point.delta_counts, of(&trim.better, point))).collect()
        };
        let marks = [
            Mark::Line(Ink::Curve, points(|line, point| on_line(line, point.delta_counts))),
            Mark::Dots(ink, points(|_, point| point.delta_taps)),
        ];
        let fit = Panel::new(format!("{name}: taps against offset"), delta, format!("{name}: dN, taps"), marks);
        let distance = |line: &TrimLine, point: &TrimPoint| point.delta_taps - on_line(line, point.delta_counts);
        let title = format!("{name}: distance from the line");
        let up = format!("{title}, taps");
        let left = Panel::new(title, delta, up, [Mark::Stems(ink, points(distance))]);
        vec![fit, Panel { height: Panel::SHORT, ..left }]
    });
    let columns = columns.collect();
    let mut key: Vec<_> =
        report.axes.iter().map(|axis| (ink_of(report, &axis.name), Sample::Dot, axis.name.clone())).collect();
    key.push((Ink::Curve, Sample::Line, "fitted line".to_owned()));
    let count = report.axes.first().map_or(0, |axis| axis.trim.points.len());
    Figure {
        id: "fig-4".into(),
        name: "Figure 4".into(),
        caption: html! {
            "Taps d" i { "N" } " against offset d" i { "V" } ", " (count) " voltages, with the fitted line; below, how far each "
            "point is from it. (The paper’s figure 4.)"
        },
        key,
        columns,
    }
}

fn equation(axis: &CalibratedAxis) -> Markup {
    let line = &axis.trim.better;
    let sign = |value: f64| if value < 0.0 { " \u{2212} " } else { " + " };
    html! {
        div.equation {
            p {
                "d" (indexed("N", &axis.name)) " = " (significant(line.slope_taps_per_count, 6)) "\u{a0}d" (indexed("V", &axis.name))
                (sign(line.intercept_taps)) (fixed(line.intercept_taps.abs(), 4))
                span.small { "  taps; one tap is " (fixed(-1.0 / line.slope_taps_per_count, 2)) " counts" }
            }
        }
    }
}

fn table(report: &CalibrationReport) -> Markup {
    let mut rows = Vec::new();
    for axis in &report.axes {
        let mut row = |what: &str, line: &TrimLine| {
            rows.push(vec![
                html! { (axis.name) ", " (what) },
                significant(line.slope_taps_per_count, 6),
                html! { (fixed(line.intercept_taps, 4)) },
                html! { (fixed(line.centre_counts, 1)) },
                html! { (fixed(-1.0 / line.slope_taps_per_count, 3)) },
            ]);
        };
        row("by the better formula", &axis.trim.better);
        row("by the paper’s formula", &axis.trim.paper);
        if let Some(paper) = PaperAxis::named(&axis.name) {
            let line = TrimLine {
                slope_taps_per_count: paper.slope_taps_per_count,
                intercept_taps: paper.intercept_taps,
                centre_counts: paper.centre_counts,
            };
            row("as the paper prints", &line);
        }
        if let Some(slope) = axis.trim.plant_slope_taps_per_count {
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
    Table { caption, heads: &heads, rows, numbers_from: 1 }.markup()
}

fn taps(report: &CalibrationReport) -> Figure {
    let column = |axis: &CalibratedAxis| {
        let stems = axis.trim.taps.iter().map(|tap| (f64::from(tap.tap), tap.deviation_counts)).collect();
        let title = format!("{}: deviation of each tap from the line", axis.name);
        let up = format!("{}: deviation from the line, counts", axis.name);
        let panel = Panel::new(title, "tap", up, [Mark::Stems(ink_of(report, &axis.name), stems)]);
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
        columns: report.axes.iter().map(column).collect(),
    }
}
