//! The chamber's air beside the sensor's own temperature, and what was left at the end of each soak.

use maud::{Markup, html};
use zerorate_cal::in_chamber::{InChamber, SOAKS_TOLD, SoakRow};
use zerorate_cal::log_fit::LogFit;
use zerorate_cal::units::WrittenRate;

use super::axis::time_unit;
use crate::figure::{Figure, Ink, Mark, Panel, Sample, holding};
use crate::number::{decimals_for, fixed};
use crate::page::Table;

/// The chapter.
pub(super) fn chapter(fit: &LogFit, chamber: &InChamber, units: Option<WrittenRate>) -> Markup {
    let rows = chamber.rows(fit, units);
    html! {
        p { "The air as " (chamber.recording) " has it, begun " (chamber.started) ". The fit did not use it." }
        @for sentence in &chamber.told { p { (sentence) } }
        (figure(fit, chamber).markup())
        @if rows.is_empty() { p { "No soak ended while the log was recorded." } } @else { (table(&rows)) }
    }
}

fn figure(fit: &LogFit, chamber: &InChamber) -> Figure {
    let sensor = fit.axes.first().map(|axis| &axis.trace[..]).unwrap_or_default();
    let (from_s, to_s) = holding(sensor.iter().map(|point| point.time_s)).unwrap_or((0.0, 0.0));
    let (name, unit_s) = time_unit(to_s - from_s);
    let own = sensor.iter().map(|point| (point.time_s / unit_s, point.temperature)).collect();
    let air = chamber.air.iter().filter(|(time_s, _)| (from_s..=to_s).contains(time_s));
    let air = air.map(|(time_s, air_c)| (time_s / unit_s, *air_c)).collect();
    let soaks = chamber
        .soaks
        .iter()
        .map(|soak| Mark::Band(Ink::Excluded, soak.from_s.max(from_s) / unit_s, soak.to_s.min(to_s) / unit_s));
    let lines = [Mark::Line(Ink::Aim, air), Mark::Dots(Ink::Raw, own)];
    let title = "Temperature of the sensor and of the air against time";
    let marks: Vec<Mark> = soaks.chain(lines).collect();
    let panel = Panel::new(title, format!("time, {name}"), "temperature, \u{b0}C", marks);
    let key =
        [(Ink::Raw, Sample::Dot, "sensor"), (Ink::Aim, Sample::Line, "air"), (Ink::Excluded, Sample::Patch, "soak")];
    Figure {
        id: "chamber-1".to_owned(),
        name: format!("Figure {}", fit.axes.len() + 1),
        caption: html! { "The chamber\u{2019}s air and the sensor\u{2019}s own temperature; soaks are shaded." },
        key: key.map(|(ink, sample, what)| (ink, sample, what.to_owned())).into(),
        columns: vec![vec![panel]],
    }
}

fn table(rows: &[SoakRow]) -> Markup {
    let largest = rows.iter().map(|row| row.residual.abs()).fold(0.0, f64::max);
    let decimals = decimals_for(largest);
    let row = |row: &SoakRow| {
        vec![
            html! { (row.axis.name) },
            html! { (fixed(row.soak.from_s / 60.0, 0)) " to " (fixed(row.soak.to_s / 60.0, 0)) },
            html! { (fixed(row.soak.set_c, 1)) },
            html! { (fixed(row.soak.air_c, 1)) },
            html! { (fixed(row.axis.sensor_c, 1)) },
            html! { (fixed(row.axis.sensor_c - row.soak.air_c, 1)) },
            html! { (fixed(row.residual, decimals)) " " (row.unit) },
        ]
    };
    Table {
        caption: html! { (SOAKS_TOLD) },
        heads: &[
            "Axis",
            "Soak, min",
            "Set to, \u{b0}C",
            "Air, \u{b0}C",
            "Sensor, \u{b0}C",
            "Above the air, K",
            "Residual, mean",
        ],
        rows: rows.iter().map(row).collect(),
        numbers_from: 1,
    }
    .wide_markup()
}
