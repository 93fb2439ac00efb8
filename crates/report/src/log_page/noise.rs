//! The noise of the residuals, and the sensitivities that the recording holds.

use maud::{Markup, html};

use zerorate_cal::characterise::Characteristics;
use zerorate_cal::log_fit::{AxisFit, LogFit};
use zerorate_fit::allan::{Allan, AllanPoint, Coefficient};

use super::degree;
use crate::figure::{Figure, Ink, Mark, Panel, Sample};
use crate::number::{fixed, significant};
use crate::page::{Table, told};

/// Averaging times beyond this many seconds carry the temperature's cycle more than noise; the caption says so.
const SECONDS_AN_HOUR: f64 = 3600.0;

pub(super) fn chapter(fit: &LogFit) -> Markup {
    let axes: Vec<(&AxisFit, Characteristics)> =
        fit.axes.iter().map(|axis| (axis, Characteristics::of(axis))).collect();
    let drawn = axes.iter().filter_map(|(axis, found)| Some((*axis, found.residual_noise.as_ref().ok()?)));
    let drawn: Vec<(&AxisFit, &Allan)> = drawn.collect();
    html! {
        (sensitivities(fit, &axes))
        @if !drawn.is_empty() {
            (figure(fit, &drawn).markup())
            (coefficients(&drawn))
        }
        @for (axis, found) in &axes {
            @if let Err(why) = &found.residual_noise { p.small { (axis.name) ": no Allan deviation: " (told(why)) "." } }
        }
    }
}

/// An axis and the unit of its rates.
fn with_unit(axis: &AxisFit) -> Markup {
    html! { (axis.name) ", " (axis.calibration.rate_unit) }
}

/// A row an axis, under IEEE's names.
fn sensitivities(fit: &LogFit, axes: &[(&AxisFit, Characteristics)]) -> Markup {
    let degree = degree(fit);
    let mut missing: Vec<String> = Vec::new();
    let mut rows = Vec::new();
    for (axis, found) in axes {
        let slope = found.temperature_sensitivity;
        let mut cells = vec![
            with_unit(axis),
            significant(slope.mean, 3),
            html! { (significant(slope.steepest, 3)) " at " (fixed(slope.steepest_at, 0)) },
        ];
        cells.push(match &found.hysteresis {
            Ok(found) => html! {
                (significant(found.largest, 3)) " at " (fixed(found.at, 0)) " (" (fixed(100.0 * found.share, 0)) " %)"
            },
            Err(_) => html! { "–" },
        });
        cells.push(match &found.ramp_sensitivity {
            Ok(found) => html! { (significant(found.value, 3)) " ± " (significant(found.standard_error, 2)) },
            Err(_) => html! { "–" },
        });
        rows.push(cells);
        for (what, why) in [
            ("thermal hysteresis", found.hysteresis.as_ref().err()),
            ("temperature-ramp sensitivity", found.ramp_sensitivity.as_ref().err()),
        ] {
            let sentence = why.map(|why| format!("No {what}: {why}."));
            missing.extend(sentence.filter(|sentence| !missing.contains(sentence)));
        }
    }
    let caption = html! {
        "Sensitivities of the bias, as IEEE Std 952 names them. Hysteresis is heating less cooling at equal temperature where it is "
        "largest, in brackets over the peak to peak of the curve; the ramp sensitivity is of what the model leaves."
    };
    let heads = [
        "Axis",
        &format!("Temperature sensitivity, per {degree}"),
        "Steepest",
        "Thermal hysteresis",
        &format!("Ramp sensitivity, per {degree}/s"),
    ];
    html! {
        (Table { caption, heads: &heads, rows, numbers_from: 1 }.markup())
        @for sentence in &missing { p.small { (told(sentence)) } }
    }
}

/// One panel an axis, two a row: the curve with its confidence.
fn figure(fit: &LogFit, axes: &[(&AxisFit, &Allan)]) -> Figure {
    let panel = |(axis, allan): &(&AxisFit, &Allan)| {
        let of = |value: fn(&AllanPoint) -> f64| -> Vec<(f64, f64)> {
            allan.points.iter().map(|point| (point.tau_s.log10(), value(point).log10())).collect()
        };
        let marks = [
            Mark::Line(Ink::Aim, of(|point| point.low)),
            Mark::Line(Ink::Aim, of(|point| point.high)),
            Mark::Line(Ink::X, of(|point| point.deviation)),
            Mark::Dots(Ink::X, of(|point| point.deviation)),
        ];
        let title = format!("{}: Allan deviation of the residual", axis.name);
        let up = format!("{}: Allan deviation, {}", axis.name, axis.calibration.rate_unit);
        Panel { height: 2600, logarithms: true, ..Panel::new(title, "averaging time, s", up, marks) }
    };
    let mut columns = vec![Vec::new(), Vec::new()];
    axes.iter().enumerate().for_each(|(place, axis)| columns[place % 2].push(panel(axis)));
    columns.retain(|column| !column.is_empty());
    let longest = axes.iter().filter_map(|(_, allan)| allan.points.last()).map(|point| point.tau_s).fold(0.0, f64::max);
    Figure {
        id: "allan".to_owned(),
        name: format!("Figure {}", fit.axes.len() + 1),
        caption: html! {
            "Overlapping Allan deviation of what the model leaves, with its 95 % confidence. These are residuals of a changing "
            "temperature and not of a soak: what the model misses stands in the long averages"
            @if longest > SECONDS_AN_HOUR { " (hours)" } ". "
            code { "zerorate characterise" } " looks at the soaks of a log, sample by sample."
        },
        key: vec![
            (Ink::X, Sample::Dot, "Allan deviation".to_owned()),
            (Ink::Aim, Sample::Line, "95 % confidence".to_owned()),
        ],
        columns,
    }
}

/// N, B and K.
fn coefficients(axes: &[(&AxisFit, &Allan)]) -> Markup {
    let cell = |coefficient: &Coefficient| match coefficient {
        Coefficient::Seen { value, low, high, .. } => html! {
            (significant(*value, 3)) " (" (significant(*low, 2)) " to " (significant(*high, 2)) ")"
        },
        Coefficient::Hidden { at_most } => html! { "below " (significant(*at_most, 2)) },
    };
    let row = |(axis, allan): &(&AxisFit, &Allan)| {
        let found = &allan.coefficients;
        vec![
            with_unit(axis),
            cell(&found.angle_random_walk),
            cell(&found.bias_instability),
            cell(&found.rate_random_walk),
        ]
    };
    Table {
        caption: html! { "What the curves are made of, with 95 % confidence; “below” where other noise hides it." },
        heads: &["Axis", "Random walk N, unit·√s", "Bias instability B, unit", "Rate random walk K, unit/√s"],
        rows: axes.iter().map(row).collect(),
        numbers_from: 1,
    }
    .markup()
}
