//! Ordinary least squares on every row with a temperature and a rate.

use zerorate_core::drift::Drift;

use super::residual::Residuals;
use super::survey::{times, wanted};
use super::{AxisFit, FitOptions, Log, LogFit, LogFitError, admit, choose};
use crate::choose::{Choice, Stretches};
use crate::condition::{DropReason, Tally};
use crate::quality::ReasonKind;
use crate::table::Batch;

/// Fits every axis: one pass for the fits, one for the residuals.
pub(super) fn fit(log: &Log, options: &FitOptions, fit: &mut LogFit) -> Result<(), LogFitError> {
    let mut admitted = Vec::new();
    for (axis, survey) in log.survey.axes.iter().enumerate() {
        let span = (survey.min, survey.max);
        admitted.extend(admit(&mut fit.judgement, options, log, axis, survey.rows, span));
    }
    if fit.judgement.rejected() {
        return Ok(());
    }
    let mut stretches: Vec<Stretches> =
        admitted.iter().map(|(scale, _)| Stretches::new(*scale, options.model, log.survey.rows)).collect();
    for batch in log.table.batches(&wanted(&log.columns))? {
        let batch = batch?;
        for (stretches, rates) in stretches.iter_mut().zip(&batch.columns[1..]) {
            push(stretches, &batch, rates);
        }
    }
    let mut chosen = Vec::new();
    for ((stretches, (_, valid)), name) in stretches.iter().zip(&admitted).zip(&log.columns.rate_names) {
        chosen.extend(choose(&mut fit.judgement, options, name, stretches, *valid));
    }
    if fit.judgement.rejected() {
        return Ok(());
    }
    fit.axes = finish(log, &stretches, chosen)?;
    for (axis, survey) in fit.axes.iter().zip(&log.survey.axes) {
        let missing = survey.missing_temperature + survey.missing_rate;
        let what = "no number for temperature or rate";
        fit.judgement.dropped(ReasonKind::MissingValues, &axis.name, what, missing, log.survey.rows);
    }
    Ok(())
}

/// Pushes a batch's numeric rows to the fits of their stretches.
fn push(stretches: &mut Stretches, batch: &Batch, rates: &[f64]) {
    let temperatures = &batch.columns[0];
    let mut start = 0;
    while start < temperatures.len() {
        let (stretch, end) = stretches.of_row(batch.first_row + start as u64);
        let end = usize::try_from(end - batch.first_row).unwrap_or(usize::MAX).min(temperatures.len());
        let (temperatures, rates) = (&temperatures[start..end], &rates[start..end]);
        let numeric = |(t, r): &(&f64, &f64)| t.is_finite() && r.is_finite();
        let fit = stretches.fit(stretch);
        if temperatures.iter().zip(rates).all(|row| numeric(&row)) {
            fit.push_rows(temperatures, &[rates]);
        } else {
            let (temperatures, rates): (Vec<f64>, Vec<f64>) = temperatures.iter().zip(rates).filter(numeric).unzip();
            fit.push_rows(&temperatures, &[&rates]);
        }
        start = end;
    }
}

/// The pass for the residuals.
fn finish(log: &Log, stretches: &[Stretches], chosen: Vec<(Choice, Drift)>) -> Result<Vec<AxisFit>, LogFitError> {
    let mut residuals: Vec<Residuals<'_>> =
        chosen.iter().map(|(choice, drift)| Residuals::new(choice, drift, log.survey.rows)).collect();
    for batch in log.table.batches(&wanted(&log.columns))? {
        let batch = batch?;
        let times = times(&batch, &log.columns);
        for ((residuals, stretches), rates) in residuals.iter_mut().zip(stretches).zip(&batch.columns[1..]) {
            for (place, (&temperature, &rate)) in batch.columns[0].iter().zip(rates).enumerate() {
                if temperature.is_finite() && rate.is_finite() {
                    let row = batch.first_row + place as u64;
                    let time_s = times.get(place).map_or(f64::NAN, |time| log.survey.seconds(*time));
                    residuals.push(row, stretches.of_row(row).0, time_s, temperature, rate);
                }
            }
        }
    }
    let spreads: Vec<_> = residuals.into_iter().map(Residuals::finish).collect();
    let axes = chosen.into_iter().zip(spreads).zip(&log.survey.axes).zip(&log.columns.rate_names);
    Ok(axes
        .map(|((((choice, drift), (in_sample, held_out, trace)), survey), name)| {
            let mut tally = Tally::default();
            tally.add(DropReason::MissingTemperature, survey.missing_temperature);
            tally.add(DropReason::MissingRate, survey.missing_rate);
            AxisFit {
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
                samples_used: survey.rows,
                samples_rejected: tally.rejected(),
                trace,
            }
        })
        .collect())
}
