//! What is in an autopilot's log.

use std::path::Path;

use anyhow::Result;
use serde::Serialize;
use zerorate_cal::log::{LogFile, Rows, Sensor, Sink, Stream};
use zerorate_cal::quality::Reason;
use zerorate_cal::table::Columns;

use super::recording::duration;
use crate::screen::{Grid, Page, aligned, thousands};

#[derive(Debug, Serialize)]
pub struct Facts {
    format: &'static str,
    sensors: Vec<Found>,
    notes: Vec<String>,
    reasons: Vec<Reason>,
}

#[derive(Debug, Serialize)]
struct Found {
    #[serde(flatten)]
    sensor: Option<Sensor>,
    rows: u64,
    without_temperature: u64,
    least_temperature_c: Option<f64>,
    greatest_temperature_c: Option<f64>,
    seconds: f64,
    #[serde(skip)]
    first_s: f64,
}

/// Looks at all sensors as they go by.
#[derive(Default)]
struct Look(Vec<Found>);

impl Sink for Look {
    fn stream(&mut self, stream: &Stream) -> bool {
        self.0.push(Found {
            sensor: stream.sensor,
            rows: 0,
            without_temperature: 0,
            least_temperature_c: None,
            greatest_temperature_c: None,
            seconds: 0.0,
            first_s: f64::NAN,
        });
        true
    }

    fn rows(&mut self, rows: &Rows<'_>) {
        let Some(found) = self.0.get_mut(rows.sensor) else { return };
        found.rows += rows.temperature.len() as u64;
        for temperature in rows.temperature {
            if !temperature.is_finite() {
                found.without_temperature += 1;
                continue;
            }
            found.least_temperature_c =
                Some(found.least_temperature_c.map_or(*temperature, |least| least.min(*temperature)));
            found.greatest_temperature_c =
                Some(found.greatest_temperature_c.map_or(*temperature, |greatest| greatest.max(*temperature)));
        }
        if let (Some(first), Some(last)) = (rows.time_s.first(), rows.time_s.last()) {
            found.first_s = if found.first_s.is_nan() { *first } else { found.first_s };
            found.seconds = last - found.first_s;
        }
    }
}

impl Facts {
    /// The facts, if the first bytes are those of an autopilot's log.
    pub fn read(file: &Path, start: &[u8]) -> Result<Option<Self>> {
        let Some(format) = imu_logs::recognise(start) else { return Ok(None) };
        let mut look = Look::default();
        let ending = LogFile::open(&file.into(), &Columns::default())?.read(&mut look)?;
        Ok(Some(Self { format: format.name(), sensors: look.0, notes: ending.notes, reasons: ending.reasons }))
    }

    pub fn show(&self, file: &str, page: &mut Page) {
        let lasts = self.sensors.iter().map(|found| found.seconds).fold(0.0, f64::max);
        page.sentence("", &format!("{file}: {}, {}", self.format, duration(lasts)));
        if self.sensors.is_empty() {
            page.sentence("  - ", "no gyro and no accelerometer in it: switch on the logging of raw sensors");
        } else {
            page.gap();
            let column = |of: fn(&Found) -> Option<f64>| {
                aligned(&self.sensors.iter().map(|found| of(found).unwrap_or(f64::NAN)).collect::<Vec<_>>())
            };
            let (least, greatest) =
                (column(|found| found.least_temperature_c), column(|found| found.greatest_temperature_c));
            let mut grid = Grid::new("lrrrrrr");
            grid.head(["sensor", "device id", "rows", "a second", "from C", "to C", "without T"]);
            for (place, found) in self.sensors.iter().enumerate() {
                let id = found.sensor.and_then(|sensor| sensor.device_id);
                grid.row([
                    found.sensor.map_or_else(String::new, |sensor| sensor.to_string()),
                    id.map_or_else(|| "-".to_owned(), |id| id.to_string()),
                    thousands(found.rows),
                    if found.seconds > 0.0 {
                        format!("{:.1}", found.rows as f64 / found.seconds)
                    } else {
                        "-".to_owned()
                    },
                    least[place].clone(),
                    greatest[place].clone(),
                    thousands(found.without_temperature),
                ]);
            }
            page.grid(&grid);
        }
        if !self.notes.is_empty() || !self.reasons.is_empty() {
            page.gap();
        }
        self.reasons.iter().for_each(|reason| page.sentence("  - ", &reason.text));
        self.notes.iter().for_each(|note| page.sentence("  - ", note));
    }
}
