//! The fit of conditioned groups.

use zerorate_core::drift::Scale;
use zerorate_fit::auto;
use zerorate_fit::intervals::ends;
use zerorate_fit::least_squares::{Basis, Fit};
use zerorate_fit::series::{NextRun, Series};
use zerorate_fit::side_by_side::side_by_side;

use super::gather::{Gathered, gather, is_accelerometer};
use super::{AxisFit, AxisVerdict, FitOptions, FoundStep, LogFit, LogFitError, admit, apart, one_way, words};
use crate::calibration::AxisCalibration;
use crate::condition::{
    DropReason, Excluded, Group, Levels, dequantise, extend_to_the_start, leave_out_stopped, leave_out_times,
    leave_out_untrue_temperatures, level, weigh,
};
use crate::quality::{Judgement, Reason, ReasonKind};
use crate::source::Source;
use crate::units::RateUnit;
use zerorate_fit::trace::{self, TracePoint};

/// The order of the polynomial that tells what an accelerometer shows at its reference temperature.
const REFERENCE_ORDER: usize = 3;

/// A rate further than this from the log's median is a rotation: 17 degrees a second, thirty times the drift of the worst
/// of the shared field-fitted units.
const ROTATION_THRESHOLD_RAD_PER_S: f64 = 0.3;

/// Fits every axis of every sensor: one pass for the groups, the rest on them.
pub(super) fn fit(sources: &[Source], options: &FitOptions, fit: &mut LogFit) -> Result<(), LogFitError> {
    let mut logs = gather(sources, options)?;
    fit.notes = std::mem::take(&mut logs.notes);
    fit.autopilot = logs.autopilot;
    for ((source, started), rows) in fit.sources.iter_mut().zip(&logs.started).zip(std::mem::take(&mut logs.rows)) {
        (source.started, source.rows) = (*started, rows);
    }
    logs.reasons.drain(..).for_each(|reason| fit.judgement.add(reason));
    if logs.sensors.is_empty() {
        let seen: Vec<String> = logs.seen.iter().map(ToString::to_string).collect();
        fit.judgement.add(Reason::new(ReasonKind::NoSensor, words::no_sensor(&seen, fit.autopilot.is_some())));
    }
    let mut levels: Vec<Levels> = logs.sensors.iter_mut().map(condition).collect();
    leave_out_together(&mut logs.sensors, &mut levels);
    for (sensor, levels) in logs.sensors.iter_mut().zip(levels) {
        if options.keep_steps {
            levels.put_back(&mut sensor.groups);
        }
        if is_accelerometer(&sensor.stream) {
            (0..sensor.stream.names.len()).for_each(|axis| take_from_reference(&mut sensor.groups, axis));
        }
        (0..sensor.stream.names.len()).for_each(|axis| weigh(&mut sensor.groups, axis));
        fit_sensor(sensor, &levels, options, fit);
        for interval in levels.excluded {
            // Sensors of one unit are moved, and stop, together.
            let same = |known: &Excluded| known.reason == interval.reason && overlap(known.time_s, interval.time_s);
            match fit.excluded.iter_mut().find(|known| same(known)) {
                Some(known) => known.widen(&interval),
                None => fit.excluded.push(interval),
            }
        }
    }
    fit.excluded.sort_by(|a, b| a.time_s.0.total_cmp(&b.time_s.0));
    Ok(())
}

/// Finds what is no drift in a sensor's groups.
fn condition(sensor: &mut Gathered) -> Levels {
    for axis in 0..sensor.still.len() {
        if words::coarse_step(sensor, axis).is_some() {
            sensor.still[axis] = None;
        }
    }
    for (axis, _) in sensor.still.iter().enumerate().filter(|(_, still)| still.is_some()) {
        // It is no measure of how the others move.
        sensor.groups.iter_mut().for_each(|group| group.axes[axis].rows = 0);
    }
    let mut stopped = Vec::new();
    for (axis, (tally, step)) in sensor.tallies.iter_mut().zip(&sensor.rate_steps).enumerate() {
        stopped.extend(leave_out_stopped(&mut sensor.groups, tally, axis, *step));
    }
    let (unit, step) = (sensor.stream.temperature_unit, sensor.temperature_step);
    let untrue = leave_out_untrue_temperatures(&mut sensor.groups, &mut sensor.tallies, unit, step);
    if words::is_coarse(sensor) {
        dequantise(&mut sensor.groups, sensor.temperature_step);
    }
    let rotation_threshold = ROTATION_THRESHOLD_RAD_PER_S
        * match sensor.stream.unit {
            RateUnit::RadPerS => 1.0,
            RateUnit::Dps => 1.0_f64.to_degrees(),
            RateUnit::Counts | RateUnit::MetresPerS2 => f64::INFINITY,
        };
    let mut levels = level(&mut sensor.groups, &mut sensor.tallies, unit, rotation_threshold, &sensor.rate_steps);
    levels.stopped = stopped;
    levels.excluded.extend(untrue);
    levels.excluded.sort_by_key(|interval| interval.rows);
    extend_to_the_start(&mut sensor.groups);
    levels
}

/// A unit is moved as a whole: what one sensor saw of it, the others leave out too.
fn leave_out_together(sensors: &mut [Gathered], levels: &mut [Levels]) {
    let times = |levels: &Levels| -> Vec<(f64, f64)> {
        let moved = levels.excluded.iter().filter(|interval| interval.reason == DropReason::Rotation);
        moved.map(|interval| interval.time_s).filter(|(from, to)| from.is_finite() && to.is_finite()).collect()
    };
    let all: Vec<Vec<(f64, f64)>> = levels.iter().map(times).collect();
    for (place, (sensor, levels)) in sensors.iter_mut().zip(levels).enumerate() {
        let others: Vec<(f64, f64)> =
            all.iter().enumerate().filter(|(other, _)| *other != place).flat_map(|(_, times)| times).copied().collect();
        levels.excluded.extend(leave_out_times(&mut sensor.groups, &mut sensor.tallies, &others));
    }
}

/// Takes what an accelerometer shows at the middle of its temperatures from all its readings: gravity and its constant,
/// which cannot be told apart at rest.
fn take_from_reference(groups: &mut [Group], axis: usize) {
    let used = || groups.iter().filter(|group| group.axes[axis].rows > 0 && group.temperature.is_finite());
    let (min, max) = ends(used().map(|group| group.temperature));
    let Some(scale) = Scale::spanning(min, max) else { return };
    let order = REFERENCE_ORDER.min(used().count().saturating_sub(1));
    let mut fit = Fit::new(scale, Basis::Powers(order));
    used().for_each(|group| fit.push(group.temperature, group.axes[axis].rate));
    // The middle of the range is 0 of the scaled variable, where only the constant is left.
    let Ok(solution) = fit.finish() else { return };
    let constant = solution.coefficients[0];
    groups.iter_mut().for_each(|group| group.axes[axis].rate -= constant);
}

fn overlap(a: (f64, f64), b: (f64, f64)) -> bool {
    a.0 <= b.1 && b.0 <= a.1
}

fn fit_sensor(sensor: &Gathered, levels: &Levels, options: &FitOptions, fit: &mut LogFit) {
    let untrue = words::of_temperature(sensor);
    let fit_axis = |axis: usize| {
        let mut judgement = Judgement::default();
        untrue.iter().for_each(|reason| judgement.add(reason.clone()));
        words::report(&mut judgement, sensor, axis, levels, options);
        (fit_axis(sensor, options, axis, &mut judgement), judgement)
    };
    let names = &sensor.stream.names;
    for ((fitted, judgement), name) in side_by_side(names.len(), fit_axis).into_iter().zip(names) {
        fit.axes.extend(fitted);
        fit.verdicts.push(AxisVerdict { name: name.clone(), judgement });
    }
    fit.steps.extend(levels.steps.iter().map(|step| FoundStep {
        axis: sensor.stream.names[step.axis].clone(),
        time_s: step.time_s,
        temperature: step.temperature,
        size: step.size,
    }));
}

fn fit_axis(sensor: &Gathered, options: &FitOptions, axis: usize, judgement: &mut Judgement) -> Option<AxisFit> {
    let (stream, groups) = (&sensor.stream, &sensor.groups);
    let name = &stream.names[axis];
    if let Some(still) = &sensor.still[axis] {
        judgement.add(words::of_still(still, name, sensor));
        return None;
    }
    let used = || (0_u64..).zip(groups).filter(|(_, group)| group.axes[axis].rows > 0 && group.temperature.is_finite());
    let span = ends(used().map(|(_, group)| group.temperature));
    if used().next().is_none()
        && let Some(reason) = words::of_nothing_kept(sensor, axis)
    {
        judgement.add(reason);
        return None;
    }
    let (_, valid) = admit(judgement, options, stream, axis, used().count() as u64, span)?;
    let whole_logs = groups.chunk_by(|a, b| a.log == b.log);
    let passed = |group: &Group| (group.temperature, group.axes[axis].rows > 0);
    let temperatures: Vec<Vec<(f64, bool)>> = whole_logs.map(|log| log.iter().map(passed).collect()).collect();
    let one_way = one_way::reason(&temperatures);
    let apart = apart::reason(&temperatures, stream.temperature_unit.name());
    let hole = words::of_hole(used().map(|(_, group)| group.temperature), stream.temperature_unit.name());
    one_way.into_iter().chain(apart).chain(hole).for_each(|reason| judgement.add(reason));
    let columns = Columns::of(groups, axis);
    let fitted = match auto::fit(&columns.series(), valid, options.model) {
        Ok(fitted) => fitted,
        Err(error) => {
            judgement.add(Reason::new(ReasonKind::TooFewGroups, format!("{name}: {error}")));
            return None;
        }
    };
    let point = |(group, residual): (&Group, &f64)| TracePoint {
        log: group.log,
        time_s: group.time_s,
        temperature: group.temperature,
        rows: Some((group.first_row, group.end_row)),
        rate: group.axes[axis].rate,
        residual: *residual,
    };
    let mut calibration = AxisCalibration::of_fit(fitted.fit, stream.unit);
    let no_gain =
        calibration.no_gain(name, options.told_in).map(|text| Reason::new(ReasonKind::WorseThanUncorrected, text));
    no_gain.into_iter().for_each(|reason| judgement.add(reason));
    calibration.sensor = stream.sensor;
    calibration.reference_temperature = is_accelerometer(stream).then_some(f64::midpoint(valid.min(), valid.max()));
    calibration.fit.statistics.samples_used = used().map(|(_, group)| u64::from(group.axes[axis].rows)).sum();
    Some(AxisFit {
        name: name.clone(),
        verdict: judgement.verdict,
        temperature_unit: stream.temperature_unit,
        calibration,
        samples_rejected: sensor.tallies[axis].rejected(),
        trace: trace::of_groups(groups.iter().zip(&fitted.residuals).map(point)),
    })
}

/// One axis's groups as columns.
struct Columns {
    time_s: Vec<f64>,
    temperature: Vec<f64>,
    shown: Vec<f64>,
    rate: Vec<f64>,
    weight: Vec<f64>,
    log: Vec<u32>,
}

impl Columns {
    /// A group counts by its rows, and less by the root of how crowded its temperature is: what groups at one temperature
    /// have in common (hysteresis, a slow drift) does not average out among them, and their noise does. One at a rare
    /// temperature is known no better than others, and counts no more.
    fn of(groups: &[Group], axis: usize) -> Self {
        let most = groups.iter().map(|group| group.axes[axis].rows).max().unwrap_or(1).max(1);
        let rate = |group: &Group| {
            let part = group.axes[axis];
            if part.rows > 0 && group.temperature.is_finite() { part.rate } else { f64::NAN }
        };
        let weight = |group: &Group| {
            group.axes[axis].weight.min(1.0).sqrt() * f64::from(group.axes[axis].rows) / f64::from(most)
        };
        Self {
            time_s: groups.iter().map(|group| group.time_s).collect(),
            temperature: groups.iter().map(|group| group.temperature).collect(),
            shown: groups.iter().map(Group::shown).collect(),
            rate: groups.iter().map(rate).collect(),
            weight: groups.iter().map(weight).collect(),
            log: groups.iter().map(|group| group.log).collect(),
        }
    }

    fn series(&self) -> Series<'_> {
        Series {
            time_s: &self.time_s,
            temperature: &self.temperature,
            shown: &self.shown,
            rate: &self.rate,
            weight: &self.weight,
            log: &self.log,
            next: NextRun::Another,
        }
    }
}
