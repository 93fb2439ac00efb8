//! How units have changed from calibration to calibration: a figure each, of those that changed most.

use maud::{Markup, html};
use zerorate_core::units::Axis;

use super::{UnitAxis, UnitCalibration, UnitCalibrations};
use crate::figure::{Figure, Ink, Mark, Panel, Sample, holding};
use crate::number::{counted, fixed, whole};
use crate::panels::{ink_of, name_of};

/// Units drawn, at most: a page of a thousand figures is read by nobody.
const DRAWN: usize = 24;

pub(super) fn chapter(units: &[UnitCalibrations]) -> Markup {
    let mut again: Vec<&UnitCalibrations> = units.iter().filter(|unit| unit.calibrations.len() > 1).collect();
    // Units that changed as much stay in the table's order.
    again.sort_by(|a, b| largest_change(b).total_cmp(&largest_change(a)));
    let left_out = again.len().saturating_sub(DRAWN);
    html! {
        @if again.is_empty() { p { "No unit was calibrated more than once: there is no trend to draw." } }
        @else {
            p {
                (counted(again.len(), "unit")) @if again.len() == 1 { " was" } @else { " were" }
                " calibrated more than once. "
                @if left_out > 0 {
                    "Drawn are the " (DRAWN) " whose curve has changed most between two calibrations, the most first; "
                    (whole(left_out as u64)) " more are in the table alone."
                } @else if again.len() > 1 { "The one whose curve has changed most between two calibrations stands first." }
            }
            @for (place, unit) in again.iter().take(DRAWN).enumerate() { (figure(unit, place + 1).markup()) }
        }
    }
}

/// The largest change between two calibrations of either axis, counts; below every change where none is known.
fn largest_change(unit: &UnitCalibrations) -> f64 {
    let axes = unit.calibrations.iter().flat_map(|calibration| calibration.axes.iter().flatten());
    axes.filter_map(|axis| axis.change).fold(-1.0, f64::max)
}

fn figure(unit: &UnitCalibrations, place: usize) -> Figure {
    let (across, at) = times(unit);
    // The first calibration has no change: its panel has the dates of the others all the same.
    let dates = holding(at.iter().copied());
    let panel = |what: &str, of: fn(&UnitAxis) -> Option<f64>| {
        let marks = Axis::BOTH.into_iter().flat_map(|axis| {
            let value = |calibration: &UnitCalibration| calibration.axes[axis.index()].as_ref().and_then(of);
            let values = at.iter().zip(&unit.calibrations).map(|(at, calibration)| (*at, value(calibration)));
            let points: Vec<(f64, f64)> = values.filter_map(|(at, value)| Some((at, value?))).collect();
            [Mark::Line(ink_of(axis), points.clone()), Mark::Dots(ink_of(axis), points)]
        });
        // From zero, so that a hundredth of a count does not look like a change.
        let marks: Vec<Mark> = std::iter::once(Mark::Level(Ink::Aim, 0.0)).chain(marks).collect();
        let panel = Panel::new(format!("{}: {what}", unit.serial), &across, format!("{what}, counts"), marks);
        Panel { height: Panel::SHORT, x_range: dates, ..panel }
    };
    let largest = largest_change(unit);
    Figure {
        id: format!("fig-{place}"),
        name: unit.serial.clone(),
        caption: html! {
            (counted(unit.calibrations.len(), "calibration"))
            @if largest >= 0.0 { "; the curve has changed by " (fixed(largest, 1)) " counts at most from one to the next" }
            "."
        },
        key: Axis::BOTH.into_iter().map(|axis| (ink_of(axis), Sample::Dot, name_of(axis).to_owned())).collect(),
        columns: vec![
            vec![panel("drift", |axis| Some(axis.drift)), panel("change", |axis| axis.change)],
            vec![panel("trim left", |axis| axis.trim), panel("hybrid left", |axis| axis.hybrid)],
        ],
    }
}

/// What stands across, and where each calibration is on it: days since the first, or its number where a date is not known.
fn times(unit: &UnitCalibrations) -> (String, Vec<f64>) {
    let days: Option<Vec<f64>> = unit.calibrations.iter().map(|calibration| calibration.day).collect();
    match days {
        Some(days) => {
            let first = days.first().copied().unwrap_or(0.0);
            let made = unit.calibrations.first().map_or("", |first| first.made.get(..10).unwrap_or(&first.made));
            (format!("days since {made}"), days.iter().map(|day| day - first).collect())
        }
        None => {
            let numbers = 1..=u32::try_from(unit.calibrations.len()).unwrap_or(u32::MAX);
            ("calibration, number".to_owned(), numbers.map(f64::from).collect())
        }
    }
}
