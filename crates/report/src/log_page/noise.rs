//! The noise of the residuals, and the sensitivities that the recording holds.

use maud::{Markup, html};

use zerorate_cal::log_fit::{AxisFit, LogFit};
use zerorate_cal::units::{RateScale, WrittenRate};
use zerorate_characterise::{Characteristics, ResidualNoise, told_of_sensitivities};
use zerorate_fit::allan::AllanPoint;

use super::degree;
use crate::figure::{Figure, Ink, Mark, Panel, Sample};
use crate::number::{fixed, significant};
use crate::page::{Table, told};

/// Averaging times beyond this many seconds carry the temperature's cycle more than noise; the caption says so.
const SECONDS_AN_HOUR: f64 = 3600.0;

/// An axis and the unit in which its rates are told.
#[derive(Clone, Copy)]
struct Told<'a> {
    axis: &'a AxisFit,
    scale: RateScale,
}

impl Told<'_> {
    fn name(self) -> Markup {
        html! { (self.axis.name) ", " (self.scale.unit()) }
    }

    /// A rate, or one over another quantity.
    fn rate(self, value: f64, digits: usize) -> Markup {
        significant(self.scale.of_rate(value), digits)
    }
}

pub(super) fn chapter(fit: &LogFit, units: Option<WrittenRate>) -> Markup {
    let told_as = |axis| Told { axis, scale: fit.scale(axis.calibration.rate_unit, units) };
    let axes: Vec<(Told, Characteristics)> =
        fit.axes.iter().map(|axis| (told_as(axis), Characteristics::of(axis, units))).collect();
    let drawn = axes.iter().filter_map(|(axis, found)| Some((*axis, found.residual_noise.as_ref().ok()?)));
    let drawn: Vec<(Told, &ResidualNoise)> = drawn.collect();
    html! {
        (sensitivities(fit, &axes, units))
        @if !drawn.is_empty() {
            (figure(fit, &drawn).markup())
        }
        @for (axis, found) in &axes {
            @if let Err(why) = &found.residual_noise { p.small { (axis.axis.name) ": no Allan deviation: " (told(why)) "." } }
        }
    }
}

/// A row an axis, under IEEE's names.
fn sensitivities(fit: &LogFit, axes: &[(Told, Characteristics)], units: Option<WrittenRate>) -> Markup {
    let degree = degree(fit);
    let mut rows = Vec::new();
    for (axis, found) in axes {
        let slope = found.temperature_sensitivity;
        let error = |error: f64| html! { @if error > 0.0 { " ± " (axis.rate(error, 1)) } };
        let mut cells = vec![
            axis.name(),
            html! { (axis.rate(slope.mean, 3)) (error(slope.mean_standard_error)) },
            html! {
                (axis.rate(slope.steepest, 3)) (error(slope.steepest_standard_error)) " at "
                (fixed(slope.steepest_at, 0))
            },
        ];
        cells.push(match &found.hysteresis {
            Ok(found) => html! {
                (axis.rate(found.mean, 3)) (error(found.mean_standard_error)) "; "
                (axis.rate(found.largest, 3)) (error(found.standard_error)) " at " (fixed(found.at, 0))
                @if found.share.is_finite() { " (" (fixed(100.0 * found.share, 0)) " %)" }
            },
            Err(_) => html! { "–" },
        });
        cells.push(match &found.ramp_sensitivity {
            Ok(found) => html! { (axis.rate(found.value, 3)) " ± " (axis.rate(found.standard_error, 2)) },
            Err(_) => html! { "–" },
        });
        rows.push(cells);
    }
    let told_of = told_of_sensitivities(axes.iter().map(|(axis, found)| (axis.axis, found)), units);
    let caption = html! {
        "Sensitivities of the bias, as IEEE Std 952 names them: to temperature of the straight line nearest to the curve, and of the curve where it is steepest. Hysteresis is heating less cooling at equal temperature: its mean, "
        "and where it is likely to be largest, in brackets over the peak to peak of the curve. ± is one standard error by the noise from one average "
        "to the next, and of hysteresis by how the rate wanders meanwhile. The ramp sensitivity is of what the curve leaves. "
        "Beside plays the temperature sensitivity is of the cubic for autopilots; beside plays or lags its error is not known."
    };
    let heads = [
        "Axis",
        &format!("Temperature sensitivity, per {degree}"),
        "Steepest",
        "Thermal hysteresis",
        &format!("Ramp sensitivity, per {degree}/s"),
    ];
    html! {
        (Table { caption, heads: &heads, rows, numbers_from: 1 }.wide_markup())
        @for sentence in &told_of { p.small { (told(sentence)) "." } }
    }
}

/// One panel an axis, two a row: the curve with its confidence.
fn figure(fit: &LogFit, axes: &[(Told, &ResidualNoise)]) -> Figure {
    let panel = |(Told { axis, scale }, allan): &(Told, &ResidualNoise)| {
        let of = |value: fn(&AllanPoint) -> f64| -> Vec<(f64, f64)> {
            allan
                .points
                .iter()
                .map(|point| (libm::log10(point.tau_s), libm::log10(scale.of_rate(value(point)))))
                .collect()
        };
        let marks = [
            Mark::Line(Ink::Aim, of(|point| point.low)),
            Mark::Line(Ink::Aim, of(|point| point.high)),
            Mark::Line(Ink::X, of(|point| point.deviation)),
            Mark::Dots(Ink::X, of(|point| point.deviation)),
        ];
        let title = format!("{}: Allan deviation of the residual", axis.name);
        let up = format!("{}: Allan deviation, {}", axis.name, scale.unit());
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
            @if longest > SECONDS_AN_HOUR { " (hours)" } ", and what it has taken of the noise is missing. So no random walk, bias "
            "instability or rate random walk is read here: "
            code { "zerorate characterise" } " does so of the soaks of a log, sample by sample."
        },
        key: vec![
            (Ink::X, Sample::Dot, "Allan deviation".to_owned()),
            (Ink::Aim, Sample::Line, "95 % confidence".to_owned()),
        ],
        columns,
    }
}
