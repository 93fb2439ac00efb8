//! Ordinary least squares on every row with a temperature and a rate.

use zerorate_core::drift::{Scale, ValidRange};
use zerorate_fit::choose::{Choice, FoldFits, FoldResiduals};
use zerorate_fit::drift_fit::{DriftFit, ResidualOver};
use zerorate_fit::offer::AxisSurvey;

use super::gather::is_accelerometer;
use super::{AxisFit, AxisVerdict, FitOptions, LogFit, LogFitError, admit, one_way, words};
use crate::calibration::AxisCalibration;
use crate::condition::{DropReason, Tally};
use crate::log::{LogError, LogFile, Rows, Sink, Stream};
use crate::quality::{Judgement, Reason, ReasonKind};
use crate::source::Source;
use zerorate_fit::trace::{Trace, TracePoint};

/// Fits every axis: a pass to see what there is, one for the fits, one for the residuals.
pub(super) fn fit(source: &Source, options: &FitOptions, fit: &mut LogFit) -> Result<(), LogFitError> {
    let file = LogFile::open(source, &options.columns)?;
    fit.autopilot = file.autopilot();
    let mut axes = survey(&file, options, fit)?;
    for axis in &mut axes {
        let span = (axis.survey.min, axis.survey.max);
        axis.admitted = admit(&mut axis.judgement, options, &axis.stream, axis.place, axis.survey.rows, span);
        axis.fits = axis.admitted.map(|(scale, _)| FoldFits::new(scale, options.model, axis.all_rows));
    }
    pass(&file, options, &mut |rows| {
        for axis in axes.iter_mut().filter(|axis| axis.number == rows.sensor) {
            if let Some(fits) = &mut axis.fits {
                fits.push_rows(rows.first_row, rows.temperature, &rows.values[axis.place]);
            }
        }
    })?;
    let choices: Vec<Option<Choice>> = axes.iter_mut().map(|axis| axis.choose(options)).collect();
    let mut second: Vec<Option<(FoldResiduals<'_>, Trace)>> = (axes.iter().zip(&choices))
        .map(|(axis, choice)| Some((FoldResiduals::new(choice.as_ref()?, axis.all_rows), Trace::new(axis.all_rows))))
        .collect();
    pass(&file, options, &mut |rows| {
        for (axis, second) in axes.iter().zip(&mut second).filter(|(axis, _)| axis.number == rows.sensor) {
            if let Some((residuals, trace)) = second {
                judge(residuals, trace, rows, &rows.values[axis.place]);
            }
        }
    })?;
    for ((mut axis, choice), second) in axes.into_iter().zip(&choices).zip(second) {
        if let (Some(choice), Some((residuals, trace)), Some((_, valid))) = (choice, second, axis.admitted) {
            let fitted = choice.finish(valid, ResidualOver::Rows, residuals.statistics());
            fit.axes.push(axis.finish(fitted, valid, trace));
        }
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
    fits: Option<FoldFits>,
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
        let found = surveys.iter().position(|(number, ..)| *number == rows.sensor);
        let place = found.unwrap_or_else(|| {
            surveys.push((rows.sensor, vec![AxisSurvey::EMPTY; rows.values.len()], 0));
            surveys.len() - 1
        });
        let (_, axes, count) = &mut surveys[place];
        *count += rows.temperature.len() as u64;
        axes.iter_mut().zip(rows.values).for_each(|(axis, values)| axis.take(rows.temperature, values));
    };
    let mut pass = Pass { options, streams: Vec::new(), take: &mut take };
    let ending = file.read(&mut pass)?;
    let streams = pass.streams;
    fit.sources[0].started = ending.started;
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
            fits: None,
        })
    });
    Ok(axes.collect())
}

impl Axis {
    fn name(&self) -> &str {
        &self.stream.names[self.place]
    }

    /// Chooses the model; one that the rows do not settle rejects the axis.
    fn choose(&mut self, options: &FitOptions) -> Option<Choice> {
        match self.fits.as_ref()?.choose(options.model) {
            Ok(choice) => Some(choice),
            Err(error) => {
                let text = format!("{}: {error}", self.name());
                self.judgement.add(Reason::new(ReasonKind::TooFewGroups, text));
                None
            }
        }
    }

    fn finish(&mut self, fitted: DriftFit, valid: ValidRange, trace: Trace) -> AxisFit {
        let AxisSurvey { missing_temperature, missing_rate, .. } = self.survey;
        let name = self.name().to_owned();
        let missing = [(DropReason::MissingTemperature, missing_temperature), (DropReason::MissingRate, missing_rate)];
        for (reason, count) in missing {
            words::of_dropped(&mut self.judgement, &self.stream, self.place, reason, count, self.all_rows);
        }
        let trace = trace.finish();
        let temperatures = vec![trace.iter().map(|point| (point.temperature, point.rate.is_finite())).collect()];
        one_way::reason(&temperatures).into_iter().for_each(|reason| self.judgement.add(reason));
        let mut tally = Tally::default();
        missing.into_iter().for_each(|(reason, count)| tally.add(reason, count));
        let mut calibration = AxisCalibration::of_fit(fitted, self.stream.unit);
        calibration.sensor = self.stream.sensor;
        calibration.reference_temperature =
            is_accelerometer(&self.stream).then_some(f64::midpoint(valid.min(), valid.max()));
        AxisFit {
            name,
            verdict: self.judgement.verdict,
            temperature_unit: self.stream.temperature_unit,
            calibration,
            samples_rejected: tally.rejected(),
            trace,
        }
    }
}

/// Takes a batch's numeric rows into the residuals.
fn judge(residuals: &mut FoldResiduals<'_>, trace: &mut Trace, rows: &Rows<'_>, rates: &[f64]) {
    for (place, (&temperature, &rate)) in rows.temperature.iter().zip(rates).enumerate() {
        if temperature.is_finite() && rate.is_finite() {
            let row = rows.first_row + place as u64;
            let residual = residuals.push(row, temperature, rate);
            trace
                .push(row, &TracePoint { log: 0, time_s: rows.time_s[place], temperature, rows: None, rate, residual });
        }
    }
}
