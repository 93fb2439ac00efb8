//! The fit of conditioned groups.

use std::path::Path;

use super::gather::{Gathered, gather, is_accelerometer};
use super::residual::Residuals;
use super::{AxisFit, AxisVerdict, FitOptions, FoundStep, LogFit, LogFitError, admit, choose, words};
use crate::choose::Stretches;
use crate::condition::{Levels, level};
use crate::quality::{Judgement, Reason, ReasonKind};

/// Fits every axis of every sensor: one pass for the groups, the rest on them.
pub(super) fn fit(paths: &[&Path], options: &FitOptions, fit: &mut LogFit) -> Result<(), LogFitError> {
    let mut logs = gather(paths, options)?;
    fit.notes = std::mem::take(&mut logs.notes);
    fit.autopilot = logs.autopilot;
    logs.reasons.drain(..).for_each(|reason| fit.judgement.add(reason));
    if logs.sensors.is_empty() {
        let seen: Vec<String> = logs.seen.iter().map(ToString::to_string).collect();
        fit.judgement.add(Reason::new(ReasonKind::NoSensor, words::no_sensor(&seen)));
    }
    for sensor in &mut logs.sensors {
        let levels = level(&mut sensor.groups, &mut sensor.tallies, sensor.stream.temperature_unit);
        fit_sensor(sensor, &levels, options, fit);
        fit.stretches.extend(levels.stretches);
    }
    Ok(())
}

fn fit_sensor(sensor: &Gathered, levels: &Levels, options: &FitOptions, fit: &mut LogFit) {
    for (axis, name) in sensor.stream.names.iter().enumerate() {
        let mut judgement = Judgement::default();
        words::report(&mut judgement, sensor, axis, levels);
        fit.axes.extend(fit_axis(sensor, options, axis, &mut judgement));
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
    let used = || (0_u64..).zip(groups).filter(|(_, group)| group.axes[axis].rows > 0 && group.temperature.is_finite());
    let span = used().fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), (_, group)| {
        (min.min(group.temperature), max.max(group.temperature))
    });
    let (scale, valid) = admit(judgement, options, stream, axis, used().count() as u64, span)?;
    let rows = groups.len() as u64;
    let mut stretches = Stretches::new(scale, options.model, rows);
    for (row, group) in used() {
        let (stretch, _) = stretches.of_row(row);
        stretches.fit(stretch).push(group.temperature, &[group.axes[axis].rate]);
    }
    let (choice, drift) = choose(judgement, options, name, &stretches, valid)?;
    let mut residuals = Residuals::new(&choice, &drift, rows);
    for (row, group) in used() {
        let (stretch, _) = stretches.of_row(row);
        residuals.push(row, stretch, group.time_s, group.temperature, group.axes[axis].rate);
    }
    let (in_sample, held_out, trace) = residuals.finish();
    Some(AxisFit {
        name: name.clone(),
        sensor: stream.sensor,
        verdict: judgement.verdict,
        rate_unit: stream.unit,
        temperature_unit: stream.temperature_unit,
        reference_temperature: is_accelerometer(stream).then_some(f64::midpoint(valid.min(), valid.max())),
        drift,
        history: None,
        time_drift: None,
        static_cubic: None,
        band: Vec::new(),
        nested: None,
        choice,
        in_sample,
        held_out,
        samples_used: used().map(|(_, group)| u64::from(group.axes[axis].rows)).sum(),
        samples_rejected: sensor.tallies[axis].rejected(),
        trace,
    })
}
