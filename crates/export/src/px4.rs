//! PX4's parameters of thermal compensation.
//!
//! PX4-Autopilot, `src/modules/temperature_compensation/TemperatureCompensation.cpp`: a sensor is found by its device id;
//! the temperature is clamped to TMIN..TMAX, `d` is it less TREF, and the offset is `X0 + X1 d + X2 d^2 + X3 d^3`, all in
//! single precision, rad/s or m/s^2 and degrees C. The file: comments with #, then lines of vehicle id, component id, name,
//! value and MAVLink type (6: int32, 9: float), parted by tabs.

use std::fmt::Write as _;

use super::sensors::{of_another_autopilot, remarks, sensors};
use super::{ExportError, ExportOptions, Exported, ExportedSensor, Format, origin, to_know_of_cubics};
use zerorate_cal::calibration::Calibration;
use zerorate_cal::log::SensorKind;

/// Sensors of a kind that PX4 has parameters for.
const PLACES: u8 = 4;

/// MAVLink's types.
const INT32: u8 = 6;
const FLOAT: u8 = 9;

pub(super) fn write(calibration: &Calibration, options: &ExportOptions) -> Result<Exported, ExportError> {
    let mut sensors = sensors(calibration, options, Format::Px4)?;
    let mut notes = vec![
        "load it in QGroundControl (Vehicle Setup, Parameters, Tools, Load from file), reboot, then calibrate the gyros again: offsets that were found without the compensation would be counted twice".to_owned(),
    ];
    notes.extend(of_another_autopilot(calibration, imu_logs::Format::ULog));
    notes.extend(to_know_of_cubics(calibration, &sensors));
    let mut lines = String::new();
    for kind in [SensorKind::Gyro, SensorKind::Accelerometer] {
        if sensors.iter().any(|sensor| sensor.kind == kind) {
            line(&mut lines, &format!("TC_{}_ENABLE", letter(kind)), "1", INT32);
        }
    }
    for sensor in &mut sensors {
        write_sensor(&mut lines, sensor)?;
    }
    for sensor in &sensors {
        notes.extend(remarks(sensor));
    }
    let mut text = "# Sensor thermal compensation parameters\n#\n".to_owned();
    for note in origin(calibration).iter().chain(&notes) {
        let _ = writeln!(text, "# {note}");
    }
    text.push_str("#\n# Vehicle-Id Component-Id Name Value Type\n");
    text.push_str(&lines);
    Ok(Exported { text, sensors, notes })
}

fn letter(kind: SensorKind) -> char {
    match kind {
        SensorKind::Gyro => 'G',
        SensorKind::Accelerometer => 'A',
    }
}

fn line(lines: &mut String, name: &str, value: &str, kind: u8) {
    // Writing to a string cannot fail.
    let _ = writeln!(lines, "1\t1\t{name}\t{value}\t{kind}");
}

/// Writes a sensor, and turns its cubics to the reference and range as they are written.
// The autopilot keeps singles.
#[allow(clippy::cast_possible_truncation)]
fn write_sensor(lines: &mut String, sensor: &mut ExportedSensor) -> Result<(), ExportError> {
    if sensor.instance >= PLACES {
        return Err(ExportError::NoPlace { sensor: sensor.to_string(), format: Format::Px4, places: PLACES });
    }
    let id =
        sensor.device_id.filter(|id| *id > 0).ok_or_else(|| ExportError::NoDeviceId { sensor: sensor.to_string() })?;
    let prefix = format!("TC_{}{}", letter(sensor.kind), sensor.instance);
    // An int32 holds the id's bits.
    line(lines, &format!("{prefix}_ID"), &id.cast_signed().to_string(), INT32);
    let single = |value: f64| f64::from(value as f32);
    let range = sensor.range.map(single);
    let reference = single(f64::midpoint(range[0], range[1]));
    for (name, value) in [("TMIN", range[0]), ("TMAX", range[1]), ("TREF", reference)] {
        line(lines, &format!("{prefix}_{name}"), &number(value), FLOAT);
    }
    for (place, axis) in sensor.axes.iter_mut().enumerate() {
        let mut coefficients = [0.0; 4];
        if let Some(axis) = axis {
            axis.cubic = axis.cubic.about(reference);
            axis.cubic.range = range;
            coefficients = axis.cubic.coefficients;
        }
        for (power, value) in coefficients.into_iter().enumerate() {
            line(lines, &format!("{prefix}_X{power}_{place}"), &number(value), FLOAT);
        }
    }
    sensor.range = range;
    Ok(())
}

/// The shortest text that reads back to the same single; without an exponent where it is short, as other programs write.
#[allow(clippy::cast_possible_truncation)]
fn number(value: f64) -> String {
    let single = value as f32;
    if single == 0.0 || (1e-4..1e6).contains(&single.abs()) { format!("{single:?}") } else { format!("{single:e}") }
}
