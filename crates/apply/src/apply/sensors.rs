//! An autopilot's log, corrected: the rows of its sensors in one table, each with the bias by the calibration beside it.

use std::io::{self, Write};

use thiserror::Error;
use zerorate_core::drift::ValidRange;
use zerorate_fit::drift_fit::DriftFit;
use zerorate_fit::predict::{DriftModel, Predictor, Start};

use super::{Applied, ApplyError, RowTold, cell, in_common};
use zerorate_cal::calibration::Calibration;
use zerorate_cal::log::{LogFile, Rows, SensorChoice, Sink, Stream};
use zerorate_cal::matching::{Known, Unmatched, calibrated, places, renamed};
use zerorate_cal::source::Source;
use zerorate_cal::table::Columns;
use zerorate_cal::units::{RateUnit, TemperatureUnit};

/// The columns of what is written. Rates and predictions are in `rate_unit`; a sensor's axis that was not calibrated has
/// neither prediction nor corrected rate.
pub const COLUMNS: [&str; 13] = [
    "sensor",
    "rate_unit",
    "time_s",
    "temperature_c",
    "x",
    "y",
    "z",
    "predicted_x",
    "corrected_x",
    "predicted_y",
    "corrected_y",
    "predicted_z",
    "corrected_z",
];

/// What was done.
#[derive(Debug, Clone, PartialEq)]
pub struct AppliedSensors {
    /// Rows, of all sensors written.
    pub applied: Applied,
    /// The axes corrected, by their names in the log.
    pub corrected: Vec<String>,
    /// The least and the greatest temperature over which all of their curves hold, degrees C.
    pub calibrated_temperature: [f64; 2],
    /// The same of what all of them were fitted to.
    pub measured_temperature: [f64; 2],
    /// The sensors of the log that the calibration is not for: their rows were not written.
    pub passed_over: Vec<String>,
    /// Those that were not asked for, whether the calibration has them or not.
    pub not_asked_for: Vec<String>,
    /// What was guessed or is wrong with the file, a sentence each.
    pub notes: Vec<String>,
}

/// Why a calibration cannot be applied to a log's sensors.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SensorFault {
    /// Its axes are not the calibration's.
    #[error(transparent)]
    Unmatched(#[from] Unmatched),
    /// Units that cannot be converted.
    #[error("{axis} is in {found}, and the calibration in {expected}: fit a log of this kind")]
    Unit {
        /// The log's axis.
        axis: String,
        /// Its unit.
        found: String,
        /// The calibration's.
        expected: String,
    },
}

/// Writes the rows of an autopilot's log as comma-separated text under [`COLUMNS`], in the order in which the log has them
/// (each sensor's in the order of time). A history begins with each sensor's first row, and anew where the log does.
///
/// # Errors
/// When the log cannot be read or is no autopilot's, no axis of it is the calibration's, or the output cannot be written.
pub fn apply_to_sensors(
    log: &Source,
    calibration: &Calibration,
    sensor: Option<SensorChoice>,
    start: Start,
    output: impl Write,
) -> Result<AppliedSensors, ApplyError> {
    let file = LogFile::open(log, &Columns::default())?;
    let mut met = Met::default();
    file.read(&mut met)?;
    let axes: Vec<(usize, usize)> = met
        .0
        .iter()
        .enumerate()
        .flat_map(|(sensor, stream)| (0..stream.names.len()).map(move |at| (sensor, at)))
        .collect();
    let logged: Vec<Known<'_>> = axes.iter().map(|(sensor, at)| known(&met.0[*sensor], *at)).collect();
    let choice = sensor;
    let own = calibrated(calibration, choice);
    let faulty = |fault: SensorFault| ApplyError::from(log.faulty::<SensorFault>(fault));
    let places = places(&own, &logged).map_err(|error| faulty(error.into()))?;
    let placed = || own.iter().zip(&places).filter_map(|(own, place)| Some((own, (*place)?)));
    let fits = || placed().map(|(own, _)| &calibration.axes[own.name].fit);
    let mut done = AppliedSensors {
        applied: Applied::default(),
        corrected: Vec::new(),
        calibrated_temperature: in_common(fits().map(|fit| fit.model.drift.valid)),
        measured_temperature: in_common(fits().map(|fit| fit.measured)),
        passed_over: Vec::new(),
        not_asked_for: Vec::new(),
        notes: Vec::new(),
    };
    let mut sensors: Vec<Corrected<'_>> = met.0.iter().map(Corrected::none).collect();
    for (own, place) in placed() {
        let unit = |found: &str, expected: &str| SensorFault::Unit {
            axis: logged[place].name.to_owned(),
            found: found.to_owned(),
            expected: expected.to_owned(),
        };
        let (from, to) = (own.unit, logged[place].unit);
        let factor = from.in_unit(to).ok_or_else(|| faulty(unit(&to.to_string(), &from.to_string())))?;
        if calibration.temperature_unit != TemperatureUnit::C {
            return Err(faulty(unit("C", calibration.temperature_unit.name())));
        }
        let (sensor, at) = axes[place];
        sensors[sensor].axes[at] = Some(Axis::new(&calibration.axes[own.name].fit, start, factor));
        done.corrected.push(logged[place].name.to_owned());
        done.notes.extend(renamed(logged[place].name, own.name));
    }
    for (sensor, stream) in sensors.iter().zip(&met.0).filter(|(sensor, _)| !sensor.is_wanted()) {
        let asked_for = choice.zip(stream.sensor).is_none_or(|(choice, sensor)| choice.takes(&sensor));
        let those = if asked_for { &mut done.passed_over } else { &mut done.not_asked_for };
        those.push(sensor.name.clone());
    }
    let mut writing = Writing {
        writer: csv::Writer::from_writer(output),
        sensors,
        met: 0,
        applied: Applied::default(),
        failed: None,
    };
    writing.writer.write_record(COLUMNS).map_err(io::Error::from)?;
    let ending = file.read(&mut writing)?;
    done.notes.extend(ending.notes);
    done.notes.extend(ending.reasons.into_iter().map(|reason| reason.text));
    if let Some(error) = writing.failed {
        return Err(error.into());
    }
    writing.writer.flush()?;
    done.applied = writing.applied;
    Ok(done)
}

/// An axis of a log that was not fitted.
fn known(stream: &Stream, axis: usize) -> Known<'_> {
    Known { name: &stream.names[axis], sensor: stream.sensor, unit: stream.unit }
}

/// The sensors met, without their rows.
#[derive(Default)]
struct Met(Vec<Stream>);

impl Sink for Met {
    fn stream(&mut self, stream: &Stream) -> bool {
        self.0.push(stream.clone());
        false
    }

    fn rows(&mut self, _: &Rows<'_>) {}
}

/// One sensor and what is applied to its axes.
struct Corrected<'a> {
    name: String,
    unit: RateUnit,
    part: u32,
    axes: [Option<Axis<'a>>; 3],
}

struct Axis<'a> {
    model: &'a DriftModel,
    measured: ValidRange,
    start: Start,
    predictor: Predictor<'a>,
    /// The log's units in one of the calibration's.
    factor: f64,
}

impl<'a> Axis<'a> {
    fn new(fit: &'a DriftFit, start: Start, factor: f64) -> Self {
        let DriftFit { model, measured, .. } = fit;
        Self { model, measured: *measured, start, predictor: Predictor::new(model, start), factor }
    }
}

impl Corrected<'_> {
    fn none(stream: &Stream) -> Self {
        let name = stream.sensor.map_or_else(|| stream.names.join(", "), |sensor| sensor.to_string());
        Self { name, unit: stream.unit, part: 0, axes: [None, None, None] }
    }

    fn is_wanted(&self) -> bool {
        self.axes.iter().any(Option::is_some)
    }

    /// A history does not go on where the log begins anew.
    fn begin(&mut self, part: u32) {
        if part != self.part {
            self.part = part;
            self.axes.iter_mut().flatten().for_each(|axis| axis.predictor = Predictor::new(axis.model, axis.start));
        }
    }
}

/// The rows on their way to the output.
struct Writing<'a, W: Write> {
    writer: csv::Writer<W>,
    sensors: Vec<Corrected<'a>>,
    met: usize,
    applied: Applied,
    /// Why the output cannot be written: nothing more is.
    failed: Option<io::Error>,
}

impl<W: Write> Sink for Writing<'_, W> {
    fn stream(&mut self, _: &Stream) -> bool {
        self.met += 1;
        self.sensors[self.met - 1].is_wanted()
    }

    fn rows(&mut self, rows: &Rows<'_>) {
        if self.failed.is_none() {
            self.failed = self.write(rows).err();
        }
    }
}

impl<W: Write> Writing<'_, W> {
    fn write(&mut self, rows: &Rows<'_>) -> io::Result<()> {
        let sensor = &mut self.sensors[rows.sensor];
        sensor.begin(rows.part);
        for (row, (&time_s, &temperature)) in rows.time_s.iter().zip(rows.temperature).enumerate() {
            let mut cells = vec![sensor.name.clone(), sensor.unit.to_string(), cell(time_s), cell(temperature)];
            cells.extend(rows.values.iter().map(|values| cell(values[row])));
            // Of a row that no model is for, the temperature is told all the same.
            let mut told = RowTold { without_temperature: temperature.is_nan(), ..RowTold::default() };
            for (axis, values) in sensor.axes.iter_mut().zip(rows.values) {
                let bias = axis.as_mut().map_or(f64::NAN, |axis| {
                    let predicted = axis.predictor.predict(time_s, temperature);
                    told.take(temperature, axis.measured, &predicted);
                    axis.factor * predicted.bias
                });
                cells.extend([bias, values[row] - bias].map(cell));
            }
            self.writer.write_record(&cells)?;
            self.applied.count(told);
        }
        Ok(())
    }
}
