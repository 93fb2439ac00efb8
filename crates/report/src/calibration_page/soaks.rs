//! One ramp against many soaks: the same curve, in fewer hours?

use maud::{Markup, html};

use super::ink_of;
use crate::calibration::{AxisSoaks, CalibratedAxis, CalibrationReport, SoakComparison, SoakPoint};
use crate::figure::{Figure, Ink, Mark, Panel, Sample, holding};
use crate::number::fixed;
use crate::page::Table;

pub(super) fn chapter(comparison: &SoakComparison, report: &CalibrationReport) -> Markup {
    let soaks = comparison.axes.first().map_or(0, |axis| axis.points.len());
    let saved = comparison.soak_hours - comparison.ramp_hours;
    html! {
        p {
            "The paper’s claim is that one ramp replaces many soaks. Here it is tried: the unit was also held at " (soaks)
            " temperatures, as the traditional test does."
        }
        p.lead {
            "The ramp took " (fixed(comparison.ramp_hours, 1)) " hours of chamber time, the soaks "
            (fixed(comparison.soak_hours, 1)) ": " (fixed(saved, 1)) " hours saved. The curves differ by at most "
            @for (place, axis) in comparison.axes.iter().enumerate() {
                @if place > 0 { " and " }
                (fixed(axis.largest_difference_counts, 1)) " counts (" (axis.name) ")"
            }
            "."
        }
        (figure(comparison, report).markup())
        div.pair { @for axis in &comparison.axes { (table(axis)) } }
    }
}

fn figure(comparison: &SoakComparison, report: &CalibrationReport) -> Figure {
    let column = |soaks: &AxisSoaks| {
        let ink = ink_of(report, &soaks.name);
        let temperature = "temperature reading, counts";
        let ramp = report.axes.iter().find(|axis| axis.name == soaks.name);
        let at: Vec<(f64, f64)> = soaks.points.iter().map(|soak| (soak.temperature_counts, soak.zro_counts)).collect();
        let difference = soaks.points.iter().map(|soak| (soak.temperature_counts, soak.zro_counts - soak.ramp_counts));
        let title = format!("{}: soaks and the ramp’s curve", soaks.name);
        let curve = ramp.map(CalibratedAxis::fitted_curve).unwrap_or_default();
        let ends = holding(curve.iter().chain(&at).map(|point| point.0));
        let up = format!("{}: zero-rate output, counts", soaks.name);
        let both = Panel::new(title, temperature, up, [Mark::Line(Ink::Curve, curve), Mark::Dots(ink, at)]);
        let title = format!("{}: soak less ramp", soaks.name);
        let up = format!("{title}, counts");
        let apart = Panel::new(title, temperature, up, [Mark::Stems(ink, difference.collect())]);
        vec![Panel { x_range: ends, ..both }, Panel { x_range: ends, height: Panel::SHORT, ..apart }]
    };
    let mut key: Vec<_> = comparison
        .axes
        .iter()
        .map(|axis| (ink_of(report, &axis.name), Sample::Dot, format!("{}, soaks", axis.name)))
        .collect();
    key.push((Ink::Curve, Sample::Line, "curve of the ramp".to_owned()));
    Figure {
        id: "fig-soaks".into(),
        name: "Soaks".into(),
        caption: html! { "Means of the soaks on the curve fitted to the ramp; below, how far each is from it." },
        key,
        columns: comparison.axes.iter().map(column).collect(),
    }
}

fn table(axis: &AxisSoaks) -> Markup {
    let row = |soak: &SoakPoint| {
        vec![
            html! { (fixed(soak.chamber_c, 0)) "\u{a0}°C" },
            html! { (fixed(soak.temperature_counts, 1)) },
            html! { (fixed(soak.zro_counts, 1)) },
            html! { (fixed(soak.ramp_counts, 1)) },
            html! { (fixed(soak.zro_counts - soak.ramp_counts, 2)) },
        ]
    };
    Table {
        caption: html! { b { (axis.name) } ", the soaks, counts." },
        heads: &["Chamber", "Temperature", "Zero-rate output", "Curve of the ramp", "Soak less ramp"],
        rows: axis.points.iter().map(row).collect(),
        numbers_from: 1,
    }
    .markup()
}
