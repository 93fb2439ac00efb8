//! A series of fewer, longer groups, on which candidates are compared.

use std::ops::Range;

use crate::series::Series;

/// Groups that candidates are compared on, at most: neighbours of a longer record are averaged for the comparison, so
/// that it takes as long whatever the record. Eight folds of fifty groups still keep heating and cooling apart.
const CHOICE_GROUPS: usize = 400;

/// A series of fewer, longer groups.
pub(super) struct Thinned {
    /// The groups of the series in each of these.
    parts: Vec<Range<usize>>,
    time_s: Vec<f64>,
    temperature: Vec<f64>,
    rate: Vec<f64>,
    weight: Vec<f64>,
    log: Vec<u32>,
    drifts_in_time: bool,
}

impl Thinned {
    pub(super) fn of(series: &Series<'_>) -> Self {
        let groups = series.rate.len();
        let factor = groups.div_ceil(CHOICE_GROUPS).max(1);
        let mut thinned = Self {
            parts: Vec::new(),
            time_s: Vec::new(),
            temperature: Vec::new(),
            rate: Vec::new(),
            weight: Vec::new(),
            log: Vec::new(),
            drifts_in_time: series.drifts_in_time,
        };
        let mut start = 0;
        while start < groups {
            // No average is of two logs.
            let log = series.log[start..].iter().take(factor).take_while(|log| **log == series.log[start]).count();
            let part = start..start + log;
            let mean = |values: &[f64]| {
                let finite = part.clone().map(|group| values[group]).filter(|value| value.is_finite());
                let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
                sum / count
            };
            let used = part.clone().filter(|&group| series.is_used(group));
            let (sum, weight) = used.fold((0.0, 0.0), |(sum, weight), group| {
                (sum + series.weight[group] * series.rate[group], weight + series.weight[group])
            });
            thinned.time_s.push(mean(series.time_s));
            thinned.temperature.push(mean(series.temperature));
            thinned.rate.push(sum / weight);
            thinned.weight.push(weight / factor as f64);
            thinned.log.push(series.log[start]);
            start = part.end;
            thinned.parts.push(part);
        }
        thinned
    }

    /// Whether one of these holds any of some groups of the series.
    pub(super) fn holds_any(&self, place: usize, groups: &Range<usize>) -> bool {
        let part = &self.parts[place];
        part.start < groups.end && groups.start < part.end
    }

    pub(super) fn series(&self) -> Series<'_> {
        Series {
            time_s: &self.time_s,
            temperature: &self.temperature,
            rate: &self.rate,
            weight: &self.weight,
            log: &self.log,
            drifts_in_time: self.drifts_in_time,
        }
    }
}
