//! Which axes of a calibration belong to which sensor.

use std::fmt;

use serde::Serialize;

use super::cubic::{Cubic, Loss};
use super::{ExportError, ExportOptions, Format};
use zerorate_cal::calibration::{AxisCalibration, Calibration};
use zerorate_cal::log::{Sensor, SensorKind};
use zerorate_cal::matching::direction;
use zerorate_cal::units::{RateScale, RateUnit, TemperatureUnit};
use zerorate_fit::folds::TELLING;

/// One sensor with up to three axes, in the autopilots' units: rad/s or m/s^2, degrees C.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExportedSensor {
    /// What it measures: of a gyro rad/s; of an accelerometer m/s^2 from the reference temperature on, for at rest gravity
    /// hides the constant.
    pub kind: SensorKind,
    /// Its place among those of its kind, from 0.
    pub instance: u8,
    /// The autopilot's number for the part.
    pub device_id: Option<u32>,
    /// The temperatures over which all its axes hold.
    pub range: [f64; 2],
    /// X, Y and Z; `None` where the calibration has none of it.
    pub axes: [Option<ExportedAxis>; 3],
    /// The unit in which people are told what it costs: the calibration's, as it tells its own.
    #[serde(skip)]
    pub told: RateScale,
}

/// One axis of a sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExportedAxis {
    /// Its name in the calibration.
    pub name: String,
    /// The model that was chosen, as a fit names it.
    pub model: String,
    /// The cubic.
    pub cubic: Cubic,
    /// What the cubic costs.
    pub loss: Loss,
    /// Whether the model has a history, which no cubic holds.
    #[serde(skip)]
    pub has_history: bool,
    /// The temperatures of the rates that it was fitted to: the log may have seen others.
    #[serde(skip)]
    pub measured: [f64; 2],
}

impl fmt::Display for ExportedSensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            SensorKind::Gyro => write!(f, "gyro {}", self.instance),
            SensorKind::Accelerometer => write!(f, "accelerometer {}", self.instance),
        }
    }
}

impl ExportedSensor {
    /// The unit of its cubics.
    #[must_use]
    pub fn unit(&self) -> RateUnit {
        match self.kind {
            SensorKind::Gyro => RateUnit::RadPerS,
            SensorKind::Accelerometer => RateUnit::MetresPerS2,
        }
    }
}

/// The sensors of a calibration, gyros first, by their places.
pub(super) fn sensors(
    calibration: &Calibration,
    options: &ExportOptions,
    format: Format,
) -> Result<Vec<ExportedSensor>, ExportError> {
    if calibration.temperature_unit == TemperatureUnit::Counts {
        return Err(ExportError::NotInDegrees { format });
    }
    let mut sensors: Vec<ExportedSensor> = Vec::new();
    let mut named: Vec<String> = Vec::new();
    for (name, axis) in &calibration.axes {
        let (kind, instance, device_id) = whose(name, axis.sensor, options);
        let not_a_rate = || ExportError::NotARate { axis: name.clone(), unit: axis.rate_unit, format };
        let factor = factor(axis.rate_unit, kind).ok_or_else(not_a_rate)?;
        let place = direction(name).ok_or_else(|| ExportError::NoLetter { axis: name.clone(), format })?;
        let exported = ExportedAxis::of(name, axis).times(factor);
        let at = sensors.iter().position(|sensor| (sensor.kind, sensor.instance) == (kind, instance));
        let at = at.unwrap_or_else(|| {
            let range = [f64::NEG_INFINITY, f64::INFINITY];
            let mut new = ExportedSensor {
                kind,
                instance,
                device_id,
                range,
                axes: [None, None, None],
                told: RateScale::own(axis.rate_unit),
            };
            // Its unit is the axis's, or the factor would be none.
            new.told = calibration.scale(axis.rate_unit).of_rates_in(new.unit(), axis.rate_unit).unwrap_or(new.told);
            sensors.push(new);
            if options.device_id.is_some() && axis.sensor.and_then(|sensor| sensor.device_id).is_none() {
                named.extend(sensors.last().map(ToString::to_string));
            }
            sensors.len() - 1
        });
        let sensor = &mut sensors[at];
        if let Some(other) = &sensor.axes[place] {
            return Err(ExportError::SameAxis {
                first: other.name.clone(),
                second: name.clone(),
                axis: LETTERS[place],
                sensor: sensor.to_string(),
            });
        }
        let [min, max] = exported.cubic.range;
        sensor.range = [sensor.range[0].max(min), sensor.range[1].min(max)];
        sensor.axes[place] = Some(exported);
    }
    if named.len() > 1 {
        return Err(ExportError::OneIdForSeveral { sensors: named.join(", ") });
    }
    sensors.sort_by_key(|sensor| (sensor.kind, sensor.instance));
    Ok(sensors)
}

/// The letters of the axes, by their places.
pub(super) const LETTERS: [char; 3] = ['X', 'Y', 'Z'];

/// The sensor that an axis's name tells: `gyro0.x` or `accel1.z`; a table's column is of one gyro.
fn whose(name: &str, sensor: Option<Sensor>, options: &ExportOptions) -> (SensorKind, u8, Option<u32>) {
    if let Some(sensor) = sensor {
        return (sensor.kind, sensor.instance, sensor.device_id.or(options.device_id));
    }
    let of = |prefix: &str| name.strip_prefix(prefix)?.split_once('.')?.0.parse().ok();
    let (kind, instance) = match (of("gyro"), of("accel")) {
        (Some(instance), _) => (SensorKind::Gyro, instance),
        (None, Some(instance)) => (SensorKind::Accelerometer, instance),
        (None, None) => (SensorKind::Gyro, options.instance.unwrap_or(0)),
    };
    (kind, instance, options.device_id)
}

/// What to know where the log is one autopilot's and the parameters another's: both take the sensor's axes as the board's,
/// and each board's driver says by itself how a part is mounted, and which is the first.
pub(super) fn of_another_autopilot(calibration: &Calibration, own: imu_logs::Format) -> Option<String> {
    let log = calibration.sources.iter().filter_map(|source| source.autopilot()).find(|log| *log != own)?;
    let (from, to) = match log {
        imu_logs::Format::ULog => ("PX4", "ArduPilot"),
        imu_logs::Format::DataFlash => ("ArduPilot", "PX4"),
    };
    Some(format!(
        "the log is {from}'s and these are {to}'s parameters: axes and the sensors' order are as {from}'s driver for this board \
         has them, and {to}'s may turn them or count them otherwise: turn the board by hand about each axis, and use this only \
         where both show the same sign on the same axis of the same sensor"
    ))
}

/// What to know of a sensor's cubics, a sentence an axis.
pub(super) fn remarks(sensor: &ExportedSensor) -> Vec<String> {
    let (told, own) = (sensor.told.unit(), sensor.unit());
    let here = if told == own.name() { String::new() } else { format!("; what they leave is told in {told}") };
    let units = format!("{sensor}: parameters are in the autopilot's own unit, {own}{here}");
    let mut remarks = vec![
        units,
        format!(
            "{sensor}: from {:.2} to {:.2} C; outside, the curve is held at its end",
            sensor.range[0], sensor.range[1]
        ),
    ];
    for (axis, letter) in sensor.axes.iter().zip(LETTERS) {
        remarks.push(match axis {
            None => format!("{sensor} {letter}: not calibrated, left at 0"),
            Some(axis) => format!("{sensor} {letter}: {}", axis.cost(sensor.told)),
        });
        let unmeasured = axis.as_ref().and_then(ExportedAxis::unmeasured);
        remarks.extend(unmeasured.map(|told| format!("{sensor} {letter}: {told}")));
    }
    remarks
}

impl ExportedAxis {
    /// An axis of a calibration, in its own unit.
    #[must_use]
    pub fn of(name: &str, axis: &AxisCalibration) -> Self {
        let cubic = Cubic::of(axis);
        let (model, loss) = (axis.fit.chosen_model(), Loss::of(axis, &cubic));
        let has_history = axis.fit.model.history.is_some();
        let measured = [axis.fit.measured.min(), axis.fit.measured.max()];
        Self { name: name.to_owned(), model, cubic, loss, has_history, measured }
    }

    /// What is to know of temperatures over which the cubic holds without a rate; `None` where all had one.
    fn unmeasured(&self) -> Option<String> {
        /// Half of the last decimal that is told, C.
        const ROUNDING: f64 = 0.005;
        let ([from, to], [least, most]) = (self.measured, self.cubic.range);
        let ends = [(from - least, least), (most - to, most)].into_iter().filter(|(wider, _)| *wider > ROUNDING);
        let ends: Vec<String> = ends.map(|(_, end)| format!("{end:.2}")).collect();
        (!ends.is_empty()).then(|| {
            format!(
                "rates were measured from {from:.2} to {to:.2} C; from there to {} C the log has temperatures without a rate, and \
                 the cubic goes on",
                ends.join(" and ")
            )
        })
    }

    /// The same in another unit.
    fn times(self, factor: f64) -> Self {
        Self { cubic: self.cubic.times(factor), loss: self.loss.times(factor), ..self }
    }

    /// Of what the cubic's distance is: a history has no curve, and what it adds the cubic lacks besides.
    fn without_history(&self) -> &'static str {
        if self.has_history { " less its history (plays, lags)" } else { "" }
    }

    /// Why a model was chosen of which this cubic leaves less of a whole log, a sentence: the choice is by one figure, and that is
    /// another. `None` where the two say the same.
    #[must_use]
    pub fn why_it_was_chosen(&self, scale: RateScale) -> Option<String> {
        let Loss { chosen_rms, cubic_rms, chosen_by, .. } = self.loss;
        let ((model, cubic), chosen_rms, cubic_rms) = (chosen_by?, chosen_rms?, cubic_rms?);
        (TELLING * cubic_rms < chosen_rms && model <= TELLING * cubic).then(|| {
            format!(
                "The model was chosen all the same, by held-out eighths of the log, each with a zero of its own: of these it leaves \
                 {} and the cubic {}. Another run tells which of the figures is right (verify)",
                scale.told(model),
                scale.number(cubic)
            )
        })
    }

    /// What the cubic costs, as a phrase.
    #[must_use]
    pub fn cost(&self, scale: RateScale) -> String {
        let Loss { chosen_rms, cubic_rms, furthest, over_whole_log, .. } = self.loss;
        let left = match over_whole_log {
            true => "rms of a whole log, held out, its zero taken at the start",
            false => "rms of held-out eighths of the log, zeroed",
        };
        match (chosen_rms, cubic_rms) {
            (Some(chosen), Some(cubic)) if (chosen - cubic).abs() <= 1e-9 * chosen.abs() => {
                format!(
                    "the curve of {} is a cubic or less, nothing of it is lost; it leaves {} {left}",
                    self.model,
                    scale.told(chosen)
                )
            }
            (Some(chosen), Some(cubic)) => {
                let costs = format!(
                    "this cubic leaves {} {left}, {:.0} % {} than the chosen {} ({})",
                    scale.told(cubic),
                    100.0 * (cubic / chosen - 1.0).abs(),
                    if cubic <= chosen { "less" } else { "more" },
                    self.model,
                    scale.number(chosen)
                );
                // The cubic is the chosen curve.
                if furthest < 1e-6 * cubic {
                    return costs;
                }
                format!(
                    "{costs}; it is {} from the chosen curve{} at most{}",
                    scale.told(furthest),
                    self.without_history(),
                    self.why_it_was_chosen(scale).map(|why| format!(". {why}")).unwrap_or_default()
                )
            }
            _ => format!(
                "this cubic is {} from the chosen {}{} at most",
                scale.told(furthest),
                self.model,
                self.without_history()
            ),
        }
    }
}

/// What a calibration's unit is in the autopilots'.
fn factor(unit: RateUnit, kind: SensorKind) -> Option<f64> {
    match (unit, kind) {
        (RateUnit::RadPerS, SensorKind::Gyro) => Some(1.0),
        (RateUnit::Dps, SensorKind::Gyro) => Some(1.0_f64.to_radians()),
        (RateUnit::MetresPerS2, SensorKind::Accelerometer) => Some(1.0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensors_are_told_by_the_names_that_imports_give() {
        let none = ExportOptions::default();
        assert_eq!(whose("gyro2.x", None, &none), (SensorKind::Gyro, 2, None));
        assert_eq!(whose("accel0.z", None, &none), (SensorKind::Accelerometer, 0, None));
        let given = ExportOptions { device_id: Some(7), instance: Some(1) };
        assert_eq!(whose("gyro_x", None, &given), (SensorKind::Gyro, 1, Some(7)));
    }
}
