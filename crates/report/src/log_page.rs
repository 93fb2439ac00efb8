//! The page of a log's fit.

pub(super) mod axis;
mod noise;
mod parameters;

use maud::{Markup, html};
use zerorate_cal::calibration::{CREATED_BY, Origin};
use zerorate_cal::condition::{Excluded, Rejected};
use zerorate_cal::log_fit::{AxisFit, LogFit};
use zerorate_cal::quality::Verdict;
use zerorate_cal::units::{RateUnit, TemperatureUnit};
use zerorate_core::drift::Shape;
use zerorate_export::Format;
use zerorate_fit::drift_fit::FitStatistics;
use zerorate_fit::least_squares::raw_coefficients;
use zerorate_fit::residual::ResidualStatistics;

use super::candidates;
use super::number::{decimals_for, fixed, polynomial, thousandfold, whole};
use super::page::{self, Chapter, Table, told};

/// The page of a log's fit, and what its caller knows besides.
#[derive(Debug, Clone, Copy)]
pub struct LogPage<'a> {
    /// The fit.
    pub fit: &'a LogFit,
    /// The logs with their SHA-256, where they are known.
    pub sources: &'a [Origin],
    /// The command to type next, if there is one.
    pub next_command: Option<&'a str>,
    /// The command that writes the parameters of a program to a file, if there is one.
    pub export_command: Option<fn(Format) -> String>,
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
            chapters.push(("axes", "Before and after", before_and_after(fit)));
        }
        if !fit.excluded.is_empty() || fit.axes.iter().any(|axis| !axis.samples_rejected.is_empty()) {
            chapters.push(("excluded", "What was excluded", excluded(fit)));
        }
        if fit.axes.iter().any(|axis| axis.calibration.fit.statistics.candidates.len() > 1) {
            chapters.push(("models", "The choice of the model", models(fit)));
        }
        if !fit.axes.is_empty() {
            chapters.push(("noise", "Noise and sensitivities", noise::chapter(fit)));
            chapters.push(("coefficients", "Coefficients to copy", coefficients(fit)));
            let parameters = parameters::chapter(fit, self.export_command);
            chapters.extend(parameters.map(|chapter| ("parameters", "Parameters to copy", chapter)));
        }
        let advice = fit.judgement.advice();
        if !advice.is_empty() {
            let advice = html! { ul.reasons { @for sentence in advice { li { (told(sentence)) } } } };
            chapters.push(("advice", "How to get a better log", advice));
        }
        chapters.push(("reading", "How to read the numbers", definitions()));
        if !self.sources.is_empty() {
            chapters.push(("sources", "What this page is made of", sources(self.sources)));
        }
        let title = format!("Fit of {file}");
        page::page_with_script(&title, &self.headline(&source, file), &chapters, parameters::SCRIPT)
    }

    fn headline(&self, source: &str, file: &str) -> Markup {
        let fit = self.fit;
        html! {
            p.over { "Fit of a gyroscope’s drift over temperature" }
            h1 { (file) }
            @if file != source { p.over { (source) } }
            p { (page::verdict(fit.judgement.verdict)) }
            p.lead { (lead(fit)) }
            @if !fit.judgement.reasons.is_empty() {
                ul.reasons { @for reason in fit.reasons() { li { (told(reason)) } } }
            }
            @if let Some(command) = self.next_command { p { "Next:" } pre { code { (command) } } }
            @for unit in units(fit) { (summary(fit, unit)) }
            @if !fit.notes.is_empty() { ul.reasons.small { @for note in &fit.notes { li { (told(note)) } } } }
        }
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

fn lead(fit: &LogFit) -> Markup {
    match (fit.judgement.verdict, fit.axes.len()) {
        (Verdict::Rejected, _) | (_, 0) => html! { "No calibration comes of this log." },
        (_, axes) => html! {
            (axes) @if axes == 1 { " axis was" } @else { " axes were" }
            " fitted" @if let Some(measured) = measured(fit) { ", from " (measured) } ". What counts is "
            @if is_deployed(fit) { "what a deployed device has left" } @else { "the held-out residual" }
            ", of data that the model has not seen."
        },
    }
}

/// The temperatures that were measured, of all axes.
fn measured(fit: &LogFit) -> Option<String> {
    let ranges = || fit.axes.iter().map(|axis| axis.calibration.fit.measured);
    let min = ranges().map(|range| range.min()).reduce(f64::min)?;
    let max = ranges().map(|range| range.max()).reduce(f64::max)?;
    Some(format!("{} to {} {}", fixed(min, 1), fixed(max, 1), degree(fit)))
}

/// The logs, so that a page can be told from another of the same name.
fn sources(sources: &[Origin]) -> Markup {
    html! {
        p { "Made by " (CREATED_BY) ", of:" }
        ul { @for source in sources { li { (source.file) ", SHA-256 " code { (source.sha256) } } } }
    }
}

/// The units of the rates, each once, in the order of the axes.
fn units(fit: &LogFit) -> Vec<RateUnit> {
    let mut units: Vec<RateUnit> = Vec::new();
    for axis in &fit.axes {
        if !units.contains(&axis.calibration.rate_unit) {
            units.push(axis.calibration.rate_unit);
        }
    }
    units
}

/// What a device has left of an axis without a model; where nobody knows, what was recorded, about its mean.
fn before(axis: &AxisFit) -> ResidualStatistics {
    if let Some(uncorrected) = axis.calibration.fit.statistics.uncorrected {
        return uncorrected;
    }
    let rates: Vec<f64> = axis.trace.iter().map(|point| point.rate).filter(|rate| rate.is_finite()).collect();
    ResidualStatistics::about_mean(&rates).0
}

/// What the model brings: one row an axis of a unit.
fn summary(fit: &LogFit, unit: RateUnit) -> Markup {
    let axes: Vec<&AxisFit> = fit.axes.iter().filter(|axis| axis.calibration.rate_unit == unit).collect();
    let largest = axes.iter().map(|axis| before(axis).pp).fold(0.0, f64::max);
    let (factor, rate) = thousandfold(largest, &unit.to_string());
    // Three digits of the smallest axis, at most.
    let in_sample = |axis: &AxisFit| axis.calibration.fit.statistics.in_sample.rms;
    let smallest = axes.iter().map(|axis| in_sample(axis)).fold(f64::INFINITY, f64::min);
    let scaled = |value: f64| html! { (fixed(value / factor, decimals_for(smallest / factor))) };
    let none = ResidualStatistics::NONE;
    let row = |axis: &&AxisFit| {
        let (before, statistics) = (before(axis), &axis.calibration.fit.statistics);
        let left = left(statistics).unwrap_or(none);
        vec![
            html! { (axis.name) },
            html! { (axis.calibration.fit.chosen_model()) },
            scaled(before.rms),
            scaled(left.rms),
            html! { (fixed(before.rms / left.rms, 1)) },
            scaled(before.pp),
            scaled(left.pp),
            html! { (whole(statistics.samples_used)) },
        ]
    };
    let within = |axis: &&AxisFit| {
        let statistics = &axis.calibration.fit.statistics;
        let held_out = statistics.held_out.unwrap_or(none);
        let figures = [statistics.in_sample.rms, statistics.in_sample.pp, held_out.rms, held_out.pp];
        std::iter::once(html! { (axis.name) }).chain(figures.map(scaled)).collect()
    };
    let [left_rms, left_pp] = match is_deployed(fit) {
        true => ["Deployed, rms", "Deployed, pp"],
        false => ["Held out, rms", "Held out, pp"],
    };
    html! {
        (Table {
            caption: html! {
                "Before and after, in " (rate) ". "
                @if is_deployed(fit) {
                    "Deployed is what a device has left of a whole log like this one that takes its zero in the first half "
                    "minute: held out, and without the log’s own drift in time. Before is the same without a model."
                } @else { "Before is about its own mean." }
            },
            heads: &["Axis", "Model", "Before, rms", left_rms, "Times smaller, by rms", "Before, pp", left_pp, "Samples"],
            rows: axes.iter().map(row).collect(),
            numbers_from: 2,
        }.markup())
        (Table {
            caption: html! {
                "Within the recording, in " (rate) ": how well the model describes this log, its own drift in time and its "
                "history from the start on taken as known. No device knows those."
            },
            heads: &["Axis", "In-sample, rms", "In-sample, pp", "Held out, rms", "Held out, pp"],
            rows: axes.iter().map(within).collect(),
            numbers_from: 1,
        }.markup())
    }
}

/// Whether it is known what a deployed device has left; of a plain fit it is not.
fn is_deployed(fit: &LogFit) -> bool {
    fit.axes.iter().any(|axis| axis.calibration.fit.statistics.deployed.is_some())
}

/// What counts: what a deployed device has left, else what was held out.
fn left(statistics: &FitStatistics) -> Option<ResidualStatistics> {
    statistics.deployed.or(statistics.held_out)
}

fn before_and_after(fit: &LogFit) -> Markup {
    html! {
        @for (place, axis) in fit.axes.iter().enumerate() {
            h3 { (axis.name) }
            (axis::figure(fit, axis, place).markup())
        }
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
                caption: html! { "Samples left out, each axis by itself." },
                heads: &["Axis", "Why", "Samples"],
                rows: rejected,
                numbers_from: 2,
            }.markup())
        }
    }
}

fn models(fit: &LogFit) -> Markup {
    let table = |axis: &AxisFit| {
        let own = &axis.calibration;
        candidates::table(&axis.name, &own.fit.statistics.candidates, &own.rate_unit.to_string())
    };
    html! { div.pair { @for axis in &fit.axes { (table(axis)) } } }
}

fn coefficients(fit: &LogFit) -> Markup {
    html! {
        p {
            "Temperature in " (degree(fit))
            ". Subtract the curve from the rate, and hold the temperature within the valid range. Where that is wider than "
            "the measured range, the curve was tested a little beyond what it was fitted to, and is believed so far."
        }
        div.pair { @for (place, axis) in fit.axes.iter().enumerate() { div {
            @let shape = &axis.calibration.drift().shape;
            h3 { (axis.name) ", " (axis.calibration.rate_unit) }
            @if let Shape::Polynomial(_) = shape {
                div.equation { p { i { "bias" } " = " (polynomial(&raw_coefficients(shape), "T", 5)) } }
            }
            (parameters::to_copy(&format!("coefficients-{}", place + 1), &in_full(axis)))
        } } }
    }
}

/// Coefficients in full, as most languages read them: the shortest text that gives back the same double.
fn in_full(axis: &AxisFit) -> String {
    let drift = axis.calibration.drift();
    let numbers: Vec<String> = raw_coefficients(&drift.shape).iter().map(|number| format!("{number:e}")).collect();
    let what = match drift.shape {
        Shape::Polynomial(_) => "lowest power first",
        Shape::Table(_) => "piecewise linear: values at equally spaced knots over the valid range",
    };
    format!(
        "# {}, {}: {what}\ncoefficients = [\n  {},\n]\nmeasured_range = [{}, {}]\nvalid_range = [{}, {}]\n",
        axis.name,
        axis.calibration.fit.chosen_model(),
        numbers.join(",\n  "),
        axis.calibration.fit.measured.min(),
        axis.calibration.fit.measured.max(),
        drift.valid.min(),
        drift.valid.max()
    )
}

fn definitions() -> Markup {
    page::terms(&[
        (
            "Deployed",
            html! {
                "What a device has left of a whole log like this one, in averages over about 10 s: it takes its zero in the "
                "first half minute, and the prediction off from then on. Held out, and without the log’s own drift in time. "
                code { "zerorate verify" } " finds the same number in another run."
            },
        ),
        ("In-sample", html! { "Measured on the data that the model was fitted to: always a little too good." }),
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
