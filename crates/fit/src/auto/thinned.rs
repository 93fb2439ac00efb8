//! A series of fewer, longer groups, on which candidates are compared.

use crate::series::Series;

/// Groups that candidates are compared on, at most: neighbours of a longer record are averaged for the comparison, so
/// that it takes as long whatever the record. Eight folds of fifty groups still keep heating and cooling apart.
const CHOICE_GROUPS: usize = 400;

/// A series of fewer, longer groups.
pub(super) struct Thinned {
    /// Groups of the series in one of these.
    pub factor: usize,
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
            factor,
            time_s: Vec::new(),
            temperature: Vec::new(),
            rate: Vec::new(),
            weight: Vec::new(),
            log: Vec::new(),
            drifts_in_time: series.drifts_in_time,
        };
        for start in (0..groups).step_by(factor) {
            let part = start..(start + factor).min(groups);
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
        }
        thinned
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
