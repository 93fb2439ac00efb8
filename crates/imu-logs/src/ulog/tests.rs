// Exact binary fractions go in and come out.
#![allow(clippy::float_cmp)]

use super::*;
use crate::Rows;

/// Takes everything.
#[derive(Default)]
struct All {
    sensors: Vec<Sensor>,
    rows: Vec<(usize, u32, f64, f64, [f64; 3])>,
}

impl Sink for All {
    fn sensor(&mut self, sensor: &Sensor) -> bool {
        self.sensors.push(*sensor);
        true
    }

    fn rows(&mut self, rows: &Rows<'_>) {
        for place in 0..rows.temperature.len() {
            let values = [0, 1, 2].map(|axis: usize| rows.values[axis][place]);
            self.rows.push((rows.sensor, rows.part, rows.time_s[place], rows.temperature[place], values));
        }
    }
}

fn take(bytes: &[u8]) -> (All, Vec<Remark>) {
    let mut all = All::default();
    let ending = read(bytes, &mut all).unwrap();
    (all, ending.remarks)
}

const FIELDS: &str = "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;float temperature;uint32_t error_count;uint8_t[3] clip_counter;";

fn message(kind: u8, body: &[u8]) -> Vec<u8> {
    let size = u16::try_from(body.len()).unwrap();
    [&size.to_le_bytes()[..], &[kind], body].concat()
}

/// The header and definitions of two gyros and an accelerometer.
fn head() -> Vec<u8> {
    let mut log = [&MAGIC[..], &[1], &5_u64.to_le_bytes()].concat();
    log.extend(message(b'B', &[0; 40]));
    for name in ["sensor_gyro", "sensor_accel"] {
        log.extend(message(b'F', format!("{name}:{FIELDS}").as_bytes()));
    }
    log.extend(message(b'F', b"nested:sensor_gyro[2] gyros;"));
    for (id, (instance, name)) in (0_u16..).zip([(0_u8, "sensor_gyro"), (1, "sensor_gyro"), (0, "sensor_accel")]) {
        log.extend(message(b'A', &[&[instance], &id.to_le_bytes()[..], name.as_bytes()].concat()));
    }
    log
}

fn row(id: u16, time_us: u64, device: u32, temperature: f32, values: [f32; 3]) -> Vec<u8> {
    let mut body = id.to_le_bytes().to_vec();
    body.extend(time_us.to_le_bytes());
    body.extend(time_us.to_le_bytes());
    body.extend(device.to_le_bytes());
    values.iter().chain([&temperature]).for_each(|value| body.extend(value.to_le_bytes()));
    body.extend([0; 7]);
    message(b'D', &body)
}

#[test]
fn every_instance_is_a_sensor_with_its_number() {
    let mut log = head();
    for k in 0..3_u16 {
        let t = 1_000_000 + 500_000 * u64::from(k);
        log.extend(row(0, t, 2_621_448, 20.0 + f32::from(k), [0.25, -0.5, 1.0]));
        log.extend(row(1, t, 77, 30.0, [0.0; 3]));
        log.extend(row(2, t, 99, f32::NAN, [0.0, 0.0, -9.75]));
        log.extend(message(b'L', b"a log message"));
        log.extend(message(b'Z', b"a kind of the future"));
    }
    let (all, remarks) = take(&log);
    let names: Vec<String> = all.sensors.iter().map(ToString::to_string).collect();
    assert_eq!(names, ["gyro0", "gyro1", "accel0"]);
    assert_eq!(all.sensors[0].device_id, Some(2_621_448));
    assert_eq!(all.rows.len(), 9);
    let first: Vec<_> = all.rows.iter().filter(|row| row.0 == 0).collect();
    assert_eq!(*first[2], (0, 0, 1.0, 22.0, [0.25, -0.5, 1.0]));
    assert!(all.rows.iter().any(|row| row.0 == 2 && row.3.is_nan()));
    assert_eq!(remarks, []);
}

#[test]
fn a_cut_log_gives_what_is_whole_and_says_so() {
    let mut log = head();
    (0..10).for_each(|k| log.extend(row(0, 1000 * k, 1, 20.0, [0.0; 3])));
    for cut in [1, 20, row(0, 0, 1, 0.0, [0.0; 3]).len() - 1] {
        let (all, remarks) = take(&log[..log.len() - cut]);
        assert_eq!(all.rows.len(), 9, "{cut}");
        assert!(matches!(remarks[..], [Remark::Cut { .. }]), "{remarks:?}");
    }
}

#[test]
fn after_damage_the_next_row_of_a_sensor_is_found() {
    let mut log = head();
    (0..5).for_each(|k| log.extend(row(0, 1000 * k, 1, 20.0, [0.0; 3])));
    log.extend([0xee; 37]);
    (5..8).for_each(|k| log.extend(row(0, 1000 * k, 1, 20.0, [0.0; 3])));
    let (all, remarks) = take(&log);
    assert_eq!(all.rows.len(), 8);
    assert_eq!(remarks, [Remark::Damaged { bytes: 37 }]);
}

#[test]
fn a_log_after_a_log_is_another_part_whose_time_follows_on() {
    let mut log = head();
    (0..3).for_each(|k| log.extend(row(0, 2_000_000 * k, 1, 20.0, [0.0; 3])));
    let (all, remarks) = take(&log.repeat(3));
    let parts: Vec<u32> = all.rows.iter().map(|row| row.1).collect();
    assert_eq!(parts, [0, 0, 0, 1, 1, 1, 2, 2, 2]);
    assert!(all.rows.windows(2).all(|pair| pair[1].2 >= pair[0].2));
    assert_eq!((all.sensors.len(), all.rows[8].2), (1, 12.0));
    assert_eq!(remarks, [Remark::SeveralLogs { restarts: 2 }]);
}

#[test]
fn what_is_appended_after_a_crash_is_read_though_the_message_before_it_is_cut() {
    let mut log = head();
    log.extend(row(0, 1000, 1, 20.0, [0.0; 3]));
    let whole = log.len();
    log.extend(&row(0, 2000, 1, 20.0, [0.0; 3])[..20]);
    let appended = log.len() as u64;
    log.extend(row(0, 3000, 1, 20.0, [0.0; 3]));
    let flags = HEADER_BYTES + MESSAGE_HEADER_BYTES;
    log[flags + 8] = DATA_APPENDED;
    log[flags + 16..flags + 24].copy_from_slice(&appended.to_le_bytes());
    let (all, remarks) = take(&log);
    assert!(whole < log.len());
    assert_eq!((all.rows.len(), remarks), (2, vec![]));
}

#[test]
fn messages_shorter_than_their_own_headers_and_formats_of_nonsense_do_no_harm() {
    let mut log = head();
    for kind in b"BFAIMPQDRSOLCZ" {
        log.extend(message(*kind, b""));
        log.extend(message(*kind, b"\x01"));
        log.extend(message(*kind, b"\xff\xff\xff"));
    }
    log.extend(message(b'F', b"sensor_gyro:float[99999999999999999999] x;uint64_t timestamp;"));
    log.extend(message(b'F', b"sensor_gyro:float[18446744073709551615] a;float[9] x;"));
    log.extend(row(0, 1000, 1, 20.0, [0.0; 3]));
    let (all, _) = take(&log);
    assert_eq!(all.rows.len(), 1);
}

/// `date -u -d 2026-03-01T14:03:00Z +%s`
const THREE_PAST_TWO_S: u64 = 1_772_373_780;

/// A log whose first row is at 1 s, and what a receiver says at times of the log, microseconds since 1970.
fn with_receiver(topic: &str, fields: &str, says: &[(u64, u64)]) -> Vec<u8> {
    let mut log = head();
    log.extend(message(b'F', format!("{topic}:{fields}").as_bytes()));
    log.extend(message(b'A', &[&[0], &9_u16.to_le_bytes()[..], topic.as_bytes()].concat()));
    log.extend(row(0, 1_000_000, 1, 20.0, [0.0; 3]));
    for (time_us, utc_us) in says {
        let sample = if fields.contains("timestamp_sample") { &time_us.to_le_bytes()[..] } else { &[] };
        let body = [&9_u16.to_le_bytes(), &time_us.to_le_bytes()[..], sample, &utc_us.to_le_bytes(), &[0; 8]].concat();
        log.extend(message(b'D', &body));
    }
    log.extend(row(0, 61_000_000, 1, 20.0, [0.0; 3]));
    log
}

fn started_s(log: &[u8]) -> Option<u64> {
    let started = read(log, &mut All::default()).unwrap().started?;
    Some(started.duration_since(std::time::SystemTime::UNIX_EPOCH).unwrap().as_secs())
}

#[test]
fn the_receiver_tells_when_the_first_row_was_taken() {
    let old = ("vehicle_gps_position", "uint64_t timestamp;uint64_t time_utc_usec;int32_t lat;int32_t lon;");
    let new =
        ("sensor_gps", "uint64_t timestamp;uint64_t timestamp_sample;uint64_t time_utc_usec;double latitude_deg;");
    // Half a minute after the first row.
    let fix = (31_000_000, (THREE_PAST_TWO_S + 30) * 1_000_000);
    for (topic, fields) in [old, new] {
        let started = |says: &[(u64, u64)]| started_s(&with_receiver(topic, fields, says));
        assert_eq!(started(&[fix]), Some(THREE_PAST_TWO_S));
        // Without a fix it says 0; damage says what no clock can.
        let (cold, damaged) = ((11_000_000, 0), (21_000_000, u64::MAX));
        assert_eq!(started(&[cold, damaged, fix]), Some(THREE_PAST_TWO_S));
        assert_eq!(started(&[cold, damaged]), None);
        assert_eq!(started(&[]), None);
        // Of two logs in one file nobody knows whose it is.
        assert_eq!(started_s(&with_receiver(topic, fields, &[fix]).repeat(2)), None);
    }
}
