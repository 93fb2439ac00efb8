//! Single rows gathered to batches.

use crate::{Rows, Sink};

/// Rows in a batch.
const BATCH_ROWS: usize = 4096;

/// A jump back in time of more than this starts a new part: less is a disorder of the writer, and such a row is dropped.
const RESTART_S: f64 = 1.0;

/// The rows of one sensor of three axes until they are a batch.
#[derive(Debug)]
pub(crate) struct RowBuffer {
    sensor: usize,
    part: u32,
    first_row: u64,
    /// Added to the log's time, so that parts follow one another.
    offset_s: f64,
    last_s: f64,
    time_s: Vec<f64>,
    temperature: Vec<f64>,
    values: Vec<Vec<f64>>,
    disordered: u64,
}

impl RowBuffer {
    /// An empty buffer of a sensor.
    pub(crate) fn new(sensor: usize) -> Self {
        Self {
            sensor,
            part: 0,
            first_row: 0,
            offset_s: 0.0,
            last_s: f64::NEG_INFINITY,
            time_s: Vec::new(),
            temperature: Vec::new(),
            values: vec![Vec::new(); 3],
            disordered: 0,
        }
    }

    /// Takes in one row. A row a little before the last is dropped and counted; one long before it begins a new part,
    /// whose time follows on.
    pub(crate) fn push(&mut self, time_s: f64, temperature: f64, values: [f64; 3], sink: &mut dyn Sink) {
        let mut time_s = time_s + self.offset_s;
        if time_s < self.last_s {
            if self.last_s - time_s < RESTART_S {
                self.disordered += 1;
                return;
            }
            self.flush(sink);
            self.part += 1;
            self.offset_s += self.last_s - time_s;
            time_s = self.last_s;
        }
        self.last_s = time_s;
        self.time_s.push(time_s);
        self.temperature.push(temperature);
        self.values.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        if self.time_s.len() == BATCH_ROWS {
            self.flush(sink);
        }
    }

    /// Gives what was gathered.
    pub(crate) fn flush(&mut self, sink: &mut dyn Sink) {
        if self.time_s.is_empty() {
            return;
        }
        sink.rows(&Rows {
            sensor: self.sensor,
            part: self.part,
            first_row: self.first_row,
            time_s: &self.time_s,
            temperature: &self.temperature,
            values: &self.values,
        });
        self.first_row += self.time_s.len() as u64;
        self.time_s.clear();
        self.temperature.clear();
        self.values.iter_mut().for_each(Vec::clear);
    }

    /// How often time began anew.
    pub(crate) fn parts(&self) -> u32 {
        self.part
    }

    /// Rows dropped because their time is a little before that of the row above.
    pub(crate) fn disordered(&self) -> u64 {
        self.disordered
    }
}
