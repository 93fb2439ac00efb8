// Readings are logged as f32, and bytes of a type are small.
#![allow(clippy::cast_possible_truncation, clippy::float_cmp)]

use std::io::Cursor;

use super::rotation::Rotation;
use super::*;
use crate::Rows;

/// Takes everything.
#[derive(Default)]
struct All {
    sensors: Vec<Sensor>,
    rows: Vec<(usize, f64, f64, [f64; 3])>,
}

impl Sink for All {
    fn sensor(&mut self, sensor: &Sensor) -> bool {
        self.sensors.push(*sensor);
        true
    }

    fn rows(&mut self, rows: &Rows<'_>) {
        for place in 0..rows.temperature.len() {
            let values = [0, 1, 2].map(|axis: usize| rows.values[axis][place]);
            self.rows.push((rows.sensor, rows.time_s[place], rows.temperature[place], values));
        }
    }
}

fn take(bytes: &[u8]) -> (All, Vec<Remark>) {
    let mut all = All::default();
    let ending = read(Cursor::new(bytes), &mut all).unwrap();
    (all, ending.remarks)
}

fn define(kind: u8, length: u8, name: &str, letters: &str, labels: &str) -> Vec<u8> {
    let padded = |text: &str, size: usize| [text.as_bytes(), &vec![0; size - text.len()]].concat();
    [&MAGIC[..], &[FORMAT_TYPE, kind, length], &padded(name, 4), &padded(letters, 16), &padded(labels, 64)].concat()
}

const IMU: u8 = 130;
const PARM: u8 = 64;
const TCLR: u8 = 131;

/// The formats that an autopilot writes today.
fn head() -> Vec<u8> {
    [
        define(FORMAT_TYPE, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        define(PARM, 3 + 8 + 16 + 8, "PARM", "QNff", "TimeUS,Name,Value,Default"),
        define(IMU, 3 + 8 + 1 + 24 + 8 + 4, "IMU", "QBffffffIIf", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T"),
        define(TCLR, 3 + 8 + 2 + 16 + 4, "TCLR", "QBBffffI", "TimeUS,I,SType,Temp,X,Y,Z,NSamp"),
    ]
    .concat()
}

fn parameter(name: &str, value: f32) -> Vec<u8> {
    let name = [name.as_bytes(), &vec![0; 16 - name.len()]].concat();
    [&MAGIC[..], &[PARM], &0_u64.to_le_bytes(), &name, &value.to_le_bytes(), &value.to_le_bytes()].concat()
}

fn imu(time_us: u64, instance: u8, temperature: f32, gyro: [f32; 3], accelerometer: [f32; 3]) -> Vec<u8> {
    let mut message = [&MAGIC[..], &[IMU], &time_us.to_le_bytes(), &[instance]].concat();
    gyro.iter().chain(&accelerometer).for_each(|value| message.extend(value.to_le_bytes()));
    message.extend([0; 8]);
    message.extend(temperature.to_le_bytes());
    message
}

fn near(a: [f64; 3], b: [f64; 3]) {
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
}

#[test]
fn every_imu_is_a_gyro_and_an_accelerometer_with_their_parts_numbers() {
    let mut log = head();
    log.extend(parameter("INS_GYR2_ID", 2_752_530.0));
    log.extend(imu(1_000_000, 0, 20.0, [0.1, 0.2, 0.3], [1.0, 2.0, -9.8]));
    log.extend(imu(1_000_000, 1, 25.0, [0.4, 0.5, 0.6], [0.0; 3]));
    let (all, remarks) = take(&log);
    let sensors: Vec<String> = all.sensors.iter().map(ToString::to_string).collect();
    assert_eq!(sensors, ["gyro0", "accel0", "gyro1", "accel1"]);
    assert_eq!(all.sensors[2].device_id, Some(2_752_530));
    near(all.rows[1].3, [1.0, 2.0, -9.8]);
    assert_eq!((all.rows[2].2, remarks), (25.0, vec![]));
}

/// By the autopilot's formulas, forwards: P(T) - P(CALTEMP) off, then the offset, then the board's orientation.
#[test]
fn what_the_autopilot_took_off_is_put_back() {
    let mut log = head();
    // The first readings come before the parameters, as they do.
    let raw = [0.01, -0.02, 0.03];
    let polynomial = |t: f64| {
        let x = t.clamp(0.0, 60.0) - 35.0;
        1e-6 * (120.0 * x - 3.0 * x * x + 0.05 * x * x * x)
    };
    let offsets = [0.001, 0.002, -0.003];
    let rotation = Rotation::of(10.0).unwrap();
    let logged = |t: f64| {
        let corrected = [0, 1, 2].map(|axis| raw[axis] - polynomial(t) + polynomial(40.0) - offsets[axis]);
        rotation.forward(corrected).map(|value| value as f32)
    };
    log.extend(imu(0, 0, -5.0, logged(-5.0), [0.0; 3]));
    for (name, value) in [
        ("AHRS_ORIENTATION", 10.0),
        ("INS_TCAL1_ENABLE", 1.0),
        ("INS_TCAL1_TMIN", 0.0),
        ("INS_TCAL1_TMAX", 60.0),
        ("INS_GYR1_CALTEMP", 40.0),
        ("INS_GYROFFS_X", 0.001),
        ("INS_GYROFFS_Y", 0.002),
        ("INS_GYROFFS_Z", -0.003),
    ] {
        log.extend(parameter(name, value));
    }
    for axis in ["X", "Y", "Z"] {
        for (order, value) in [(1, 120.0), (2, -3.0), (3, 0.05)] {
            log.extend(parameter(&format!("INS_TCAL1_GYR{order}_{axis}"), value));
        }
    }
    for (k, t) in [10.0_f32, 50.0, 80.0].into_iter().enumerate() {
        log.extend(imu(1000 * (k as u64 + 1), 0, t, logged(f64::from(t)), [0.0; 3]));
    }
    let (all, remarks) = take(&log);
    let gyro: Vec<_> = all.rows.iter().filter(|row| row.0 == 0).collect();
    assert_eq!(gyro.len(), 4);
    gyro.iter().for_each(|row| near(row.3, raw));
    assert_eq!(remarks, [Remark::CalibrationUndone { imu: 1 }, Remark::TurnedBack, Remark::OffsetsRestored]);
}

/// Names as `AP_InertialSensor_Params.cpp` has them for the fourth IMU and the fifth.
#[test]
fn what_the_autopilot_took_off_the_fourth_and_fifth_imu_is_put_back() {
    let (raw, offset) = ([0.01, -0.02, 0.03], 0.002_f32);
    for (place, group) in [(3_u8, "INS4_"), (4, "INS5_")] {
        let mut log = head();
        for (name, value) in [
            ("GYR_ID", 2_752_530.0),
            ("GYR_CALTEMP", 45.0),
            ("GYROFFS_Y", offset),
            ("TCAL_ENABLE", 1.0),
            ("TCAL_TMIN", 0.0),
            ("TCAL_TMAX", 60.0),
            ("TCAL_GYR1_X", 100.0),
            ("ACCSCAL_X", 2.0),
        ] {
            log.extend(parameter(&format!("{group}{name}"), value));
        }
        // P(55) - P(45) of 100e-6 a degree is 1e-3.
        let logged = [raw[0] - 1e-3, raw[1] - f64::from(offset), raw[2]].map(|value| value as f32);
        log.extend(imu(1000, place, 55.0, logged, [3.0, 0.0, 0.0]));
        let (all, remarks) = take(&log);
        let gyro = all.sensors.iter().position(|sensor| sensor.to_string() == format!("gyro{place}")).unwrap();
        assert_eq!(all.sensors[gyro].device_id, Some(2_752_530));
        near(all.rows[0].3, raw);
        near(all.rows[1].3, [1.5, 0.0, 0.0]);
        assert_eq!(remarks, [Remark::CalibrationUndone { imu: place + 1 }, Remark::OffsetsRestored]);
    }
}

#[test]
fn orientations_are_the_autopilots() {
    // rotations of a vector as libraries/AP_Math/vector3.cpp has them.
    let v = [1.0, 2.0, 3.0];
    for (number, turned) in [
        (2.0, [-2.0, 1.0, 3.0]),
        (8.0, [1.0, -2.0, -3.0]),
        (16.0, [1.0, -3.0, 2.0]),
        (24.0, [3.0, 2.0, -1.0]),
        (10.0, [2.0, 1.0, -3.0]),
    ] {
        let rotation = Rotation::of(number).unwrap();
        near(rotation.forward(v), turned);
        near(rotation.inverse(turned), v);
    }
    assert!(Rotation::of(44.0).is_none() && Rotation::of(100.0).is_none() && Rotation::of(f64::NAN).is_none());
}

#[test]
fn readings_after_the_calibration_was_switched_are_left_out() {
    let mut log = head();
    log.extend(parameter("INS_TCAL1_ENABLE", 2.0));
    log.extend(imu(0, 0, 20.0, [0.0; 3], [0.0; 3]));
    log.extend(parameter("INS_TCAL1_ENABLE", 1.0));
    log.extend(imu(1000, 0, 20.0, [0.0; 3], [0.0; 3]));
    let (all, remarks) = take(&log);
    assert_eq!(all.rows.len(), 2);
    assert_eq!(remarks, [Remark::CalibrationSwitched { imu: 1 }]);
}

#[test]
fn a_log_of_the_learning_alone_gives_its_means() {
    let mut log = head();
    for (k, kind) in [(0_u64, 1_u8), (1, 0)] {
        log.extend([&MAGIC[..], &[TCLR], &(1000 * k).to_le_bytes(), &[0, kind]].concat());
        [40.5_f32, 5.0, -10.0, 20.0].iter().for_each(|value| log.extend(value.to_le_bytes()));
        log.extend(10_u32.to_le_bytes());
    }
    let (all, remarks) = take(&log);
    assert_eq!(all.rows.len(), 2);
    near(all.rows[0].3, [0.5, -1.0, 2.0]);
    assert_eq!(all.rows[0].2, 40.5);
    assert_eq!(remarks, [Remark::LearningOnly { means: 2 }]);
}

#[test]
fn cut_damaged_and_hostile_logs_give_what_is_whole() {
    let mut log = head();
    (0..10).for_each(|k| log.extend(imu(1000 * k, 0, 20.0, [0.0; 3], [0.0; 3])));
    let (all, remarks) = take(&log[..log.len() - 5]);
    assert_eq!(all.rows.len(), 18);
    assert!(matches!(remarks[..], [Remark::Cut { .. }]), "{remarks:?}");
    log.extend([0x11; 50]);
    log.extend(imu(20_000, 0, 20.0, [0.0; 3], [0.0; 3]));
    let (all, remarks) = take(&log);
    assert_eq!(all.rows.len(), 22);
    assert_eq!(remarks, [Remark::Damaged { bytes: 50 }]);
    // A format shorter than its own header, and one that redefines formats.
    log.extend(define(200, 2, "BAD", "Q", "TimeUS"));
    log.extend([&MAGIC[..], &[200, 1, 2]].concat());
    log.extend(define(FORMAT_TYPE, 4, "FMT", "B", "Type"));
    log.extend(imu(30_000, 0, 20.0, [0.0; 3], [0.0; 3]));
    assert_eq!(take(&log).0.rows.len(), 24);
}

/// What a receiver says: its status, the week of GPS time and the milliseconds in it.
fn gps(time_us: u64, status: u8, week: u16, ms: u32) -> Vec<u8> {
    [&MAGIC[..], &[133], &time_us.to_le_bytes(), &[0, status], &ms.to_le_bytes(), &week.to_le_bytes(), &[9]].concat()
}

#[test]
fn the_receiver_tells_when_the_first_row_was_taken() {
    let started_s = |says: &[Vec<u8>]| {
        let format = define(133, 3 + 8 + 2 + 4 + 2 + 1, "GPS", "QBBIHB", "TimeUS,I,Status,GMS,GWk,NSats");
        let rows = [1_000_000, 61_000_000].map(|time_us| imu(time_us, 0, 20.0, [0.0; 3], [0.0; 3]));
        let log = [&head()[..], &format, &rows[0], &says.concat(), &rows[1]].concat();
        let started = read(Cursor::new(log), &mut All::default()).unwrap().started?;
        Some(started.duration_since(std::time::SystemTime::UNIX_EPOCH).unwrap().as_secs())
    };
    // 1 March 2026 is the Sunday on which week 2408 begins. Half a minute after the first row it is 14:03:30 UTC, and 18 s
    // later by GPS.
    let ms = 1000 * (14 * 3600 + 3 * 60 + 30 + 18);
    let fix = gps(31_000_000, 3, 2408, ms);
    // `date -u -d 2026-03-01T14:03:00Z +%s`
    assert_eq!(started_s(std::slice::from_ref(&fix)), Some(1_772_373_780));
    // Before a fix the week is 0, or what the receiver's own clock kept.
    let (cold, kept) = (gps(11_000_000, 1, 0, 0), gps(21_000_000, 1, 2300, ms));
    assert_eq!(started_s(&[cold.clone(), kept.clone(), fix]), Some(1_772_373_780));
    assert_eq!(started_s(&[cold, kept, gps(31_000_000, 3, 0, 0), gps(31_000_000, 3, u16::MAX, u32::MAX)]), None);
}
