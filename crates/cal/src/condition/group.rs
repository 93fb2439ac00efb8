//! Rows averaged to groups, without those that are no drift.

use super::robust::{centre_and_sigma, median};
use super::{DropReason, Tally};
use crate::quality::TemperatureUnit;

/// The time a group should take: long against noise, short against a thermal time constant.
const GROUP_S: f64 = 10.0;

/// Rows in a group, at least, where the log is long enough: below it a median absolute deviation means little.
const MIN_GROUP_ROWS: u64 = 21;

/// Groups in a log, at least: a short log has shorter groups instead.
const MIN_GROUPS: u64 = 64;

/// Groups in a log, at most, so that memory stays bounded: a long log has longer groups instead.
const MAX_GROUPS: u64 = 20_000;

/// A row further than this many standard deviations from its group's median is a spike.
const SPIKE_SIGMA: f64 = 8.0;

/// Fewer values than this are not searched for spikes.
const MIN_SEARCHED: usize = 7;

/// More than this share of a group are no spikes: the group itself is disturbed, and `level` sees its scatter.
const MAX_SPIKES: f64 = 0.2;

/// A temperature spike is also further than this share of the least span from the median: 1 C.
const TEMPERATURE_SPIKE: f64 = 0.1;

/// One axis's part of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisGroup {
    /// Mean rate of the rows kept; NaN without any.
    pub rate: f64,
    /// Standard deviation of the rows kept; NaN for fewer than two.
    pub scatter: f64,
    /// Rows kept.
    pub rows: u32,
}

/// Some successive rows, averaged.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The first row, from 0.
    pub first_row: u64,
    /// The row after the last.
    pub end_row: u64,
    /// Mean time, seconds from the log's first row; NaN without a time column.
    pub time_s: f64,
    /// Mean temperature of the rows kept, in the column's unit; NaN without any.
    pub temperature: f64,
    /// One part a rate column.
    pub axes: Vec<AxisGroup>,
}

/// Rows in a group for a log of so many rows; `step_s` is the mean time between them, NaN if not known.
#[must_use]
// A count of rows far below 2^53, and above zero.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub fn group_rows(rows: u64, step_s: f64) -> u64 {
    let by_time = if step_s > 0.0 { (GROUP_S / step_s).ceil() as u64 } else { 0 };
    by_time.max(MIN_GROUP_ROWS).min(rows / MIN_GROUPS).max(rows.div_ceil(MAX_GROUPS)).max(1)
}

/// Gathers rows into groups.
#[derive(Debug, Clone)]
pub struct Grouping {
    rows: u64,
    /// A temperature further than this from its neighbours may be a spike.
    temperature_margin: f64,
    first_row: u64,
    times: Vec<f64>,
    temperatures: Vec<f64>,
    rates: Vec<Vec<f64>>,
    groups: Vec<Group>,
    tallies: Vec<Tally>,
}

impl Grouping {
    /// An empty grouping of `axes` rates into groups of `rows` rows ([`group_rows`]).
    #[must_use]
    pub fn new(axes: usize, rows: u64, unit: TemperatureUnit) -> Self {
        Self {
            rows,
            temperature_margin: TEMPERATURE_SPIKE * unit.min_span(),
            first_row: 0,
            times: Vec::new(),
            temperatures: Vec::new(),
            rates: vec![Vec::new(); axes],
            groups: Vec::new(),
            tallies: vec![Tally::default(); axes],
        }
    }

    /// Takes in one row: time in seconds from the log's first row (NaN if not known), temperature, and a rate an axis.
    pub fn push(&mut self, time_s: f64, temperature: f64, rates: impl Iterator<Item = f64>) {
        self.times.push(time_s);
        self.temperatures.push(temperature);
        self.rates.iter_mut().zip(rates).for_each(|(column, rate)| column.push(rate));
        if self.temperatures.len() as u64 == self.rows {
            self.close();
        }
    }

    /// The groups, and for each axis the count of rows left out. A last group shorter than half is joined to none: it
    /// is kept as it is.
    #[must_use]
    pub fn finish(mut self) -> (Vec<Group>, Vec<Tally>) {
        if !self.temperatures.is_empty() {
            self.close();
        }
        (self.groups, self.tallies)
    }

    fn close(&mut self) {
        let rows = self.temperatures.len();
        let missing = self.temperatures.iter().filter(|t| !t.is_finite()).count();
        let wild = outliers(&self.temperatures, self.temperature_margin);
        let usable: Vec<bool> = (0..rows).map(|row| self.temperatures[row].is_finite() && !wild[row]).collect();
        let mut axes = Vec::with_capacity(self.rates.len());
        for (column, tally) in self.rates.iter().zip(&mut self.tallies) {
            tally.add(DropReason::MissingTemperature, missing as u64);
            tally.add(DropReason::TemperatureSpike, wild.iter().filter(|wild| **wild).count() as u64);
            let rates: Vec<f64> =
                column.iter().zip(&usable).map(|(rate, usable)| if *usable { *rate } else { f64::NAN }).collect();
            let missing_rates = column.iter().zip(&usable).filter(|(rate, usable)| **usable && !rate.is_finite());
            tally.add(DropReason::MissingRate, missing_rates.count() as u64);
            let spikes = outliers(&rates, 0.0);
            let found = spikes.iter().filter(|spike| **spike).count();
            let leading = if self.first_row == 0 { spikes.iter().take_while(|spike| **spike).count() } else { 0 };
            tally.add(DropReason::StartUp, leading as u64);
            tally.add(DropReason::Spike, (found - leading) as u64);
            let kept = rates.iter().zip(&spikes).filter(|(rate, spike)| rate.is_finite() && !**spike);
            axes.push(average(kept.map(|(rate, _)| *rate)));
        }
        let kept = self.temperatures.iter().zip(&usable).filter(|(_, usable)| **usable);
        self.groups.push(Group {
            first_row: self.first_row,
            end_row: self.first_row + rows as u64,
            time_s: mean(self.times.iter().copied().filter(|time| time.is_finite())),
            temperature: mean(kept.map(|(temperature, _)| *temperature)),
            axes,
        });
        self.first_row += rows as u64;
        self.times.clear();
        self.temperatures.clear();
        self.rates.iter_mut().for_each(Vec::clear);
    }
}

/// Which finite values are far from the others' median, and further than `margin`; none when they are many, for then
/// they are no exceptions.
fn outliers(values: &[f64], margin: f64) -> Vec<bool> {
    let mut outliers = vec![false; values.len()];
    let finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    if finite.len() < MIN_SEARCHED {
        return outliers;
    }
    let (centre, sigma) = centre_and_sigma(&finite);
    let limit = (SPIKE_SIGMA * sigma).max(margin);
    for (outlier, value) in outliers.iter_mut().zip(values) {
        *outlier = (value - centre).abs() > limit;
    }
    let found = outliers.iter().filter(|outlier| **outlier).count();
    if found as f64 > MAX_SPIKES * finite.len() as f64 {
        outliers.fill(false);
    }
    outliers
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count)
}

fn average(rates: impl Iterator<Item = f64> + Clone) -> AxisGroup {
    let rate = mean(rates.clone());
    let (squares, rows) = rates.fold((0.0, 0_u32), |(sum, rows), value| (sum + (value - rate).powi(2), rows + 1));
    AxisGroup { rate, scatter: (squares / (f64::from(rows) - 1.0)).sqrt(), rows }
}

/// The typical scatter of an axis over all groups; NaN where groups are too small to have one.
pub(super) fn typical_scatter(groups: &[Group], axis: usize) -> f64 {
    let mut scatters: Vec<f64> = groups
        .iter()
        .map(|group| group.axes[axis])
        .filter(|part| part.rows as usize >= MIN_SEARCHED)
        .map(|part| part.scatter)
        .collect();
    median(&mut scatters)
}
