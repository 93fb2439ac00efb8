//! Rows as they come, less the spikes that a fit leaves out.

use zerorate_cal::condition::{GROUP_S, MAX_GROUP_ROWS, MIN_GROUP_ROWS, TEMPERATURE_SPIKE, least_step};
use zerorate_cal::units::TemperatureUnit;
use zerorate_fit::spikes::{outliers_beyond_steps, outliers_off_the_way};

/// One row, and on which of its axes another rate stands in for a spike.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    pub time_s: f64,
    pub temperature: f64,
    pub values: Vec<f64>,
    pub left_out: Vec<bool>,
}

/// Rows that wait until they are enough to tell a spike among them.
#[derive(Debug)]
pub(crate) struct Waiting {
    rows: Vec<Row>,
    temperature_margin: f64,
    /// For each axis the least change from one rate to another, and the last rate.
    steps: Vec<(f64, f64)>,
}

impl Waiting {
    pub fn new(axes: usize, unit: TemperatureUnit) -> Self {
        let temperature_margin = TEMPERATURE_SPIKE * unit.min_span();
        Self { rows: Vec::new(), temperature_margin, steps: vec![(f64::INFINITY, f64::NAN); axes] }
    }

    /// Takes in a row; gives those of a group, once there are two. The last of a record are then a whole group too.
    pub fn push(&mut self, time_s: f64, temperature: f64, values: Vec<f64>) -> Vec<Row> {
        for ((step, last), value) in self.steps.iter_mut().zip(&values) {
            least_step(&[*value], step, last);
        }
        let left_out = vec![false; values.len()];
        self.rows.push(Row { time_s, temperature, values, left_out });
        let lasts_s = time_s - self.rows[0].time_s;
        // Without times the rows alone tell.
        let rows = self.rows.len() as u64;
        let is_two = rows >= 2 * MIN_GROUP_ROWS && (lasts_s >= 2.0 * GROUP_S || lasts_s.is_nan());
        if is_two || rows >= MAX_GROUP_ROWS {
            let second = self.rows.split_off(self.rows.len() / 2);
            return self.without_spikes(second);
        }
        Vec::new()
    }

    /// The least change from one rate of an axis to another.
    pub fn step(&self, axis: usize) -> f64 {
        self.steps[axis].0
    }

    /// All that are left: before a gap, and at the end.
    pub fn finish(&mut self) -> Vec<Row> {
        self.without_spikes(Vec::new())
    }

    /// The rows that wait, each spike replaced; `next` wait from now on.
    fn without_spikes(&mut self, next: Vec<Row>) -> Vec<Row> {
        let mut rows = std::mem::replace(&mut self.rows, next);
        let temperatures: Vec<f64> = rows.iter().map(|row| row.temperature).collect();
        let spikes = outliers_off_the_way(&temperatures, self.temperature_margin);
        for (place, other) in stand_ins(&temperatures, &spikes, 0) {
            rows[place].temperature = temperatures[other];
        }
        for (axis, (step, _)) in self.steps.iter().enumerate() {
            let rates: Vec<f64> = rows.iter().map(|row| row.values[axis]).collect();
            let spikes = outliers_beyond_steps(&rates, *step);
            let kept = spikes.iter().filter(|spike| !**spike).count();
            // From half a group away: the rates beside it have their own part in the same averages, and a mean of them has less
            // noise than a row.
            for (place, other) in stand_ins(&rates, &spikes, kept / 2) {
                rows[place].values[axis] = rates[other];
                rows[place].left_out[axis] = true;
            }
        }
        rows
    }
}

/// For each spike the kept value that stands in for it: `further` than the next.
fn stand_ins(values: &[f64], spikes: &[bool], further: usize) -> Vec<(usize, usize)> {
    let kept: Vec<usize> = (0..values.len()).filter(|i| values[*i].is_finite() && !spikes[*i]).collect();
    let of = |i: usize| (i, kept[(kept.partition_point(|kept| *kept < i) + further) % kept.len()]);
    if kept.is_empty() { Vec::new() } else { (0..values.len()).filter(|i| spikes[*i]).map(of).collect() }
}
