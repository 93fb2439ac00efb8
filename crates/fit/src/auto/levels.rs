//! The levels of several logs beside one curve: a sensor's rate differs from one time it is switched on to another.

use std::collections::BTreeMap;

use crate::series::Series;

/// A log tells its level against the others' where it shares at least this part of its temperatures with one of them; of
/// one that lies apart, level and slope between the two cannot be told apart.
const SHARED: f64 = 0.25;

/// The logs whose level is free. Together they are of no level: the curve's is their mean.
pub(super) struct Levels(Vec<u32>);

impl Levels {
    /// Of the groups that are used.
    pub fn of(series: &Series<'_>, used: &[usize]) -> Self {
        let mut spans: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
        for &group in used {
            let temperature = series.temperature[group];
            let (min, max) = spans.entry(series.log[group]).or_insert((temperature, temperature));
            (*min, *max) = (min.min(temperature), max.max(temperature));
        }
        let shares = |log: &u32, (min, max): (f64, f64)| {
            let mut others = spans.iter().filter(|(other, _)| *other != log);
            others.any(|(_, other)| max.min(other.1) - min.max(other.0) >= SHARED * (max - min))
        };
        let free: Vec<u32> = spans.iter().filter(|(log, span)| shares(log, **span)).map(|(log, _)| *log).collect();
        Self(if free.len() < 2 { Vec::new() } else { free })
    }

    /// What a group of a log has in the columns, one fewer than there are free logs.
    pub fn columns(&self, log: u32) -> impl Iterator<Item = f64> {
        let (last, others) = self.0.split_last().map_or((None, &[][..]), |(last, others)| (Some(*last), others));
        others.iter().map(move |other| match () {
            () if *other == log => 1.0,
            () if last == Some(log) => -1.0,
            () => 0.0,
        })
    }
}
