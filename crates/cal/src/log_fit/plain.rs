//! Ordinary least squares on every row with a temperature and a rate.

use std::path::Path;

use zerorate_core::drift::{Drift, Scale, ValidRange};

use super::gather::is_accelerometer;
use super::residual::Residuals;
use super::{AxisFit, AxisVerdict, FitOptions, LogFit, LogFitError, Spread, TracePoint, admit, choose};
use crate::choose::{Choice, Stretches};
use crate::condition::{DropReason, Tally};
use crate::log::{AxisSurvey, LogError, LogFile, Rows, Sink, Stream};
use crate::quality::{Judgement, ReasonKind};

/// Fits every axis: a pass to see what there is, one for the fits, one for the residuals.
pub(super) fn fit(path: &Path, options: &FitOptions, fit: &mut LogFit) -> Result<(), LogFitError> {
    let file = LogFile::open(path, &options.columns)?;
    fit.autopilot = file.autopilot();
    let mut axes = survey(&file, options, fit)?;
    for axis in &mut axes {
        let span = (axis.survey.min, axis.survey.max);
        axis.admitted = admit(&mut axis.judgement, options, &axis.stream, axis.place, axis.survey.rows, span);
        axis.stretches = axis.admitted.map(|(scale, _)| Stretches::new(scale, options.model, axis.all_rows));
    }
    pass(&file, options, &mut |rows| {
        for axis in axes.iter_mut().filter(|axis| axis.number == rows.stream) {
            if let Some(stretches) = &mut axis.stretches {
                push(stretches, rows, &rows.values[axis.place]);
            }
        }
    })?;
    let chosen: Vec<Option<(Choice, Drift)>> = axes.iter_mut().map(|axis| axis.choose(options)).collect();
    let mut residuals: Vec<Option<Residuals<'_>>> = axes
        .iter()
        .zip(&chosen)
        .map(|(axis, chosen)| chosen.as_ref().map(|(choice, drift)| Residuals::new(choice, drift, axis.all_rows)))
        .collect();
    pass(&file, options, &mut |rows| {
        for (axis, residuals) in axes.iter().zip(&mut residuals).filter(|(axis, _)| axis.number == rows.stream) {
            if let Some((residuals, stretches)) = residuals.as_mut().zip(axis.stretches.as_ref()) {
                judge(residuals, stretches, rows, &rows.values[axis.place]);
            }
        }
    })?;
    let spreads: Vec<_> = residuals.into_iter().map(|residuals| residuals.map(Residuals::finish)).collect();
    for ((mut axis, chosen), spreads) in axes.into_iter().zip(chosen).zip(spreads) {
        fit.axes.extend(chosen.zip(spreads).map(|(chosen, spreads)| axis.finish(chosen, spreads)));
        fit.verdicts.push(AxisVerdict { name: axis.name().to_owned(), judgement: axis.judgement });
    }
    Ok(())
}

/// One axis on its way to a fit.
struct Axis {
    stream: Stream,
    /// The sensor's number in the log, and the axis's place in it.
    number: usize,
    place: usize,
    survey: AxisSurvey,
    all_rows: u64,
    judgement: Judgement,
    admitted: Option<(Scale, ValidRange)>,
    stretches: Option<Stretches>,
}

/// A pass over the rows of the sensors wanted.
struct Pass<'a> {
    options: &'a FitOptions,
    streams: Vec<Stream>,
    take: &'a mut dyn FnMut(&Rows<'_>),
}

impl Sink for Pass<'_> {
    fn stream(&mut self, stream: &Stream) -> bool {
        self.streams.push(stream.clone());
        self.options.sensor.zip(stream.sensor).is_none_or(|(choice, sensor)| choice.takes(&sensor))
    }

    fn rows(&mut self, rows: &Rows<'_>) {
        (self.take)(rows);
    }
}

fn pass(file: &LogFile, options: &FitOptions, take: &mut dyn FnMut(&Rows<'_>)) -> Result<(), LogError> {
    file.read(&mut Pass { options, streams: Vec::new(), take }).map(drop)
}

/// What every axis has to offer.
fn survey(file: &LogFile, options: &FitOptions, fit: &mut LogFit) -> Result<Vec<Axis>, LogError> {
    let mut surveys: Vec<(usize, Vec<AxisSurvey>, u64)> = Vec::new();
    let mut take = |rows: &Rows<'_>| {
        let found = surveys.iter().position(|(number, ..)| *number == rows.stream);
        let place = found.unwrap_or_else(|| {
            surveys.push((rows.stream, vec![AxisSurvey::EMPTY; rows.values.len()], 0));
            surveys.len() - 1
        });
        let (_, axes, count) = &mut surveys[place];
        *count += rows.temperature.len() as u64;
        axes.iter_mut().zip(rows.values).for_each(|(axis, values)| axis.take(rows.temperature, values));
    };
    let mut pass = Pass { options, streams: Vec::new(), take: &mut take };
    let ending = file.read(&mut pass)?;
    let streams = pass.streams;
    fit.notes = ending.notes;
    ending.reasons.into_iter().for_each(|reason| fit.judgement.add(reason));
    let axes = surveys.into_iter().flat_map(|(number, axes, all_rows)| {
        let stream = streams[number].clone();
        axes.into_iter().enumerate().map(move |(place, survey)| Axis {
            stream: stream.clone(),
            number,
            place,
            survey,
            all_rows,
            judgement: Judgement::default(),
            admitted: None,
            stretches: None,
        })
    });
    Ok(axes.collect())
}

impl Axis {
    fn name(&self) -> &str {
        &self.stream.names[self.place]
    }

    fn choose(&mut self, options: &FitOptions) -> Option<(Choice, Drift)> {
        let (stretches, (_, valid)) = self.stretches.as_ref().zip(self.admitted)?;
        choose(&mut self.judgement, options, &self.stream.names[self.place], stretches, valid)
    }

    fn finish(&mut self, (choice, drift): (Choice, Drift), spreads: (Spread, Spread, Vec<TracePoint>)) -> AxisFit {
        let (in_sample, held_out, trace) = spreads;
        let missing = self.survey.missing_temperature + self.survey.missing_rate;
        let what = "no number for temperature or rate";
        let name = self.name().to_owned();
        self.judgement.dropped(ReasonKind::MissingValues, &name, what, missing, self.all_rows);
        let mut tally = Tally::default();
        tally.add(DropReason::MissingTemperature, self.survey.missing_temperature);
        tally.add(DropReason::MissingRate, self.survey.missing_rate);
        let reference = f64::midpoint(drift.valid.min(), drift.valid.max());
        AxisFit {
            name,
            sensor: self.stream.sensor,
            verdict: self.judgement.verdict,
            rate_unit: self.stream.unit,
            temperature_unit: self.stream.temperature_unit,
            reference_temperature: is_accelerometer(&self.stream).then_some(reference),
            drift,
            history: None,
            time_drift: None,
            static_cubic: None,
            band: Vec::new(),
            nested: None,
            choice,
            in_sample,
            held_out,
            samples_used: self.survey.rows,
            samples_rejected: tally.rejected(),
            trace,
        }
    }
}

/// Pushes a batch's numeric rows to the fits of their stretches.
fn push(stretches: &mut Stretches, rows: &Rows<'_>, rates: &[f64]) {
    let temperatures = rows.temperature;
    let mut start = 0;
    while start < temperatures.len() {
        let (stretch, end) = stretches.of_row(rows.first_row + start as u64);
        let end = usize::try_from(end - rows.first_row).unwrap_or(usize::MAX).min(temperatures.len());
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

/// Takes a batch's numeric rows into the residuals.
fn judge(residuals: &mut Residuals<'_>, stretches: &Stretches, rows: &Rows<'_>, rates: &[f64]) {
    for (place, (&temperature, &rate)) in rows.temperature.iter().zip(rates).enumerate() {
        if temperature.is_finite() && rate.is_finite() {
            let row = rows.first_row + place as u64;
            residuals.push(row, stretches.of_row(row).0, rows.time_s[place], temperature, rate);
        }
    }
}
