//! What has come, drawn as the report draws it.

use maud::{Markup, html};
use zerorate_core::units::Axis;
use zerorate_fit::drift_fit::DriftFit;

use super::{LiveRun, RunGroup};
use crate::figure::{Figure, Ink, Mark, Panel, Sample};
use crate::number::counted;
use crate::panels::{self, MINUTE_S, TEMPERATURE, ink_of, name_of};

/// Both figures; nothing of a step without groups.
pub(super) fn figures(run: &LiveRun, fits: &[Option<DriftFit>; 2]) -> Markup {
    html! {
        @if run.axes.iter().all(|axis| axis.kept().is_empty()) {
            p { "No group of this step has come yet." }
        } @else {
            (over_temperature(run, fits).markup())
            (over_time(run).markup())
        }
    }
}

fn key(sample: Sample) -> Vec<(Ink, Sample, String)> {
    Axis::BOTH.map(|axis| (ink_of(axis), sample, name_of(axis).to_owned())).into()
}

/// The reading over temperature, with the fit of what has come so far, and below what it leaves.
fn over_temperature(run: &LiveRun, fits: &[Option<DriftFit>; 2]) -> Figure {
    let columns = Axis::BOTH.map(|axis| {
        let groups = run.axes[axis.index()].ramp();
        let readings: Vec<_> = groups.iter().map(|group| (group.temperature_counts, group.reading_counts)).collect();
        // The fit is of what is not compensated, and tells nothing of the rest.
        let of_fit: Vec<RunGroup> = groups.iter().copied().filter(|group| !group.is_compensated).collect();
        let fitted = fits[axis.index()].as_ref().map(|fit| fit_at(fit, &of_fit));
        let left = fitted.as_ref().map(|fitted| {
            let left = |(group, (t, fitted)): (&RunGroup, &(f64, f64))| (*t, group.reading_counts - fitted);
            of_fit.iter().zip(fitted).map(left).collect()
        });
        let curve = fitted.map(|mut fitted| {
            fitted.sort_by(|a, b| a.0.total_cmp(&b.0));
            fitted
        });
        let mut column = vec![panels::over_temperature(axis, readings, curve, run.celsius())];
        column.extend(left.map(|left| panels::residual(axis, left, "the fit so far")));
        column
    });
    let is_fitted = fits.iter().any(Option::is_some);
    let mut key = key(Sample::Dot);
    if is_fitted {
        key.push((
            Ink::Curve,
            Sample::Line,
            format!("{} through what has come so far, uncompensated", run.running_model()),
        ));
    }
    let came = run.axes.iter().map(super::RunGroups::came).max().unwrap_or(0);
    Figure {
        id: "fig-1".into(),
        name: "Figure 1".into(),
        caption: html! {
            "Zero-rate output against temperature"
            @if run.ended.is_none() { " in the step that runs, " (counted(came, "group")) " so far" }
            @else { " in what was recorded last, " (counted(came, "group")) }
            @if is_fitted { "; below, what the fit leaves of them (in-sample)" } "."
        },
        key,
        columns: columns.into(),
    }
}

/// A fit at the temperatures of groups, in their order.
fn fit_at(fit: &DriftFit, groups: &[RunGroup]) -> Vec<(f64, f64)> {
    let biases = fit.model.biases(groups.iter().map(|group| (group.time_s, group.temperature_counts)));
    groups.iter().map(|group| group.temperature_counts).zip(biases).collect()
}

/// Reading and temperature over time.
fn over_time(run: &LiveRun) -> Figure {
    let began = run.axes.iter().filter_map(|axis| Some(axis.kept().first()?.time_s)).fold(f64::INFINITY, f64::min);
    let panel = |title: &str, up: &str, of: fn(&RunGroup) -> f64| {
        let line = |axis: Axis| {
            let groups = run.axes[axis.index()].kept().iter();
            Mark::Line(ink_of(axis), groups.map(|group| ((group.time_s - began) / MINUTE_S, of(group))).collect())
        };
        Panel::new(title, "time, min", up, Axis::BOTH.map(line))
    };
    let reading = panel("Zero-rate output against time", "zero-rate output, counts", |group| group.reading_counts);
    let temperature = panel("Temperature against time", TEMPERATURE, |group| group.temperature_counts);
    Figure {
        id: "fig-2".into(),
        name: "Figure 2".into(),
        caption: html! { "Zero-rate output and temperature against time in the step that runs." },
        key: key(Sample::Line),
        columns: vec![vec![reading], vec![temperature]],
    }
}
