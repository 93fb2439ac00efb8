//! What the autopilot did to a reading before it logged it, undone.
//!
//! The autopilot's order is: temperature, offset (and the accelerometer's scale), board orientation. With x the temperature
//! held within TMIN and TMAX less 35 C, and P(x) = (c1 x + c2 x^2 + c3 x^3) 1e-6, it takes P(T) - P(CALTEMP) from the
//! reading; so that much is added here, to the reading turned back with its offset restored.

use std::collections::HashMap;

use super::rotation::Rotation;
use crate::{Remark, SensorKind};

/// The autopilot's reference temperature.
const REFERENCE_C: f64 = 35.0;

/// Its coefficients are given in millionths.
const MILLIONTH: f64 = 1e-6;

/// A calibration temperature below this is that of a sensor that was never calibrated (the default is -300).
const NEVER_CALIBRATED_C: f64 = -80.0;

/// IMUs that have such parameters.
const IMUS: usize = 5;

/// Those whose parameters are counted within one group; the fourth and the fifth have a group each, `INS4_` and `INS5_`
/// (`AP_InertialSensor_Params.cpp`).
const TOGETHER: u8 = 3;

/// Parameters kept, at most: more than the autopilot has of these, so that a damaged log does not fill the memory.
const MAX_PARAMETERS: usize = 1024;

/// The values of INS_TCALn_ENABLE and of its like.
const ENABLED: f64 = 1.0;
const LEARNING: f64 = 2.0;

/// The parameters that bear on readings.
#[derive(Debug, Default)]
pub(super) struct Parameters {
    values: HashMap<String, f64>,
    stopped: [bool; IMUS],
    /// What readings were restored by, worked out anew when a parameter changes.
    known: HashMap<(SensorKind, u8), Option<Restore>>,
    undone: [bool; IMUS],
    turned: bool,
    offset: bool,
    unknown_orientation: Option<f64>,
}

/// What to do to one sensor's readings.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Restore {
    rotation: Rotation,
    scale: [f64; 3],
    offset: [f64; 3],
    /// c1, c2, c3 of each axis.
    coefficients: Option<[[f64; 3]; 3]>,
    range: (f64, f64),
    calibrated_at_c: f64,
}

impl Parameters {
    /// A parameter that the log begins with: of several values the first.
    pub(super) fn begin(&mut self, name: &str, value: f64) {
        if matters(name) && self.values.len() < MAX_PARAMETERS {
            self.values.entry(name.to_owned()).or_insert(value);
        }
    }

    /// A parameter as the log goes by.
    pub(super) fn change(&mut self, name: &str, value: f64) {
        if !matters(name) || (self.values.len() >= MAX_PARAMETERS && !self.values.contains_key(name)) {
            return;
        }
        let before = self.values.insert(name.to_owned(), value);
        if before.is_some_and(|before| before.to_bits() == value.to_bits()) {
            return;
        }
        self.known.clear();
        for (imu, stopped) in (0..).zip(&mut self.stopped) {
            let switched = name == format!("{}ENABLE", temperature_parameters(imu));
            // Learning that begins changes no reading.
            *stopped |= switched && before.is_some() && !is(value, LEARNING);
        }
    }

    fn value(&self, name: &str) -> Option<f64> {
        self.values.get(name).copied()
    }

    fn three(&self, prefix: &str, default: f64) -> [f64; 3] {
        ["X", "Y", "Z"].map(|axis| self.value(&format!("{prefix}{axis}")).unwrap_or(default))
    }

    /// The part's number.
    // A parameter holds it as a number of up to 32 bits.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub(super) fn device_id(&self, kind: SensorKind, instance: u8) -> Option<u32> {
        let id = self.value(&format!("{}_ID", of_sensor(kind, instance)))?;
        (id >= 1.0 && id <= f64::from(u32::MAX)).then_some(id as u32)
    }

    /// A reading as the sensor gave it; `None` for one that cannot be restored.
    pub(super) fn restore(
        &mut self,
        kind: SensorKind,
        imu: u8,
        temperature: f64,
        values: [f64; 3],
    ) -> Option<[f64; 3]> {
        let restore = match self.known.get(&(kind, imu)) {
            Some(known) => *known,
            None => {
                let found = self.find(kind, imu);
                self.known.insert((kind, imu), found);
                found
            }
        }?;
        Some(restore.apply(temperature, values))
    }

    fn find(&mut self, kind: SensorKind, imu: u8) -> Option<Restore> {
        let place = usize::from(imu);
        if self.stopped.get(place).copied().unwrap_or(false) {
            return None;
        }
        let orientation = self.value("AHRS_ORIENTATION").unwrap_or(0.0);
        let rotation = Rotation::of(orientation);
        if rotation.is_none() {
            self.unknown_orientation = Some(orientation);
        }
        let (sensor, prefix, own) = (letters(kind), temperature_parameters(imu), of_sensor(kind, imu));
        let enabled = self.value(&format!("{prefix}ENABLE")).is_some_and(|value| is(value, ENABLED));
        let calibrated_at_c = self.value(&calibrated_at(kind, imu)).unwrap_or(REFERENCE_C);
        let coefficients = (enabled && calibrated_at_c > NEVER_CALIBRATED_C).then(|| {
            ["X", "Y", "Z"].map(|axis| {
                [1, 2, 3].map(|order| MILLIONTH * self.value(&format!("{prefix}{sensor}{order}_{axis}")).unwrap_or(0.0))
            })
        });
        let restore = Restore {
            rotation: rotation.or_else(|| Rotation::of(0.0))?,
            scale: match kind {
                SensorKind::Gyro => [1.0; 3],
                SensorKind::Accelerometer => self.three(&format!("{own}SCAL_"), 1.0),
            },
            offset: self.three(&format!("{own}OFFS_"), 0.0),
            coefficients,
            range: (
                self.value(&format!("{prefix}TMIN")).unwrap_or(f64::NEG_INFINITY),
                self.value(&format!("{prefix}TMAX")).unwrap_or(f64::INFINITY),
            ),
            calibrated_at_c,
        };
        if let Some(undone) = self.undone.get_mut(place) {
            *undone |= coefficients.is_some();
        }
        self.turned |= orientation.abs() > 0.5 && self.unknown_orientation.is_none();
        self.offset |= restore.offset.iter().any(|offset| offset.abs() > 0.0);
        Some(restore)
    }

    /// What was undone.
    pub(super) fn remarks(&self) -> Vec<Remark> {
        let mut remarks = Vec::new();
        for (imu, (undone, stopped)) in (1_u8..).zip(self.undone.iter().zip(self.stopped)) {
            // Switched in the middle of the log: what it was before and after cannot be told apart surely.
            if stopped {
                remarks.push(Remark::CalibrationSwitched { imu });
            } else if *undone {
                remarks.push(Remark::CalibrationUndone { imu });
            }
        }
        if self.turned {
            remarks.push(Remark::TurnedBack);
        }
        if self.offset {
            remarks.push(Remark::OffsetsRestored);
        }
        remarks.extend(self.unknown_orientation.map(|orientation| Remark::UnknownOrientation { orientation }));
        remarks
    }
}

impl Restore {
    fn apply(&self, temperature: f64, values: [f64; 3]) -> [f64; 3] {
        let turned = self.rotation.inverse(values);
        let mut restored = [0, 1, 2].map(|axis| turned[axis] / self.scale[axis] + self.offset[axis]);
        if let Some(coefficients) = self.coefficients {
            let x = |temperature: f64| temperature.max(self.range.0).min(self.range.1) - REFERENCE_C;
            let (now, then) = (x(temperature), x(self.calibrated_at_c));
            let polynomial = |c: [f64; 3], x: f64| (c[0] + (c[1] + c[2] * x) * x) * x;
            for (value, c) in restored.iter_mut().zip(coefficients) {
                // Without a temperature the autopilot did not correct either.
                let corrected = polynomial(c, now) - polynomial(c, then);
                *value += if temperature.is_nan() { 0.0 } else { corrected };
            }
        }
        restored
    }
}

/// Whether a parameter bears on readings.
fn matters(name: &str) -> bool {
    let own = ["INS_", "INS4_", "INS5_"].into_iter().find_map(|group| name.strip_prefix(group));
    name == "AHRS_ORIENTATION"
        || own.is_some_and(|rest| ["GYR", "ACC", "TCAL"].iter().any(|part| rest.starts_with(part)))
}

fn is(value: f64, of: f64) -> bool {
    (value - of).abs() < 0.5
}

fn letters(kind: SensorKind) -> &'static str {
    match kind {
        SensorKind::Gyro => "GYR",
        SensorKind::Accelerometer => "ACC",
    }
}

/// What the names of a sensor's own parameters begin with: `INS_GYR`, `INS_GYR2`, `INS4_GYR`.
fn of_sensor(kind: SensorKind, imu: u8) -> String {
    let (letters, number) = (letters(kind), u16::from(imu) + 1);
    match imu {
        0 => format!("INS_{letters}"),
        imu if imu < TOGETHER => format!("INS_{letters}{number}"),
        _ => format!("INS{number}_{letters}"),
    }
}

/// What the names of the parameters of an IMU's drift over temperature begin with, the first being 0: `INS_TCAL1_`, `INS4_TCAL_`.
#[must_use]
pub fn temperature_parameters(imu: u8) -> String {
    let number = u16::from(imu) + 1;
    if imu < TOGETHER { format!("INS_TCAL{number}_") } else { format!("INS{number}_TCAL_") }
}

/// The name of the temperature at which it was calibrated: `INS_GYR1_CALTEMP`, `INS4_GYR_CALTEMP`.
fn calibrated_at(kind: SensorKind, imu: u8) -> String {
    match imu {
        0 => format!("INS_{}1_CALTEMP", letters(kind)),
        _ => format!("{}_CALTEMP", of_sensor(kind, imu)),
    }
}
