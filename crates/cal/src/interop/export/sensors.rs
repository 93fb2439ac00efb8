//! Which axes of a calibration belong to which sensor.

use std::fmt;

use serde::Serialize;

use super::cubic::{Loss, StaticCubic};
use super::{ExportError, ExportOptions, Format};
use crate::calibration::Calibration;
use crate::log::{Sensor, SensorKind};
use crate::quality::TemperatureUnit;
use crate::table::RateUnit;

/// What a sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Angular rate, rad/s.
    Gyro,
    /// Specific force, m/s^2. Its drift is taken from the reference temperature on: at rest gravity hides the constant.
    Accelerometer,
}

/// One sensor with up to three axes, in the autopilots' units: rad/s or m/s^2, degrees C.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExportedSensor {
    /// What it measures.
    pub kind: Kind,
    /// Its place among those of its kind, from 0.
    pub instance: u8,
    /// The autopilot's number for the part.
    pub device_id: Option<u32>,
    /// The temperatures over which all its axes hold.
    pub range: [f64; 2],
    /// X, Y and Z; `None` where the calibration has none of it.
    pub axes: [Option<ExportedAxis>; 3],
}

/// One axis of a sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExportedAxis {
    /// Its name in the calibration.
    pub name: String,
    /// The model that was chosen.
    pub model: String,
    /// The cubic.
    pub cubic: StaticCubic,
    /// What the cubic costs.
    pub loss: Loss,
}

impl fmt::Display for ExportedSensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            Kind::Gyro => write!(f, "gyro {}", self.instance),
            Kind::Accelerometer => write!(f, "accelerometer {}", self.instance),
        }
    }
}

impl Kind {
    /// The unit of a sensor's cubic.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Gyro => "rad/s",
            Self::Accelerometer => "m/s^2",
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
    for (name, axis) in &calibration.axes {
        let (kind, instance, device_id) = whose(name, axis.sensor, options);
        let not_a_rate = || ExportError::NotARate { axis: name.clone(), unit: axis.rate_unit, format };
        let factor = factor(axis.rate_unit, kind).ok_or_else(not_a_rate)?;
        let place = letter(name).ok_or_else(|| ExportError::NoLetter { axis: name.clone(), format })?;
        let cubic = StaticCubic::of(axis);
        let loss = Loss::of(axis, &cubic).times(factor);
        let model = super::code::model_of(axis);
        let exported = ExportedAxis { name: name.clone(), model, cubic: cubic.times(factor), loss };
        let at = sensors.iter().position(|sensor| (sensor.kind, sensor.instance) == (kind, instance));
        let at = at.unwrap_or_else(|| {
            let range = [f64::NEG_INFINITY, f64::INFINITY];
            sensors.push(ExportedSensor { kind, instance, device_id, range, axes: [None, None, None] });
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
    sensors.sort_by_key(|sensor| (sensor.kind, sensor.instance));
    Ok(sensors)
}

/// The letters of the axes, by their places.
pub(super) const LETTERS: [char; 3] = ['X', 'Y', 'Z'];

/// The sensor that an axis's name tells: `gyro0.x` or `accel1.z`; a table's column is of one gyro.
fn whose(name: &str, sensor: Option<Sensor>, options: &ExportOptions) -> (Kind, u8, Option<u32>) {
    if let Some(sensor) = sensor {
        let kind = match sensor.kind {
            SensorKind::Gyro => Kind::Gyro,
            SensorKind::Accelerometer => Kind::Accelerometer,
        };
        return (kind, sensor.instance, sensor.device_id.or(options.device_id));
    }
    let of = |prefix: &str| name.strip_prefix(prefix)?.split_once('.')?.0.parse().ok();
    let (kind, instance) = match (of("gyro"), of("accel")) {
        (Some(instance), _) => (Kind::Gyro, instance),
        (None, Some(instance)) => (Kind::Accelerometer, instance),
        (None, None) => (Kind::Gyro, options.instance.unwrap_or(0)),
    };
    (kind, instance, options.device_id)
}

/// What to know of a sensor's cubics, a sentence an axis.
pub(super) fn remarks(sensor: &ExportedSensor) -> Vec<String> {
    let unit = sensor.kind.unit();
    let mut remarks = vec![format!(
        "{sensor}: from {:.2} to {:.2} C; outside, the curve is held at its end",
        sensor.range[0], sensor.range[1]
    )];
    for (axis, letter) in sensor.axes.iter().zip(LETTERS) {
        remarks.push(match axis {
            None => format!("{sensor} {letter}: not calibrated, left at 0"),
            Some(axis) => format!("{sensor} {letter}: {}", axis.cost(unit)),
        });
    }
    remarks
}

impl ExportedAxis {
    /// What the cubic costs, as a phrase.
    #[must_use]
    pub fn cost(&self, unit: &str) -> String {
        let Loss { chosen_rms, cubic_rms, furthest } = self.loss;
        match (chosen_rms, cubic_rms) {
            (Some(chosen), Some(cubic)) if (chosen - cubic).abs() <= 1e-9 * chosen.abs() => {
                format!(
                    "{} is a cubic or less, nothing is lost; it leaves {chosen:.3e} {unit} rms held out",
                    self.model
                )
            }
            (Some(chosen), Some(cubic)) => {
                let costs = format!(
                    "this cubic leaves {cubic:.3e} {unit} rms held out, the chosen {} {chosen:.3e} ({:+.0} %)",
                    self.model,
                    100.0 * (cubic / chosen - 1.0)
                );
                // A history leans on the cubic itself: there is no distance to speak of.
                if furthest < 1e-6 * cubic {
                    return costs;
                }
                format!("{costs}; it is {furthest:.1e} {unit} from the chosen curve at most")
            }
            _ => format!("this cubic is {furthest:.1e} {unit} from the chosen {} at most", self.model),
        }
    }
}

/// What a calibration's unit is in the autopilots'.
fn factor(unit: RateUnit, kind: Kind) -> Option<f64> {
    match (unit, kind) {
        (RateUnit::RadPerS, Kind::Gyro) => Some(1.0),
        (RateUnit::Dps, Kind::Gyro) => Some(1.0_f64.to_radians()),
        (RateUnit::MetresPerS2, Kind::Accelerometer) => Some(1.0),
        _ => None,
    }
}

/// The place of an axis by its name: a word of its own (`gyro.x`, `x_rad_s`, `gyro[0]`) or a capital at a word's end
/// (`GyrX`).
fn letter(name: &str) -> Option<usize> {
    let words = || name.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    let place = |word: &str| match word {
        "x" | "X" | "0" => Some(0),
        "y" | "Y" | "1" => Some(1),
        "z" | "Z" | "2" => Some(2),
        _ => None,
    };
    let at_end = |word: &str| match word.chars().last()? {
        'X' => Some(0),
        'Y' => Some(1),
        'Z' => Some(2),
        _ => None,
    };
    words().filter_map(place).next_back().or_else(|| words().filter_map(at_end).next_back())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_told_by_the_names_that_logs_have() {
        let letters: Vec<Option<usize>> =
            ["gyro0.x", "imu.gyro.y", "z_rad_s", "GyrX", "gyro[1]", "gyro_rad[2]", "rate"]
                .into_iter()
                .map(letter)
                .collect();
        assert_eq!(letters, [Some(0), Some(1), Some(2), Some(0), Some(1), Some(2), None]);
    }

    #[test]
    fn sensors_are_told_by_the_names_that_imports_give() {
        let none = ExportOptions::default();
        assert_eq!(whose("gyro2.x", None, &none), (Kind::Gyro, 2, None));
        assert_eq!(whose("accel0.z", None, &none), (Kind::Accelerometer, 0, None));
        let given = ExportOptions { device_id: Some(7), instance: Some(1) };
        assert_eq!(whose("gyro_x", None, &given), (Kind::Gyro, 1, Some(7)));
    }
}
