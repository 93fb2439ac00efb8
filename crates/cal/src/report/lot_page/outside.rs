//! The units that fail the limits.

use maud::{Markup, html};

use crate::report::lot::{LotAxis, LotLimit, LotReport, LotUnit, Quantity};
use crate::report::number::{counted, exact, fixed, significant};
use crate::report::page::Table;

/// Rows listed, at most.
const LISTED: usize = 200;

/// One number that is outside its limit.
pub(super) struct Outside<'a> {
    unit: &'a LotUnit,
    /// None for a unit that has no fit.
    axis: Option<&'a LotAxis>,
    quantity: Quantity,
    value: f64,
    /// The limit that it fails, in words.
    limit: String,
    /// How far outside, in parts of the distance of the two limits, or of the only one; infinite for a missing number.
    far: f64,
}

/// All of them, the furthest outside first. Rejected units are not among them: they have a list of their own.
pub(super) fn rows(report: &LotReport) -> Vec<Outside<'_>> {
    let mut rows = Vec::new();
    for unit in report.units.iter().filter(|unit| unit.rejected.is_empty()) {
        for limit in report.limits.iter().filter(|limit| !limit.kept_by(unit)) {
            let row = |axis, value: f64| {
                let (far, limit_words) = outside(limit, value)?;
                Some(Outside { unit, axis, quantity: limit.quantity, value, limit: limit_words, far })
            };
            rows.extend(unit.axes.iter().filter_map(|axis| row(Some(axis), axis.values[limit.quantity as usize])));
            if unit.axes.is_empty() {
                rows.extend(row(None, f64::NAN));
            }
        }
    }
    rows.sort_by(|a, b| b.far.total_cmp(&a.far));
    rows
}

/// How far a value is outside a limit, and of which side; none for one that keeps it.
fn outside(limit: &LotLimit, value: f64) -> Option<(f64, String)> {
    let (least, greatest) = (format!("at least {}", exact(limit.min)), format!("at most {}", exact(limit.max)));
    let two = limit.min.is_finite() && limit.max.is_finite();
    let by = |distance: f64, at: f64| distance / if two { limit.max - limit.min } else { at.abs() };
    if value > limit.max {
        Some((by(value - limit.max, limit.max), greatest))
    } else if value < limit.min {
        Some((by(limit.min - value, limit.min), least))
    } else if value.is_nan() {
        let words = [(limit.min, least), (limit.max, greatest)].into_iter().filter(|(at, _)| at.is_finite());
        Some((f64::INFINITY, words.map(|(_, words)| words).collect::<Vec<_>>().join(", ")))
    } else {
        None
    }
}

pub(super) fn table(rows: &[Outside<'_>]) -> Markup {
    let row = |row: &Outside<'_>| {
        vec![
            html! { (row.unit.serial) },
            html! { @if let Some(axis) = row.axis { (axis.name) } @else { "\u{2013}" } },
            html! { span.nobr { (row.unit.station) } },
            html! { (row.quantity.words()) ", counts" },
            html! { @if row.value.is_nan() { "none" } @else { (told_from(row)) } },
            html! { (row.limit) },
            html! { @if row.far.is_finite() { (fixed(100.0 * row.far, if row.far < 0.1 { 2 } else { 0 })) "\u{a0}%" } @else { "\u{2013}" } },
        ]
    };
    let units: std::collections::BTreeSet<(&str, &str)> =
        rows.iter().map(|row| (row.unit.serial.as_str(), row.unit.file.as_str())).collect();
    let caption = html! {
        (counted(units.len(), "unit")) " not rejected but outside a limit, the number furthest outside first: by how much in parts "
        "of the distance between the two limits, or of the limit where there is one."
    };
    let heads = ["Unit", "Axis", "Station", "Quantity", "Value", "Limit", "Outside by"];
    html! {
        (Table { caption, heads: &heads, rows: rows.iter().take(LISTED).map(row).collect(), numbers_from: 4 }.markup())
        @if rows.len() > LISTED { p { "… and " (counted(rows.len() - LISTED, "row")) " more." } }
    }
}

/// A value with four digits, or as many more as tell it from its limit.
fn told_from(row: &Outside<'_>) -> Markup {
    let limit = row.limit.rsplit(' ').next().unwrap_or_default();
    let same = |digits: &usize| {
        let rounded: f64 = format!("{:.*e}", digits - 1, row.value).parse().unwrap_or(f64::NAN);
        exact(rounded) == limit
    };
    let digits = (4..17).find(|digits| !same(digits)).unwrap_or(17);
    significant(row.value, digits)
}
