//! Logs to fit: a chamber's cycle, and the real one where it is.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A log of two rates, rad/s, two rows a second.
#[derive(Clone)]
pub struct Log {
    pub time_s: Vec<f64>,
    pub temperature_c: Vec<f64>,
    pub rates: Vec<Vec<f64>>,
}

/// The columns' names in the file, as the shared encoder writes them.
const NAMES: [&str; 3] = ["x_rad_s", "y_rad_s", "z_rad_s"];

impl Log {
    /// 70 minutes: cool, heat, cool, as the shared recording. Each rate is a parabola of temperature times its factor,
    /// with uniform noise.
    pub fn cycle() -> Self {
        Self::cycle_of_run(1)
    }

    /// The same unit on another day: its noise is another.
    pub fn cycle_of_run(run: u64) -> Self {
        let rows = 8400;
        let temperature_c: Vec<f64> =
            (0..rows).map(|row| 28.0 + 45.0 * (TAU * 1.2 * f64::from(row) / f64::from(rows) + 1.0).cos()).collect();
        let mut state = run;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            1e-3 * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
        };
        let rates =
            [1.0, -2.0].map(|factor| temperature_c.iter().map(|t| factor * parabola(*t) + noise()).collect()).to_vec();
        Self { time_s: (0..rows).map(|row| 0.5 * f64::from(row)).collect(), temperature_c, rates }
    }

    /// The rows from one to another.
    pub fn rows(&self, range: std::ops::Range<usize>) -> Self {
        Self {
            time_s: self.time_s[range.clone()].to_vec(),
            temperature_c: self.temperature_c[range.clone()].to_vec(),
            rates: self.rates.iter().map(|rate| rate[range.clone()].to_vec()).collect(),
        }
    }

    /// As CSV; what is no number is left empty.
    pub fn csv(&self) -> String {
        let mut text = format!("t_s,temperature_c,{}\n", NAMES[..self.rates.len()].join(","));
        let cell = |value: f64| if value.is_nan() { String::new() } else { value.to_string() };
        for row in 0..self.time_s.len() {
            let rates: Vec<String> = self.rates.iter().map(|rate| cell(rate[row])).collect();
            writeln!(text, "{},{},{}", self.time_s[row], cell(self.temperature_c[row]), rates.join(",")).unwrap();
        }
        text
    }

    /// As a PX4 ULog of one gyro, its third axis half of its first. Time 0 was 14:03 UTC on 1 March 2026, as its receiver says.
    pub fn ulg(&self) -> Vec<u8> {
        self.ulg_of("sensor_gyro")
    }

    /// The same with another topic, whose fields are alike.
    pub fn ulg_of(&self, topic: &str) -> Vec<u8> {
        self.ulg_of_topics(&[(topic, 3)])
    }

    /// The same with several topics, each under its number; 4 is the receiver's.
    pub fn ulg_of_topics(&self, topics: &[(&str, u16)]) -> Vec<u8> {
        let message = |kind: u8, body: &[u8]| {
            let size = u16::try_from(body.len()).unwrap();
            [&size.to_le_bytes()[..], &[kind], body].concat()
        };
        let mut log = [&b"\x55\x4c\x6f\x67\x01\x12\x35\x01"[..], &0_u64.to_le_bytes()].concat();
        log.extend(message(b'B', &[0; 40]));
        let fields = "uint64_t timestamp;uint32_t device_id;float x;float y;float z;float temperature;";
        for (topic, number) in topics {
            log.extend(message(b'F', format!("{topic}:{fields}").as_bytes()));
            log.extend(message(b'A', &[&[0], &number.to_le_bytes()[..], topic.as_bytes()].concat()));
        }
        log.extend(message(b'F', b"sensor_gps:uint64_t timestamp;uint64_t time_utc_usec;"));
        log.extend(message(b'A', &[&[0, 4, 0], &b"sensor_gps"[..]].concat()));
        // `date -u -d 2026-03-01T14:03:00Z +%s`
        let fix = [0_u64, 1_772_373_780_000_000].map(u64::to_le_bytes).concat();
        log.extend(message(b'D', &[&4_u16.to_le_bytes(), &fix[..]].concat()));
        let rows = (0..self.time_s.len()).flat_map(|row| topics.iter().map(move |(_, number)| (row, number)));
        for (row, number) in rows {
            let mut body = number.to_le_bytes().to_vec();
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            body.extend(((self.time_s[row] * 1e6) as u64).to_le_bytes());
            body.extend(2_621_448_u32.to_le_bytes());
            for value in [self.rates[0][row], self.rates[1][row], 0.5 * self.rates[0][row], self.temperature_c[row]] {
                #[allow(clippy::cast_possible_truncation)]
                body.extend((value as f32).to_le_bytes());
            }
            log.extend(message(b'D', &body));
        }
        log
    }

    /// The shared recording; `None`, and it is said, where it is not there.
    pub fn real() -> Option<Self> {
        let path = real_file()?;
        let text = std::fs::read_to_string(path).unwrap();
        // The first row is a start-up outlier.
        let rows: Vec<Vec<f64>> = text
            .lines()
            .skip(2)
            .map(|line| line.split('\t').map(|cell| cell.trim().parse().unwrap()).collect())
            .collect();
        let column = |place: usize| rows.iter().map(|row| row[place]).collect::<Vec<f64>>();
        let first = rows[0][0];
        Some(Self {
            time_s: column(0).iter().map(|time| (time - first) * 1e-6).collect(),
            temperature_c: column(8),
            rates: vec![column(1), column(2), column(3)],
        })
    }
}

/// The drift of the synthetic log's first rate, rad/s.
pub fn parabola(temperature_c: f64) -> f64 {
    0.01 + 3e-4 * temperature_c - 2e-6 * temperature_c * temperature_c
}

/// The shared recording's file; `None`, and it is said, where it is not there.
pub fn real_file() -> Option<PathBuf> {
    let folder = std::env::var_os("ZERORATE_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let path = folder.join("imu-chamber-cycle/imu_raw_data.tsv");
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there (ZERORATE_DATA names the folder of shared data)", path.display());
    None
}
