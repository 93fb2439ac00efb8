//! The page of a log's fit.

pub(super) mod axis;
mod chamber;
mod headline;
mod noise;
mod parameters;

use std::collections::BTreeMap;

use maud::{Markup, html};
use zerorate_cal::calibration::{CREATED_BY, Origin};
use zerorate_cal::condition::{Excluded, Rejected};
use zerorate_cal::in_chamber::InChamber;
use zerorate_cal::log_fit::{AxisFit, LogFit};
use zerorate_cal::units::{RateScale, TemperatureUnit, WrittenRate};
use zerorate_core::drift::{Drift, Shape};
use zerorate_export::{ExportedAxis, Format};
use zerorate_fit::least_squares::raw_coefficients;
use zerorate_fit::model::Model;

use super::advice::advice;
use super::by_log;
use super::candidates;
use super::number::{fixed, polynomial, whole};
use super::page::{self, Chapter, Table, told};

/// The page of a log's fit, and what its caller knows besides.
#[derive(Clone, Copy)]
pub struct LogPage<'a> {
    /// The fit.
    pub fit: &'a LogFit,
    /// The unit in which rates are told, if one was asked for.
    pub units: Option<WrittenRate>,
    /// The unit's serial number, where it is known.
    pub serial: Option<&'a str>,
    /// What the line knows of the calibration, by name, as `operator`.
    pub labels: &'a BTreeMap<String, String>,
    /// The chamber in which the unit lay, if it was recorded.
    pub chamber: Option<&'a InChamber>,
    /// The logs with their SHA-256, where they are known.
    pub sources: &'a [Origin],
    /// The command to type next, if there is one.
    pub next_command: Option<&'a str>,
    /// The command that writes the parameters of a program to a file, if there is one.
    pub export_command: Option<&'a dyn Fn(Format) -> String>,
}

impl LogPage<'_> {
    /// The page as one self-contained HTML file. Equal fits make equal bytes.
    #[must_use]
    pub fn to_html(&self) -> String {
        let fit = self.fit;
        let source = fit.source();
        // The last part of the path is the heading, and the rest stands in small type above it.
        let file = source.rsplit(['/', '\\']).next().unwrap_or(&source);
        let mut chapters: Vec<Chapter> = Vec::new();
        if !fit.axes.is_empty() {
            chapters.push(("axes", "Before and after", self.before_and_after()));
        }
        if let Some(chamber) = self.chamber {
            chapters.push(("chamber", "In the chamber", chamber::chapter(fit, chamber, self.units)));
        }
        if !fit.excluded.is_empty() || fit.axes.iter().any(|axis| !axis.samples_rejected.is_empty()) {
            chapters.push(("excluded", "What was excluded", excluded(fit)));
        }
        if fit.axes.iter().any(|axis| axis.calibration.fit.statistics.candidates.len() > 1) {
            chapters.push(("models", "The choice of the model", self.models()));
        }
        if !fit.axes.is_empty() {
            chapters.push(("noise", "Noise and sensitivities", noise::chapter(fit, self.units)));
            chapters.push(("coefficients", "Coefficients to copy", coefficients(fit, self.units)));
            let parameters = parameters::chapter(self);
            chapters.extend(parameters.map(|chapter| ("parameters", "Parameters to copy", chapter)));
        }
        let advice = advice(&fit.judgement);
        if !advice.is_empty() {
            let advice = html! { ul.reasons { @for sentence in advice { li { (told(sentence)) } } } };
            chapters.push(("advice", "How to get a better log", advice));
        }
        chapters.push(("reading", "How to read the numbers", definitions(fit)));
        if !self.sources.is_empty() {
            chapters.push(("sources", "What this page is made of", page::sources(CREATED_BY, self.sources)));
        }
        let title = format!("Fit of {file}");
        page::page_with_script(&title, &self.headline(&source, file), &chapters, parameters::SCRIPT)
    }

    fn before_and_after(&self) -> Markup {
        html! {
            @for unit in headline::units(self.fit) {
                (by_log::table(self.fit, unit, self.fit.scale(unit, self.units)))
                (self.within_the_recording(unit))
            }
            @for (place, axis) in self.fit.axes.iter().enumerate() {
                h3 { (axis.name) }
                (axis::figure(self.fit, axis, self.units, place).markup())
            }
        }
    }

    fn models(&self) -> Markup {
        let table = |axis: &AxisFit| {
            let scale = self.fit.scale(axis.calibration.rate_unit, self.units);
            candidates::table(&axis.name, &axis.calibration.fit.statistics, scale)
        };
        html! { div.pair { @for axis in &self.fit.axes { (table(axis)) } } }
    }
}

/// The unit of a log's temperatures, as it stands behind a number.
fn degree(fit: &LogFit) -> &'static str {
    match fit.axes.first().map(|axis| axis.temperature_unit) {
        Some(TemperatureUnit::C) => "°C",
        Some(TemperatureUnit::Counts) => "counts",
        None => "",
    }
}

fn excluded(fit: &LogFit) -> Markup {
    let interval = |interval: &Excluded| {
        vec![
            html! { (interval.reason.words()) },
            html! { (fixed(interval.time_s.0, 0)) },
            html! { (fixed(interval.time_s.1, 0)) },
            html! { (fixed(interval.temperature.0, 1)) " to " (fixed(interval.temperature.1, 1)) },
            html! { (whole(interval.rows.1 - interval.rows.0)) },
        ]
    };
    let rejected = fit.axes.iter().flat_map(|axis| {
        let row = move |rejected: &Rejected| {
            vec![html! { (axis.name) }, html! { (rejected.reason.words()) }, html! { (whole(rejected.count)) }]
        };
        axis.samples_rejected.iter().map(row)
    });
    let rejected: Vec<Vec<Markup>> = rejected.collect();
    html! {
        @if !fit.excluded.is_empty() {
            (Table {
                caption: html! { "Intervals excluded from the fit, shaded in the figures." },
                heads: &["Why", "From, s", "To, s", &format!("Temperature, {}", degree(fit)), "Rows"],
                rows: fit.excluded.iter().map(interval).collect(),
                numbers_from: 1,
            }.markup())
        }
        @if !rejected.is_empty() {
            (Table {
                caption: html! { "Rows left out, each axis by itself." },
                heads: &["Axis", "Why", "Rows"],
                rows: rejected,
                numbers_from: 2,
            }.markup())
        }
    }
}

fn coefficients(fit: &LogFit, units: Option<WrittenRate>) -> Markup {
    html! {
        p {
            "Temperature in " (degree(fit))
            ". Subtract the curve from the rate, and hold the temperature within the valid range. Where that is wider than "
            "the measured range, the curve was tested a little beyond what it was fitted to, and is believed so far; a cubic that stands for it is for "
            "the temperatures of the log that had no rate, too."
        }
        div.pair { @for (place, axis) in fit.axes.iter().enumerate() { div {
            @let shape = &copied(axis).shape;
            @let cost = cost(axis, fit.scale(axis.calibration.rate_unit, units));
            h3 { (axis.name) ", " (axis.calibration.rate_unit) }
            @if let Some(cost) = &cost {
                p.small { "Of " (axis.calibration.fit.chosen_model()) " this is the static cubic alone: " (cost) "." }
            }
            @if let Shape::Polynomial(_) = shape {
                div.equation { p { i { "bias" } " = " (polynomial(&raw_coefficients(shape), "T", 5)) } }
            }
            (parameters::to_copy(&format!("coefficients-{}", place + 1), &in_full(axis, cost.as_deref())))
        } } }
    }
}

/// The curve to copy: the model's own, or of a model that was chosen and is more than a polynomial the static cubic.
fn copied(axis: &AxisFit) -> &Drift {
    let fit = &axis.calibration.fit;
    let plain = fit.model.history.is_none() && matches!(fit.model.drift.shape, Shape::Polynomial(_));
    let cubic = fit.static_cubic.as_ref().filter(|_| !plain && fit.statistics.candidates.len() > 1);
    cubic.map_or(&fit.model.drift, |cubic| &cubic.drift)
}

/// What the static cubic costs, where it is the curve to copy.
fn cost(axis: &AxisFit, scale: RateScale) -> Option<String> {
    let calibration = &axis.calibration;
    let is_cubic = !std::ptr::eq(copied(axis), &calibration.fit.model.drift);
    is_cubic.then(|| ExportedAxis::of(&axis.name, calibration).cost(scale))
}

/// What the coefficients are of: the model chosen, or what four numbers can hold of it.
fn of_what(axis: &AxisFit, cost: Option<&str>) -> String {
    let (model, chosen) = (Model::of_shape(&copied(axis).shape), axis.calibration.fit.chosen_model());
    match (cost, &axis.calibration.fit.model.time_drift) {
        (Some(cost), _) => format!("{model}, the static cubic beside {chosen}\n# {cost}\n# "),
        (None, Some(_)) => format!("{model}, of {chosen} without the log's own drift in time: "),
        (None, None) => format!("{chosen}: "),
    }
}

/// Coefficients in full, as most languages read them: the shortest text that gives back the same double.
fn in_full(axis: &AxisFit, cost: Option<&str>) -> String {
    let drift = copied(axis);
    let numbers: Vec<String> = raw_coefficients(&drift.shape).iter().map(|number| format!("{number:e}")).collect();
    let what = match drift.shape {
        Shape::Polynomial(_) => "lowest power first",
        Shape::Table(_) => "piecewise linear: values at equally spaced knots over the valid range",
    };
    format!(
        "# {}, {}{what}\ncoefficients = [\n  {},\n]\nmeasured_range = [{}, {}]\nvalid_range = [{}, {}]\n",
        axis.name,
        of_what(axis, cost),
        numbers.join(",\n  "),
        axis.calibration.fit.measured.min(),
        axis.calibration.fit.measured.max(),
        drift.valid.min(),
        drift.valid.max()
    )
}

fn definitions(fit: &LogFit) -> Markup {
    page::terms(&[
        (
            "Deployed",
            html! {
                "What a device has left of a whole log like this one, in averages over " (fit.averaged_over()) ": it takes its "
                "zero in the " (fit.zero_taken_in()) ", and the prediction off from then on. Held out, but for the zero of a start that is colder or warmer than all else in the log; the log’s own drift in time, which no device knows, is left in it. "
                code { "zerorate verify" } " measures the same of another run."
            },
        ),
        ("In-sample", html! { "Measured on the data that the model was fitted to: as a rule a little too good." }),
        (
            "Held out",
            html! {
                "Blocked cross-validation: the log is cut into eight contiguous folds, and each fold is predicted by a model "
                "fitted to the other seven."
            },
        ),
        ("rms, pp", html! { "Root mean square, and peak to peak: the highest less the lowest." }),
        (
            "Heating, cooling",
            html! {
                "The two directions of one log. Where their points lie apart, the drift has a history that no function of "
                "temperature alone can hold."
            },
        ),
    ])
}
