//! The fit of conditioned groups.

use super::residual::Residuals;
use super::survey::{times, wanted};
use super::{AxisFit, FitOptions, Log, LogFit, LogFitError, admit, choose};
use crate::choose::Stretches;
use crate::condition::{DropReason, Group, Grouping, Levels, Tally, group_rows, level};
use crate::quality::{Judgement, Reason, ReasonKind};

/// Fits every axis: one pass for the groups, the rest on them.
pub(super) fn fit(log: &Log, options: &FitOptions, fit: &mut LogFit) -> Result<(), LogFitError> {
    let (mut groups, mut tallies) = gather(log)?;
    let levels = level(&mut groups, &mut tallies, log.columns.temperature_unit);
    report(&mut fit.judgement, log, &tallies, &levels);
    fit.stretches = levels.stretches;
    fit.steps = levels.steps;
    for (axis, tally) in tallies.iter().enumerate() {
        fit.axes.extend(fit_axis(log, options, &groups, axis, tally, &mut fit.judgement));
    }
    Ok(())
}

fn gather(log: &Log) -> Result<(Vec<Group>, Vec<Tally>), LogFitError> {
    let rows = group_rows(log.survey.rows, log.survey.step_s());
    let mut grouping = Grouping::new(log.columns.rates.len(), rows, log.columns.temperature_unit);
    for batch in log.table.batches(&wanted(&log.columns))? {
        let batch = batch?;
        let times = times(&batch, &log.columns);
        let rates = &batch.columns[1..=log.columns.rates.len()];
        for (row, &temperature) in batch.columns[0].iter().enumerate() {
            let time_s = times.get(row).map_or(f64::NAN, |time| log.survey.seconds(*time));
            grouping.push(time_s, temperature, rates.iter().map(|column| column[row]));
        }
    }
    Ok(grouping.finish())
}

fn fit_axis(
    log: &Log,
    options: &FitOptions,
    groups: &[Group],
    axis: usize,
    tally: &Tally,
    judgement: &mut Judgement,
) -> Option<AxisFit> {
    let name = &log.columns.rate_names[axis];
    let used = || (0_u64..).zip(groups).filter(|(_, group)| group.axes[axis].rows > 0 && group.temperature.is_finite());
    let span = used().fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), (_, group)| {
        (min.min(group.temperature), max.max(group.temperature))
    });
    let (scale, valid) = admit(judgement, options, log, axis, used().count() as u64, span)?;
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
        rate_unit: log.columns.rate_unit,
        temperature_unit: log.columns.temperature_unit,
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
        samples_rejected: tally.rejected(),
        trace,
    })
}

/// Puts what conditioning found into the judgement.
fn report(judgement: &mut Judgement, log: &Log, tallies: &[Tally], levels: &Levels) {
    let unit = log.columns.temperature_unit.name();
    for (tally, name) in tallies.iter().zip(&log.columns.rate_names) {
        let missing = tally.count(DropReason::MissingTemperature) + tally.count(DropReason::MissingRate);
        let what = "no number for temperature or rate";
        judgement.dropped(ReasonKind::MissingValues, name, what, missing, log.survey.rows);
        let spikes = tally.count(DropReason::Spike) + tally.count(DropReason::TemperatureSpike);
        let what = "far from their neighbours; look for a loose connection or a disturbed bench";
        judgement.dropped(ReasonKind::Spikes, name, what, spikes, log.survey.rows);
    }
    for stretch in levels.stretches.iter().filter(|stretch| stretch.reason == DropReason::Rotation) {
        let text = format!(
            "the unit was moved from {:.0} s to {:.0} s (rows {} to {}, {:.1} to {:.1} {unit}): these rows were left out",
            stretch.time_s.0,
            stretch.time_s.1,
            stretch.rows.0 + 1,
            stretch.rows.1,
            stretch.temperature.0,
            stretch.temperature.1
        );
        judgement.add(Reason::new(ReasonKind::Rotation, text));
    }
    for step in &levels.steps {
        let text = format!(
            "{}: the rate steps by {:.3e} {} at {:.0} s (row {}, {:.1} {unit}) and stays, with no temperature change to match: the step was taken out, and the curve holds for the level before it",
            log.columns.rate_names[step.axis],
            step.size,
            log.columns.rate_unit,
            step.time_s,
            step.row + 1,
            step.temperature
        );
        judgement.add(Reason::new(ReasonKind::Step, text));
    }
}
