//! The figure of one axis: raw and corrected, over time and over temperature.

use maud::html;
use zerorate_cal::condition::Excluded;
use zerorate_cal::log_fit::{AxisFit, LogFit};
use zerorate_cal::units::{RateScale, WrittenRate};
use zerorate_fit::direction::warming;
use zerorate_fit::drift_fit::BandPoint;
use zerorate_fit::trace::TracePoint;

use super::degree;
use crate::figure::{Figure, Ink, Mark, Panel, Sample, holding};
use crate::number::significant;

/// Time in the unit that suits its span: its name and the seconds in it.
pub(super) fn time_unit(span_s: f64) -> (&'static str, f64) {
    match span_s {
        span if span < 300.0 => ("s", 1.0),
        span if span < 4.0 * 3600.0 => ("min", 60.0),
        _ => ("h", 3600.0),
    }
}

/// How a point's place in time is drawn.
struct Time {
    name: String,
    unit_s: Option<f64>,
}

impl Time {
    fn of(points: &[TracePoint]) -> Self {
        let last = points.iter().map(|point| point.time_s).fold(0.0, f64::max);
        // A log without times has none at all.
        if points.iter().any(|point| point.time_s.is_finite()) {
            let (name, unit_s) = time_unit(last);
            Self { name: format!("time, {name}"), unit_s: Some(unit_s) }
        } else {
            Self { name: "place in the log, points".to_owned(), unit_s: None }
        }
    }

    fn at(&self, place: usize, point: &TracePoint) -> f64 {
        self.unit_s.map_or(place as f64, |unit_s| point.time_s / unit_s)
    }
}

/// The edges of the next run's band, below and above, in the order of time: about what a device would have predicted, which
/// with a history is a loop.
fn band(axis: &AxisFit, scale: RateScale) -> Vec<Vec<(f64, f64)>> {
    let band = &axis.calibration.fit.next_run_band;
    if band.is_empty() {
        return Vec::new();
    }
    let places: Vec<(f64, f64)> = axis.trace.iter().map(|point| (point.time_s, point.temperature)).collect();
    let predicted = axis.calibration.fit.model.biases(places.iter().copied());
    let edge = |sign: f64| {
        let points = places.iter().zip(&predicted).filter(|(_, bias)| bias.is_finite());
        points.map(|((_, t), bias)| (*t, scale.of_rate(bias + sign * BandPoint::half_width_at(band, *t)))).collect()
    };
    vec![edge(-1.0), edge(1.0)]
}

pub(crate) fn figure(fit: &LogFit, axis: &AxisFit, units: Option<WrittenRate>, place: usize) -> Figure {
    let (name, points) = (&axis.name, &axis.trace);
    let scale = fit.scale(axis.calibration.rate_unit, units);
    let unit = scale.unit();
    let time = Time::of(points);
    let warming = warming(&points.iter().map(|point| point.temperature).collect::<Vec<_>>());
    let temperature_name = format!("temperature, {}", degree(fit));
    let (raw_name, left_name) = (format!("rate, {unit}"), format!("corrected, {unit}"));
    let over_time = |of: fn(&TracePoint) -> f64| -> Vec<(f64, f64)> {
        points.iter().enumerate().map(|(place, point)| (time.at(place, point), scale.of_rate(of(point)))).collect()
    };
    let going = |up: bool, of: fn(&TracePoint) -> f64| -> Vec<(f64, f64)> {
        let points = points.iter().zip(&warming).filter(|(_, warming)| **warming == up);
        points.map(|(point, _)| (point.temperature, scale.of_rate(of(point)))).collect()
    };
    let excluded = |unit_s: f64| {
        let band = move |interval: &Excluded| {
            Mark::Band(Ink::Excluded, interval.time_s.0 / unit_s, interval.time_s.1 / unit_s)
        };
        fit.excluded.iter().map(band)
    };
    let ends = holding(over_time(|p| p.rate).into_iter().map(|point| point.0));
    let over_time_panel = |title: String, up: &str, marks: Vec<Mark>| {
        let bands = time.unit_s.into_iter().flat_map(excluded);
        Panel { x_range: ends, ..Panel::new(title, &time.name, up, bands.chain(marks).collect::<Vec<_>>()) }
    };
    // In the order of time: with a history the prediction is a loop, and by temperature it would jump to and fro.
    let curve: Vec<(f64, f64)> = points.iter().map(|p| (p.temperature, scale.of_rate(p.rate - p.residual))).collect();
    let raw = vec![Mark::Dots(Ink::Raw, over_time(|p| p.rate))];
    let time_raw = over_time_panel(format!("{name}: rate against time"), &raw_name, raw);
    let left = vec![Mark::Dots(Ink::Corrected, over_time(|p| p.residual)), Mark::Level(Ink::Aim, 0.0)];
    let time_left = over_time_panel(format!("{name}: corrected rate against time"), &left_name, left);
    let both = |of: fn(&TracePoint) -> f64| {
        vec![Mark::Dots(Ink::Heating, going(true, of)), Mark::Dots(Ink::Cooling, going(false, of))]
    };
    let edges = band(axis, scale).into_iter().map(|edge| Mark::Line(Ink::Aim, edge));
    let raw: Vec<Mark> = both(|p| p.rate).into_iter().chain([Mark::Line(Ink::Curve, curve)]).chain(edges).collect();
    let title = format!("{name}: rate against temperature, with the curve");
    let warm_raw = Panel::new(title, &temperature_name, &raw_name, raw);
    let left: Vec<Mark> = both(|p| p.residual).into_iter().chain([Mark::Level(Ink::Aim, 0.0)]).collect();
    let title = format!("{name}: corrected rate against temperature");
    let warm_left = Panel::new(title, &temperature_name, &left_name, left);
    let mut key = vec![(Ink::Raw, Sample::Dot, "recorded"), (Ink::Corrected, Sample::Dot, "corrected")];
    for (up, ink, name) in [(true, Ink::Heating, "heating"), (false, Ink::Cooling, "cooling")] {
        if warming.contains(&up) {
            key.push((ink, Sample::Dot, name));
        }
    }
    key.push((Ink::Curve, Sample::Line, "fitted curve"));
    if !axis.calibration.fit.next_run_band.is_empty() {
        key.push((
            Ink::Aim,
            Sample::Line,
            "95 of 100 averages of a next run that goes the same way lie between, after a zero at its start, if the gyro does not wander by itself",
        ));
    }
    if !fit.excluded.is_empty() && time.unit_s.is_some() {
        key.push((Ink::Excluded, Sample::Patch, "excluded"));
    }
    let short = |panel| Panel { height: Panel::SHORT, ..panel };
    Figure {
        id: format!("axis-{}", place + 1),
        name: format!("Figure {}", place + 1),
        caption: html! {
            (name) ", " (axis.calibration.fit.chosen_model()) ": the rate against time and against temperature; below, less the "
            "fitted curve" @if axis.calibration.fit.model.time_drift.is_some() { " and the log’s own drift in time, which no device knows" }
            " (in-sample, " (significant(scale.of_rate(axis.calibration.fit.statistics.in_sample.rms), 3)) " " (unit) " rms)."
        },
        key: key.into_iter().map(|(ink, sample, what)| (ink, sample, what.to_owned())).collect(),
        columns: vec![vec![time_raw, short(time_left)], vec![warm_raw, short(warm_left)]],
    }
}
