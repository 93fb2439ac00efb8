//! The figure of one axis: raw and corrected, over time and over temperature.

use maud::html;

use super::figure::{Figure, Ink, Mark, Panel, Sample, holding};
use crate::number::significant;
use crate::{LeftOut, LogAxis, LogPoint, LogReport};
use zerorate_fit::direction::warming;

/// Time in the unit that suits its span: its name and the seconds in it.
fn time_unit(span_s: f64) -> (&'static str, f64) {
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
    fn of(points: &[LogPoint]) -> Self {
        let last = points.iter().map(|point| point.elapsed_s).fold(0.0, f64::max);
        // A log without times has none at all.
        if points.iter().any(|point| point.elapsed_s.is_finite()) {
            let (name, unit_s) = time_unit(last);
            Self { name: format!("time, {name}"), unit_s: Some(unit_s) }
        } else {
            Self { name: "place in the log, points".to_owned(), unit_s: None }
        }
    }

    fn at(&self, place: usize, point: &LogPoint) -> f64 {
        self.unit_s.map_or(place as f64, |unit_s| point.elapsed_s / unit_s)
    }
}

/// The edges of the prediction band about the curve: below, above. The curve between its points is theirs.
fn band(axis: &LogAxis) -> Vec<Vec<(f64, f64)>> {
    let mut curve: Vec<(f64, f64)> = axis.points.iter().map(|p| (p.temperature, p.rate - p.corrected)).collect();
    curve.retain(|(t, value)| t.is_finite() && value.is_finite());
    curve.sort_by(|a, b| a.0.total_cmp(&b.0));
    if axis.band.is_empty() || curve.is_empty() {
        return Vec::new();
    }
    // Of the points nearest in temperature the mean: with a history the prediction is more than one curve.
    let near = (curve.len() / axis.band.len()).clamp(1, 40);
    let middle = |temperature: f64| {
        let after = curve.partition_point(|(t, _)| *t < temperature);
        let from = after.saturating_sub(near / 2 + 1).min(curve.len().saturating_sub(near));
        let nearest = &curve[from..(from + near).min(curve.len())];
        nearest.iter().map(|(_, value)| value).sum::<f64>() / nearest.len() as f64
    };
    let edge = |sign: f64| axis.band.iter().map(|(t, half)| (*t, middle(*t) + sign * half)).collect();
    vec![edge(-1.0), edge(1.0)]
}

pub(crate) fn figure(report: &LogReport, axis: &LogAxis, place: usize) -> Figure {
    let time = Time::of(&axis.points);
    let warming = warming(&axis.points.iter().map(|point| point.temperature).collect::<Vec<_>>());
    let temperature_name = format!("temperature, {}", report.temperature_unit);
    let (raw_name, left_name) = (format!("rate, {}", axis.rate_unit), format!("corrected, {}", axis.rate_unit));
    let over_time = |of: fn(&LogPoint) -> f64| -> Vec<(f64, f64)> {
        axis.points.iter().enumerate().map(|(place, point)| (time.at(place, point), of(point))).collect()
    };
    let going = |up: bool, of: fn(&LogPoint) -> f64| -> Vec<(f64, f64)> {
        let points = axis.points.iter().zip(&warming).filter(|(_, warming)| **warming == up);
        points.map(|(point, _)| (point.temperature, of(point))).collect()
    };
    let excluded = |unit_s: f64| {
        let band =
            move |interval: &LeftOut| Mark::Band(Ink::Excluded, interval.start_s / unit_s, interval.end_s / unit_s);
        report.left_out.iter().map(band)
    };
    let ends = holding(over_time(|p| p.rate).into_iter().map(|point| point.0));
    let over_time_panel = |title: String, up: &str, marks: Vec<Mark>| {
        let bands = time.unit_s.into_iter().flat_map(excluded);
        Panel { x_range: ends, ..Panel::new(title, &time.name, up, bands.chain(marks).collect::<Vec<_>>()) }
    };
    // In the order of time: with a history the prediction is a loop, and by temperature it would jump to and fro.
    let curve: Vec<(f64, f64)> = axis.points.iter().map(|p| (p.temperature, p.rate - p.corrected)).collect();
    let name = &axis.name;
    let raw = vec![Mark::Dots(Ink::Raw, over_time(|p| p.rate))];
    let time_raw = over_time_panel(format!("{name}: rate against time"), &raw_name, raw);
    let left = vec![Mark::Dots(Ink::Corrected, over_time(|p| p.corrected)), Mark::Level(Ink::Aim, 0.0)];
    let time_left = over_time_panel(format!("{name}: corrected rate against time"), &left_name, left);
    let both = |of: fn(&LogPoint) -> f64| {
        vec![Mark::Dots(Ink::Heating, going(true, of)), Mark::Dots(Ink::Cooling, going(false, of))]
    };
    let mut raw = both(|p| p.rate);
    raw.push(Mark::Line(Ink::Curve, curve));
    raw.extend(band(axis).into_iter().map(|edge| Mark::Line(Ink::Aim, edge)));
    let title = format!("{name}: rate against temperature, with the curve");
    let warm_raw = Panel::new(title, &temperature_name, &raw_name, raw);
    let mut left = both(|p| p.corrected);
    left.push(Mark::Level(Ink::Aim, 0.0));
    let title = format!("{name}: corrected rate against temperature");
    let warm_left = Panel::new(title, &temperature_name, &left_name, left);
    let short = |panel| Panel { height: Panel::SHORT, ..panel };
    let mut key =
        vec![(Ink::Raw, Sample::Dot, "recorded".to_owned()), (Ink::Corrected, Sample::Dot, "corrected".to_owned())];
    for (up, ink, name) in [(true, Ink::Heating, "heating"), (false, Ink::Cooling, "cooling")] {
        if warming.contains(&up) {
            key.push((ink, Sample::Dot, name.to_owned()));
        }
    }
    key.push((Ink::Curve, Sample::Line, "fitted curve".to_owned()));
    if !axis.band.is_empty() {
        key.push((Ink::Aim, Sample::Line, "where 95 of 100 averages are expected".to_owned()));
    }
    if !report.left_out.is_empty() && time.unit_s.is_some() {
        key.push((Ink::Excluded, Sample::Patch, "left out".to_owned()));
    }
    Figure {
        id: format!("axis-{}", place + 1),
        name: format!("Figure {}", place + 1),
        caption: html! {
            (axis.name) ", " (axis.model) ": the rate against time and against temperature; below, less the fitted curve "
            "(in-sample, " (significant(axis.in_sample.rms, 3)) " " (axis.rate_unit) " rms)."
        },
        key,
        columns: vec![vec![time_raw, short(time_left)], vec![warm_raw, short(warm_left)]],
    }
}
