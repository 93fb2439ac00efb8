//! The units that fail the limits.

use maud::{Markup, html};

use crate::lot::{LotAxis, LotLimit, LotReport, LotUnit, Quantity};
use crate::number::{counted, exact, significant};
use crate::page::Table;

/// Rows listed, at most.
const LISTED: usize = 200;

/// One number that is outside its limit.
pub(super) struct Outside<'a> {
    unit: &'a LotUnit,
    /// None for a unit that has no fit.
    axis: Option<&'a LotAxis>,
    quantity: Quantity,
    value: f64,
    /// The limit that it fails, counts.
    at: f64,
    /// The same in words.
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
                let (far, at, words) = outside(limit, value)?;
                Some(Outside { unit, axis, quantity: limit.quantity, value, at, limit: words, far })
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

/// How far a value is outside a limit, and of which side, as a number and in words; none for one that keeps it.
fn outside(limit: &LotLimit, value: f64) -> Option<(f64, f64, String)> {
    let (least, greatest) = (format!("at least {}", exact(limit.min)), format!("at most {}", exact(limit.max)));
    let two = limit.min.is_finite() && limit.max.is_finite();
    let by = |distance: f64, at: f64| distance / if two { limit.max - limit.min } else { at.abs() };
    if value > limit.max {
        Some((by(value - limit.max, limit.max), limit.max, greatest))
    } else if value < limit.min {
        Some((by(limit.min - value, limit.min), limit.min, least))
    } else if value.is_nan() {
        let words = [(limit.min, least), (limit.max, greatest)].into_iter().filter(|(at, _)| at.is_finite());
        Some((f64::INFINITY, f64::NAN, words.map(|(_, words)| words).collect::<Vec<_>>().join(", ")))
    } else {
        None
    }
}

pub(super) fn table(rows: &[Outside<'_>]) -> Markup {
    let row = |row: &Outside<'_>| {
        vec![
            html! { span.wraps-on-phone { (row.unit.serial) } },
            html! { @if let Some(axis) = row.axis { (axis.name) } @else { "\u{2013}" } },
            html! { span.nobr.wraps-on-phone { (row.unit.station) } },
            html! { (row.quantity.words()) ", counts" },
            html! { @if row.value.is_nan() { "none" } @else { (told_from(row)) } },
            html! { span.wraps-on-phone { (row.limit) } },
            html! { @if row.far.is_finite() { (significant(100.0 * row.far, 2)) "\u{a0}%" } @else { "\u{2013}" } },
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
        (Table { caption, heads: &heads, rows: rows.iter().take(LISTED).map(row).collect(), numbers_from: 4 }.wide_markup())
        @if rows.len() > LISTED { p { "… and " (counted(rows.len() - LISTED, "row")) " more." } }
    }
}

/// A value with four digits, or as many more as show it on its side of the limit.
fn told_from(row: &Outside<'_>) -> Markup {
    let told = |digits: &usize| {
        let rounded: f64 = format!("{:.*e}", digits - 1, row.value).parse().unwrap_or(f64::NAN);
        rounded.total_cmp(&row.at) == row.value.total_cmp(&row.at)
    };
    significant(row.value, (4..17).find(told).unwrap_or(17))
}

#[cfg(test)]
mod tests {
    use super::*;

    const READING: LotLimit = LotLimit { quantity: Quantity::Reading, min: 8000.0, max: 8400.0 };

    #[test]
    fn a_number_is_outside_by_parts_of_its_limits() {
        let far = |value| outside(&READING, value).map(|(far, _, words)| (far, words));
        assert_eq!(far(8500.0), Some((0.25, "at most 8400".to_owned())));
        assert_eq!(far(7600.0), Some((1.0, "at least 8000".to_owned())));
        assert_eq!(far(8400.0), None);
        assert_eq!(far(f64::NAN), Some((f64::INFINITY, "at least 8000, at most 8400".to_owned())));
        let one = LotLimit { quantity: Quantity::HeldOut, min: f64::NEG_INFINITY, max: 5.0 };
        assert_eq!(outside(&one, 7.5).map(|(far, _, _)| far), Some(0.5));
    }

    fn report(units: u32, value: f64) -> LotReport {
        let unit = |number: u32| LotUnit {
            serial: format!("ZR-{number:04}"),
            file: format!("ZR-{number:04}.parquet"),
            station: "chamber-1".into(),
            day: 0.0,
            rejected: Vec::new(),
            warned: Vec::new(),
            axes: vec![LotAxis { name: "X".into(), values: [value; 5] }],
        };
        LotReport {
            source: String::new(),
            model: String::new(),
            units: (0..units).map(unit).collect(),
            limits: vec![READING],
            worst: Vec::new(),
            undrawn: Vec::new(),
            beside: None,
        }
    }

    #[test]
    fn a_value_just_outside_has_the_digits_that_show_it() {
        let page = |value| table(&rows(&report(1, value))).into_string();
        assert!(page(8400.003).contains(">8400.003<") && page(8512.34).contains(">8512<"));
    }

    #[test]
    fn a_long_list_is_cut_and_says_so_and_rejected_units_are_not_in_it() {
        let mut lot = report(251, 9000.0);
        lot.units[0].rejected = vec!["cut".into()];
        let page = table(&rows(&lot)).into_string();
        assert!(page.contains("… and 50 rows more.") && page.matches("<tr>").count() == 201);
        assert!(rows(&report(3, 8200.0)).is_empty());
    }

    #[test]
    fn a_unit_without_a_number_is_outside_furthest_of_all() {
        let mut lot = report(2, 9000.0);
        lot.units[1].axes.clear();
        let rows = rows(&lot);
        assert_eq!((rows[0].unit.serial.as_str(), rows[0].axis.is_none()), ("ZR-0001", true));
        assert!(table(&rows).into_string().contains(">none<"));
    }
}
