//! The report of a log as a page.

pub(super) mod axis;
mod noise;
mod parameters;

use maud::{Markup, html};

use super::log::{LeftOut, LogAxis, LogReport};
use super::number::{decimals_for, fixed, polynomial, thousandfold, whole};
use super::page::{self, Table};
use super::{candidates, figure};
use zerorate_cal::quality::Verdict;

impl LogReport {
    /// The report as one self-contained HTML file. Equal reports make equal bytes.
    #[must_use]
    pub fn to_html(&self) -> String {
        let mut chapters: Vec<(&str, &str, Markup)> = Vec::new();
        if !self.axes.is_empty() {
            chapters.push(("axes", "Before and after", self.before_and_after()));
        }
        if !self.left_out.is_empty() || self.axes.iter().any(|axis| !axis.samples_rejected.is_empty()) {
            chapters.push(("left-out", "What was left out", self.what_was_left_out()));
        }
        if !self.axes.is_empty() {
            chapters.push(("models", "The choice of the model", self.models()));
            if self.axes.iter().any(|axis| axis.characteristics.is_some()) {
                chapters.push(("noise", "Noise and sensitivities", noise::chapter(self)));
            }
            chapters.push(("coefficients", "Coefficients to copy", self.coefficients()));
            if !self.parameters.is_empty() {
                chapters.push(("parameters", "Parameters to copy", parameters::chapter(&self.parameters)));
            }
        }
        if !self.advice.is_empty() {
            let advice = html! { ul.reasons { @for sentence in &self.advice { li { (sentence) } } } };
            chapters.push(("advice", "How to get a better log", advice));
        }
        chapters.push(("reading", "How to read the numbers", definitions()));
        let links: Vec<(&str, &str)> = chapters.iter().map(|(id, heading, _)| (*id, *heading)).collect();
        let body = html! {
            header { (self.headline()) (page::contents(&links)) }
            main { @for (id, heading, chapter) in &chapters { (page::section(id, heading, chapter)) } }
        };
        page::page_with_script(&format!("Fit of {}", self.file_name()), &body, parameters::SCRIPT)
    }

    fn headline(&self) -> Markup {
        html! {
            p.over { "Fit of a gyroscope’s drift over temperature" }
            h1 { (self.file_name()) }
            @if self.file_name() != self.source { p.over { (self.source) } }
            p { (page::verdict(self.verdict)) }
            p.lead { (self.lead()) }
            @if !self.reasons.is_empty() {
                ul.reasons { @for reason in &self.reasons { li { (reason.text) } } }
            }
            @if let Some(command) = &self.next_command { p { "Next:" } pre { code { (command) } } }
            @if !self.axes.is_empty() { (self.summary()) }
            @if !self.notes.is_empty() { ul.reasons.small { @for note in &self.notes { li { (note) } } } }
        }
    }

    /// The last part of the source's path: the rest is in small type below it.
    fn file_name(&self) -> &str {
        self.source.rsplit(['/', '\\']).next().unwrap_or(&self.source)
    }

    fn lead(&self) -> Markup {
        match (self.verdict, self.axes.len()) {
            (Verdict::Rejected, _) | (_, 0) => html! { "No calibration comes of this log." },
            (_, axes) => html! {
                (axes) @if axes == 1 { " axis was" } @else { " axes were" }
                " fitted. What counts is the held-out residual: what the model leaves of data it has not seen."
            },
        }
    }

    /// One row an axis: what the model brings.
    fn summary(&self) -> Markup {
        let mut units: Vec<&str> = Vec::new();
        for axis in &self.axes {
            if !units.contains(&axis.rate_unit.as_str()) {
                units.push(&axis.rate_unit);
            }
        }
        html! { @for unit in units { (self.summary_in(unit)) } }
    }

    /// The axes of one unit.
    fn summary_in(&self, unit: &str) -> Markup {
        let axes: Vec<&LogAxis> = self.axes.iter().filter(|axis| axis.rate_unit == unit).collect();
        let largest = axes.iter().map(|axis| spread_of(axis).1).fold(0.0, f64::max);
        let (factor, rate) = thousandfold(largest, unit);
        // Three digits of the smallest axis, at most.
        let smallest = axes.iter().map(|axis| axis.in_sample.rms).fold(f64::INFINITY, f64::min);
        let scaled = |value: f64| html! { (fixed(value / factor, decimals_for(smallest / factor))) };
        let row = |axis: &&LogAxis| {
            let before = spread_of(axis);
            vec![
                html! { (axis.name) },
                html! { (axis.model) },
                scaled(before.0),
                scaled(axis.held_out.rms),
                html! { (fixed(before.0 / axis.held_out.rms, 1)) },
                scaled(axis.in_sample.rms),
                scaled(before.1),
                scaled(axis.held_out.pp),
                html! { (whole(axis.samples_used)) },
            ]
        };
        Table {
            caption: html! {
                "Before and after, in " (rate) ". Before is about its own mean; held out is about the prediction of a model that has "
                "not seen the stretch."
            },
            heads: &[
                "Axis",
                "Model",
                "Before, rms",
                "Held out, rms",
                "Times better",
                "In-sample, rms",
                "Before, pp",
                "Held out, pp",
                "Samples",
            ],
            rows: axes.iter().map(row).collect(),
            numbers_from: 2,
        }
        .markup()
    }

    fn before_and_after(&self) -> Markup {
        html! {
            @for (place, axis) in self.axes.iter().enumerate() {
                h3 { (axis.name) }
                (axis::figure(self, axis, place).markup())
            }
        }
    }

    fn what_was_left_out(&self) -> Markup {
        let unit = &self.temperature_unit;
        let stretch = |stretch: &LeftOut| {
            vec![
                html! { (stretch.reason) },
                html! { (fixed(stretch.start_s, 0)) },
                html! { (fixed(stretch.end_s, 0)) },
                html! { (fixed(stretch.temperature[0], 1)) " to " (fixed(stretch.temperature[1], 1)) },
                html! { (whole(stretch.rows)) },
            ]
        };
        let rejected = self.axes.iter().flat_map(|axis| {
            axis.samples_rejected.iter().map(move |rejected| {
                vec![html! { (axis.name) }, html! { (rejected.reason) }, html! { (whole(rejected.count)) }]
            })
        });
        let rejected: Vec<Vec<Markup>> = rejected.collect();
        html! {
            @if !self.left_out.is_empty() {
                (Table {
                    caption: html! { "Stretches left out of the fit, shaded in the figures." },
                    heads: &["Why", "From, s", "To, s", &format!("Temperature, {unit}"), "Rows"],
                    rows: self.left_out.iter().map(stretch).collect(),
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

    fn models(&self) -> Markup {
        html! {
            div.pair { @for axis in &self.axes { (candidates::table(&axis.name, &axis.candidates, &axis.rate_unit)) } }
        }
    }

    fn coefficients(&self) -> Markup {
        html! {
                    p {
                        "Temperature in " (self.temperature_unit)
                        ". Subtract the curve from the rate, and hold the temperature within the valid range."
                    }
        div.pair { @for (place, axis) in self.axes.iter().enumerate() { div {
                        h3 { (axis.name) ", " (axis.rate_unit) }
                        @if axis.is_polynomial {
                            div.equation { p { i { "bias" } " = " (polynomial(&axis.raw_coefficients, "T", 5)) } }
                        }
                        (parameters::to_copy(&format!("coefficients-{}", place + 1), &to_copy(axis)))
                    } } }
                }
    }
}

/// Coefficients in full, as most languages read them: the shortest text that gives back the same double.
fn to_copy(axis: &LogAxis) -> String {
    let numbers: Vec<String> = axis.raw_coefficients.iter().map(|c| format!("{c:e}")).collect();
    let what =
        if axis.is_polynomial { "lowest power first" } else { "values at equally spaced knots over the valid range" };
    format!(
        "# {}, {}: {what}\ncoefficients = [\n  {},\n]\nvalid_range = [{}, {}]\n",
        axis.name,
        axis.model,
        numbers.join(",\n  "),
        axis.temperature[0],
        axis.temperature[1]
    )
}

/// Root mean square about the mean, and peak to peak, of what was recorded.
fn spread_of(axis: &LogAxis) -> (f64, f64) {
    let rates = || axis.points.iter().map(|point| point.rate).filter(|rate| rate.is_finite());
    let count = rates().count() as f64;
    let mean = rates().sum::<f64>() / count;
    let rms = (rates().map(|rate| (rate - mean).powi(2)).sum::<f64>() / count).sqrt();
    let (min, max) = rates().fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), v| (min.min(v), max.max(v)));
    (rms, max - min)
}

fn definitions() -> Markup {
    html! {
        dl.terms {
            dt { "In-sample" }
            dd { "Measured on the data that the model was fitted to: always a little too good." }
            dt { "Held out" }
            dd { "The log is cut into eight contiguous stretches; each is predicted by a model fitted to the other seven." }
            dt { "rms, pp" }
            dd { "Root mean square, and peak to peak: the highest less the lowest." }
            dt { "Heating, cooling" }
            dd { "The two directions of one log. Where their points lie apart, the drift has a history that no function of temperature alone can hold." }
        }
    }
}
