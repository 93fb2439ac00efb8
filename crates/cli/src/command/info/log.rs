//! What is in a log, and what `zerorate fit` would take its columns for.

use std::path::Path;

use anyhow::{Context, Result};
use serde::Serialize;
use zerorate_cal::table::{Columns, Resolved, ResolvedRate, ResolvedSensor, Table};
use zerorate_cal::units::{RateScale, RateUnit, TimeUnit};

use super::recording::duration;
use crate::screen::{Grid, Page, aligned, thousands};

#[derive(Debug, Serialize)]
pub struct Facts {
    column_names: Vec<String>,
    rows: u64,
    #[serde(flatten)]
    taken_for: TakenFor,
}

/// Whether the columns' names make it plain which is which.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum TakenFor {
    Plain(Plain),
    Unclear { unclear: String },
}

#[derive(Debug, Serialize)]
struct Plain {
    time: Option<Time>,
    #[serde(flatten)]
    sensor: Sensor,
    /// The gyros beside the first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    more_sensors: Vec<Sensor>,
    notes: Vec<String>,
}

/// One gyro, in the units in which it is read.
#[derive(Debug, Serialize)]
struct Sensor {
    temperature: Column,
    temperature_unit: &'static str,
    rates: Vec<Column>,
    rate_unit: RateUnit,
}

#[derive(Debug, Serialize)]
struct Time {
    column: String,
    /// `None` where neither the name nor the log's length tells the unit.
    seconds: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Column {
    column: String,
    min: f64,
    max: f64,
    mean: f64,
    /// Rows without a number.
    missing: u64,
}

/// A column as its rows go by.
#[derive(Debug, Clone, Copy)]
struct Running {
    numbers: u64,
    missing: u64,
    sum: f64,
    min: f64,
    max: f64,
    first: f64,
    last: f64,
}

impl Facts {
    pub fn read(file: &Path) -> Result<Self> {
        let table = Table::open(&file.into())?;
        let column_names = table.names().to_vec();
        let (rows, taken_for) = match Columns::default().resolve(&table) {
            Ok(found) => {
                let (rows, plain) = plain(&table, &found)?;
                (rows, TakenFor::Plain(plain))
            }
            Err(unclear) => (run(&table, &[])?.rows, TakenFor::Unclear { unclear: unclear.to_string() }),
        };
        Ok(Self { column_names, rows, taken_for })
    }

    pub fn show(&self, file: &str, page: &mut Page) {
        let columns = self.column_names.len();
        page.sentence("", &format!("{file}: a log, {} rows of {columns} columns", thousands(self.rows)));
        match &self.taken_for {
            TakenFor::Unclear { unclear } => page.sentence("  - ", &format!("fit is to be told: {unclear}")),
            TakenFor::Plain(plain) => plain.show(page),
        }
    }
}

impl Plain {
    fn show(&self, page: &mut Page) {
        if let Some(time) = &self.time {
            let lasts = time.seconds.map_or_else(|| "in an unknown unit".to_owned(), duration);
            page.facts(&[("time", format!("{}, {lasts}", time.column))]);
        }
        page.gap();
        let mut grid = Grid::new("lllrrrr");
        grid.head(["column", "taken for", "unit", "least", "mean", "most", "missing"]);
        for sensor in std::iter::once(&self.sensor).chain(&self.more_sensors) {
            sensor.show(&mut grid);
        }
        page.grid(&grid);
        if !self.notes.is_empty() {
            page.gap();
            self.notes.iter().for_each(|note| page.sentence("  - ", note));
        }
    }
}

impl Sensor {
    fn show(&self, grid: &mut Grid) {
        let largest: Vec<f64> = self.rates.iter().flat_map(|rate| [rate.min, rate.max]).collect();
        let scale = RateScale::of(self.rate_unit, &largest, None);
        let mut row = |what: &str, unit: &str, column: &Column, values: [f64; 3]| {
            let [min, mean, max] = <[String; 3]>::try_from(aligned(&values)).unwrap_or_default();
            grid.row([&column.column, what, unit, &min, &mean, &max, &thousands(column.missing)]);
        };
        let temperature = &self.temperature;
        row("temperature", self.temperature_unit, temperature, [temperature.min, temperature.mean, temperature.max]);
        for rate in &self.rates {
            row("rate", scale.unit(), rate, [rate.min, rate.mean, rate.max].map(|value| scale.of_rate(value)));
        }
    }
}

fn plain(table: &Table, found: &Resolved) -> Result<(u64, Plain)> {
    let of_sensor = |sensor: &ResolvedSensor| {
        std::iter::once(sensor.temperature).chain(sensor.rates.iter().map(|rate| rate.column)).collect::<Vec<_>>()
    };
    let wanted: Vec<usize> = found.sensors.iter().flat_map(of_sensor).chain(found.time).collect();
    let Looked { rows, columns, cut_line } = run(table, &wanted)?;
    let name = |place: usize| table.names()[place].clone();
    let time = found.time.zip(columns.last()).map(|(place, running)| {
        let duration = running.last - running.first;
        let unit = found.time_unit.or_else(|| TimeUnit::by_duration(duration));
        Time { column: name(place), seconds: unit.map(|unit| duration * unit.seconds()) }
    });
    let mut next = 0;
    let mut sensor = |found: &ResolvedSensor| {
        let own = &columns[next..=next + found.rates.len()];
        next += own.len();
        let rate = |(rate, running): (&ResolvedRate, &Running)| {
            running.column(rate.name.clone(), &|written| written * rate.factor)
        };
        Sensor {
            temperature: own[0].column(name(found.temperature), &|written| found.written_temperature.read(written)),
            temperature_unit: found.written_temperature.unit().name(),
            rates: found.rates.iter().zip(&own[1..]).map(rate).collect(),
            rate_unit: found.rate_unit,
        }
    };
    // A table that was resolved has a sensor at least.
    let (first, more) = found.sensors.split_first().context("no sensor")?;
    let (first, more_sensors) = (sensor(first), more.iter().map(sensor).collect());
    let mut notes = found.notes.clone();
    notes.extend(found.guesses.iter().map(|guess| guess.text.clone()));
    notes.extend(
        cut_line.map(|line| format!("the file ends without a line feed: line {line} may be cut, and was left out")),
    );
    Ok((rows, Plain { time, sensor: first, more_sensors, notes }))
}

/// What one pass found.
struct Looked {
    rows: u64,
    columns: Vec<Running>,
    cut_line: Option<u64>,
}

/// One pass: the number of rows, and each wanted column.
fn run(table: &Table, wanted: &[usize]) -> Result<Looked> {
    let mut looked = Looked { rows: 0, columns: vec![Running::EMPTY; wanted.len()], cut_line: None };
    // Without a column to read, the cells tell the rows.
    let batches = if wanted.is_empty() { table.batches_with_cells(wanted)? } else { table.batches(wanted)? };
    for batch in batches {
        let batch = batch?;
        looked.rows += batch.rows() as u64;
        looked.cut_line = batch.cut_line;
        for (column, values) in looked.columns.iter_mut().zip(&batch.columns) {
            values.iter().for_each(|value| column.push(*value));
        }
    }
    Ok(looked)
}

impl Running {
    const EMPTY: Self =
        Self { numbers: 0, missing: 0, sum: 0.0, min: f64::NAN, max: f64::NAN, first: f64::NAN, last: f64::NAN };

    fn push(&mut self, value: f64) {
        if !value.is_finite() {
            self.missing += 1;
            return;
        }
        if self.numbers == 0 {
            self.first = value;
        }
        self.numbers += 1;
        self.last = value;
        self.sum += value;
        self.min = self.min.min(value);
        self.max = self.max.max(value);
    }

    /// The column in the unit in which it is read.
    fn column(&self, column: String, read: &dyn Fn(f64) -> f64) -> Column {
        let mean = read(self.sum / self.numbers as f64);
        Column { column, min: read(self.min), max: read(self.max), mean, missing: self.missing }
    }
}
