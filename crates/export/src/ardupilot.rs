//! ArduPilot's parameters of IMU temperature calibration.
//!
//! ardupilot, `libraries/AP_InertialSensor/AP_InertialSensor_tempcal.cpp`: with `x` the temperature clamped to TMIN..TMAX
//! less 35 degrees, `P(x) = (c1 + (c2 + c3 x) x) x 1e-6`, rad/s or m/s^2; a reading becomes `reading - P(T) + P(CALTEMP)`,
//! so a constant has no place in it: the gyros' offsets are found at every start. The first three IMUs' parameters are
//! `INS_TCAL1_` to `INS_TCAL3_`, those of the fourth and the fifth `INS4_TCAL_` and `INS5_TCAL_`
//! (`AP_InertialSensor_Params.cpp`, at commit 2326212). The file: a name and a value a line, with a space between, or a comma for the
//! MethodicConfigurator; comments with #.

use std::fmt::Write as _;

use super::sensors::{LETTERS, of_another_autopilot, remarks, sensors};
use super::{ExportError, ExportOptions, Exported, ExportedSensor, Format, origin, to_know_of_cubics};
use imu_logs::temperature_parameters;
use zerorate_cal::calibration::Calibration;
use zerorate_cal::log::SensorKind;

/// IMUs that ArduPilot has parameters for.
const PLACES: u8 = 5;

/// `TEMP_REFERENCE`, degrees C.
const REFERENCE_C: f64 = 35.0;

/// `SCALE_FACTOR`: parameters are in millionths.
const SCALE: f64 = 1e6;

pub(super) fn write(
    calibration: &Calibration,
    options: &ExportOptions,
    between: char,
) -> Result<Exported, ExportError> {
    let format = if between == ',' { Format::MethodicConfigurator } else { Format::ArduPilot };
    let mut sensors = sensors(calibration, options, format)?;
    let mut notes = vec![
        "load it in a ground station and reboot; then calibrate the accelerometers again and set INS_GYR_CAL to 1, so that offsets are found with the compensation on".to_owned(),
        "the format holds no constant: what is exported is the drift from one temperature to another".to_owned(),
    ];
    notes.extend(of_another_autopilot(calibration, imu_logs::Format::DataFlash));
    notes.extend(to_know_of_cubics(calibration, &sensors));
    let mut text = String::new();
    let mut imus: Vec<u8> = sensors.iter().map(|sensor| sensor.instance).collect();
    imus.sort_unstable();
    imus.dedup();
    let mut lines = String::new();
    for imu in imus {
        let of_imu: Vec<&mut ExportedSensor> = sensors.iter_mut().filter(|sensor| sensor.instance == imu).collect();
        write_imu(&mut lines, imu, of_imu, between, format)?;
    }
    let has = |imu: u8, kind: SensorKind| sensors.iter().any(|sensor| (sensor.instance, sensor.kind) == (imu, kind));
    for sensor in sensors.iter().filter(|sensor| !has(sensor.instance, SensorKind::Accelerometer)) {
        notes.push(format!(
            "no accelerometer of IMU {} was calibrated: {}ACC1_X to ACC3_Z stay as they are; set them to 0 unless they hold for the same range",
            sensor.instance + 1,
            temperature_parameters(sensor.instance)
        ));
    }
    for sensor in &sensors {
        notes.extend(remarks(sensor));
    }
    for note in origin(calibration).iter().chain(&notes) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "# {note}");
    }
    text.push_str(&lines);
    Ok(Exported { text, sensors, notes })
}

/// Writes one IMU, and turns its cubics to the reference and range as they are written.
// The autopilot keeps singles.
#[allow(clippy::cast_possible_truncation)]
fn write_imu(
    lines: &mut String,
    imu: u8,
    sensors: Vec<&mut ExportedSensor>,
    between: char,
    format: Format,
) -> Result<(), ExportError> {
    if let Some(sensor) = sensors.first().filter(|sensor| sensor.instance >= PLACES) {
        return Err(ExportError::NoPlace { sensor: sensor.to_string(), format, places: PLACES });
    }
    let prefix = temperature_parameters(imu);
    let mut line = |name: String, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(lines, "{prefix}{name}{between}{value}");
    };
    // One range for both sensors: the temperatures that both hold for.
    let range = sensors.iter().fold([f64::NEG_INFINITY, f64::INFINITY], |range, sensor| {
        [range[0].max(sensor.range[0]), range[1].min(sensor.range[1])]
    });
    let range = range.map(|end| f64::from(end as f32));
    line("ENABLE".to_owned(), "1".to_owned());
    line("TMIN".to_owned(), format!("{:?}", range[0] as f32));
    line("TMAX".to_owned(), format!("{:?}", range[1] as f32));
    for sensor in sensors {
        sensor.range = range;
        for axis in sensor.axes.iter_mut().flatten() {
            axis.cubic = axis.cubic.about(REFERENCE_C).without_constant();
            axis.cubic.range = range;
        }
        let kind = match sensor.kind {
            SensorKind::Gyro => "GYR",
            SensorKind::Accelerometer => "ACC",
        };
        for power in 1..=3 {
            for (axis, letter) in sensor.axes.iter().zip(LETTERS) {
                let coefficient = axis.as_ref().map_or(0.0, |axis| axis.cubic.coefficients[power]);
                line(format!("{kind}{power}_{letter}"), format!("{:.9}", coefficient * SCALE));
            }
        }
    }
    Ok(())
}
