//! The first screen of a log's page: what speaks against it, what a deployed device gets, of what the page is.

use maud::{Markup, html};
use zerorate_cal::calibration::{CREATED_BY, Origin};
use zerorate_cal::log_fit::{AxisFit, LogFit};
use zerorate_cal::quality::Verdict;
use zerorate_cal::units::{RateScale, RateUnit};
use zerorate_fit::drift_fit::{A_FOLD_MISSES_ITS_BRANCH, A_HISTORY_GOES_BY_AVERAGES, FitStatistics};
use zerorate_fit::residual::ResidualStatistics;

use super::{LogPage, degree};
use crate::number::{decimals_for, fixed, times_smaller, whole, with_error};
use crate::page::{self, Table, told};
use crate::ranges::measured_temperatures;
use crate::trend::trend_sentences;

impl LogPage<'_> {
    /// What speaks against the log stands before every number that speaks for it.
    pub(super) fn headline(&self, source: &str, file: &str) -> Markup {
        let fit = self.fit;
        let trends = trend_sentences(fit, self.units);
        html! {
            p.over { "Fit of a gyroscope’s drift over temperature" }
            h1 { (file) }
            @if file != source { p.over { (source) } }
            p { (page::verdict(fit.judgement.verdict)) }
            @if let Some(rejected) = rejected_axes(fit) { p { b.rejected { (rejected) } } }
            @if !fit.judgement.reasons.is_empty() {
                ul.reasons { @for reason in fit.reasons() { li { (told(reason)) } } }
            }
            p.lead { (lead(fit)) }
            @for unit in units(fit) { (self.deployed(unit)) }
            @if !trends.is_empty() { ul.reasons { @for trend in &trends { li { (trend) } } } }
            (self.facts())
            @if let Some(command) = self.next_command { p { "Next:" } pre { code { (command) } } }
            @if !fit.notes.is_empty() { ul.reasons.small { @for note in &fit.notes { li { (told(note)) } } } }
        }
    }

    /// What a device has left: one row an axis of a unit.
    fn deployed(&self, unit: RateUnit) -> Markup {
        let fit = self.fit;
        let axes = axes_in(fit, unit);
        let scale = fit.scale(unit, self.units);
        let decimals = decimals(&axes, scale);
        let row = |axis: &&AxisFit| {
            let (before, statistics) = (before(axis), &axis.calibration.fit.statistics);
            let left = left(statistics).unwrap_or(ResidualStatistics::NONE);
            let scaled = |rate: f64| html! { (fixed(scale.of_rate(rate), decimals)) };
            vec![
                html! { (axis.name) },
                rms(left, scale, decimals),
                html! { (times_smaller(before.rms / left.rms)) },
                scaled(left.pp),
                scaled(before.rms),
                scaled(before.pp),
                html! { (axis.calibration.fit.chosen_model()) },
                html! { (whole(statistics.samples_used)) },
            ]
        };
        let [left_rms, left_pp] = match is_deployed(fit) {
            true => ["Deployed, rms", "Deployed, pp"],
            false => ["Held out, rms", "Held out, pp"],
        };
        Table {
            caption: html! {
                b { @if is_deployed(fit) { "What a deployed device has left" } @else { "What is left, held out" } } ", in "
                (scale.unit()) ". "
                @if is_deployed(fit) {
                    "Of a whole log like this one, its zero taken in the " (fit.zero_taken_in()) ": held out. The log’s own "
                    "drift in time, which no device knows, is left in it. "
                    @if !fit.steps.is_empty() { "The steps told below are taken out of it. " }
                    "Uncorrected is the same without a model. "
                } @else { "Uncorrected is about its own mean. " }
                "± is one standard error, by how much the eight folds of the log differ"
                @if is_deployed(fit) { " and by the noise of the zero" } "."
                @if is_deployed(fit) && axes.iter().any(|axis| axis.calibration.fit.model.history.is_some()) {
                    " " (A_HISTORY_GOES_BY_AVERAGES) "."
                }
                @if axes.iter().any(|axis| axis.calibration.fit.misses_its_own_branch()) {
                    " " (A_FOLD_MISSES_ITS_BRANCH) "."
                }
            },
            heads: &["Axis", left_rms, "Times smaller, by rms", left_pp, "Uncorrected, rms", "Uncorrected, pp", "Model", "Rows used"],
            rows: axes.iter().map(row).collect(),
            numbers_from: 1,
        }
        .wide_markup()
    }

    /// What is left within the recording: smaller than what a device gets.
    pub(super) fn within_the_recording(&self, unit: RateUnit) -> Markup {
        let axes = axes_in(self.fit, unit);
        let scale = self.fit.scale(unit, self.units);
        let decimals = decimals(&axes, scale);
        let row = |axis: &&AxisFit| {
            let statistics = &axis.calibration.fit.statistics;
            let held_out = statistics.held_out.unwrap_or(ResidualStatistics::NONE);
            let scaled = |rate: f64| html! { (fixed(scale.of_rate(rate), decimals)) };
            let in_sample = statistics.in_sample;
            vec![
                html! { (axis.name) },
                scaled(in_sample.rms),
                scaled(in_sample.pp),
                rms(held_out, scale, decimals),
                scaled(held_out.pp),
            ]
        };
        Table {
            caption: html! {
                "Within the recording, in " (scale.unit()) ": how well the model describes this log, its own drift in time and "
                "its history from the start on taken as known. No device knows those."
                @if self.fit.sources.len() > 1 { " The levels of the logs differ, and that is in it." }
            },
            heads: &["Axis", "In-sample, rms", "In-sample, pp", "Held out, rms", "Held out, pp"],
            rows: axes.iter().map(row).collect(),
            numbers_from: 1,
        }
        .wide_markup()
    }

    /// Of which unit the page is, by whom and by which program.
    fn facts(&self) -> Markup {
        let mut facts: Vec<(&str, Markup)> = Vec::new();
        facts.extend(self.serial.map(|serial| ("Serial number", html! { (serial) })));
        facts.extend(self.labels.iter().map(|(name, label)| (name.as_str(), html! { (label) })));
        facts.extend(duration(self.fit).map(|duration| ("Duration", html! { (duration) })));
        // Of a log that does not know its own date, the file's is the next best.
        let (dated, others): (Vec<&Origin>, Vec<&Origin>) = self.sources.iter().partition(|log| log.started.is_some());
        let recorded = dated.into_iter().filter_map(|log| log.started.as_deref());
        let changed = others.into_iter().filter_map(|log| log.changed.as_deref());
        facts.extend(times(recorded).map(|times| ("Recorded", html! { (times) })));
        facts.extend(times(changed).map(|times| ("File last changed", html! { (times) })));
        facts.push(("Made by", html! { (CREATED_BY) }));
        page::facts(&facts)
    }
}

/// The axes of a log that are not in its calibration; `None` where there are none, or no others.
fn rejected_axes(fit: &LogFit) -> Option<String> {
    let rejected: Vec<&str> =
        fit.verdicts.iter().filter(|axis| axis.judgement.rejected()).map(|axis| axis.name.as_str()).collect();
    (!rejected.is_empty() && !fit.judgement.rejected())
        .then(|| format!("Rejected, and not in the calibration: {}.", rejected.join(", ")))
}

/// How long the fitted part of the log is; `None` of a log without times.
fn duration(fit: &LogFit) -> Option<String> {
    /// Of a longer log, hours are told.
    const MANY_MINUTES: f64 = 120.0;
    let last = |axis: &AxisFit| axis.trace.last().map_or(f64::NAN, |point| point.time_s);
    let minutes = fit.axes.iter().map(last).fold(f64::NAN, f64::max) / 60.0;
    let told = if minutes < MANY_MINUTES {
        format!("{} min", fixed(minutes, 0))
    } else {
        format!("{} h", fixed(minutes / 60.0, 1))
    };
    minutes.is_finite().then_some(told)
}

fn lead(fit: &LogFit) -> Markup {
    match (fit.judgement.verdict, fit.axes.len()) {
        (Verdict::Rejected, _) | (_, 0) => html! { "No calibration comes of this log." },
        (_, axes) => html! {
            (axes) @if axes == 1 { " axis was" } @else { " axes were" }
            " fitted, from " (measured_temperatures(&fit.axes.iter().collect::<Vec<_>>(), degree(fit))) ". What counts is "
            @if is_deployed(fit) { "what a deployed device has left" } @else { "the held-out residual" }
            ", of data that the model has not seen."
        },
    }
}

/// The units of the rates, each once, in the order of the axes.
pub(super) fn units(fit: &LogFit) -> Vec<RateUnit> {
    RateUnit::each(fit.axes.iter().map(|axis| axis.calibration.rate_unit))
}

fn axes_in(fit: &LogFit, unit: RateUnit) -> Vec<&AxisFit> {
    fit.axes.iter().filter(|axis| axis.calibration.rate_unit == unit).collect()
}

/// Decimals with which the smallest residual of some axes has three digits.
fn decimals(axes: &[&AxisFit], scale: RateScale) -> usize {
    let in_sample = axes.iter().map(|axis| axis.calibration.fit.statistics.in_sample.rms);
    decimals_for(scale.of_rate(in_sample.fold(f64::INFINITY, f64::min)))
}

fn rms(left: ResidualStatistics, scale: RateScale, decimals: usize) -> Markup {
    let error = left.rms_standard_error.map(|error| scale.of_rate(error));
    html! { (with_error(scale.of_rate(left.rms), error, decimals)) }
}

/// What a device has left of an axis without a model; where nobody knows, what was recorded, about its mean.
fn before(axis: &AxisFit) -> ResidualStatistics {
    if let Some(uncorrected) = axis.calibration.fit.statistics.uncorrected {
        return uncorrected;
    }
    let rates: Vec<f64> = axis.trace.iter().map(|point| point.rate).filter(|rate| rate.is_finite()).collect();
    ResidualStatistics::about_mean(&rates).0
}

/// Whether it is known what a deployed device has left; of a plain fit it is not.
fn is_deployed(fit: &LogFit) -> bool {
    fit.axes.iter().any(|axis| axis.calibration.fit.statistics.deployed.is_some())
}

/// What counts: what a deployed device has left, else what was held out.
fn left(statistics: &FitStatistics) -> Option<ResidualStatistics> {
    statistics.deployed.or(statistics.held_out)
}

/// Times, if there are any.
fn times<'a>(times: impl Iterator<Item = &'a str>) -> Option<String> {
    let told: Vec<String> = times.map(to_the_minute).collect();
    (!told.is_empty()).then(|| told.join(", "))
}

/// A time of RFC 3339 as people read it: `2026-03-01 08:00 UTC`.
fn to_the_minute(time: &str) -> String {
    match time.split_once('T') {
        Some((day, of_day)) => format!("{day} {} UTC", of_day.get(..5).unwrap_or(of_day)),
        None => time.to_owned(),
    }
}
