//! What is left of each of several logs, by the fit of all and by a fit of the others alone.

use std::ops::Range;

use zerorate_core::drift::ValidRange;

use super::nested::{level, predicted, temperatures, zeroed};
use super::{fit_of_all, predict};
use crate::drift_fit::{DriftFit, LogLeft, finite};
use crate::model::Model;
use crate::predict::{DriftModel, Start};
use crate::residual::ResidualStatistics;
use crate::series::Series;

/// What is left of each of several logs; `made` is the fit of all. Nothing of one log, and where one of them has no rate that was
/// used: then there is no level of it.
pub(super) fn by_log(series: &Series<'_>, made: &DriftFit, asked: Model) -> Vec<LogLeft> {
    let logs = series.logs();
    let is_silent = |log: &Range<usize>| !log.clone().any(|group| series.is_used(group));
    if logs.len() < 2 || logs.iter().any(is_silent) {
        return Vec::new();
    }
    let all = predict(&made.model, Start::Unknown, series, 0..series.rate.len());
    let above = |log: &Range<usize>| level(&all[log.clone()]);
    let mean = logs.iter().map(above).sum::<f64>() / logs.len() as f64;
    let left_by_others = logs.iter().flat_map(|log| left_by_others(series, log, asked)).collect::<Vec<_>>();
    let [uncorrected, by_the_others, by_all] =
        [&predicted(series.rate, &all), &left_by_others, &all].map(|left| zeroed(series, left));
    let of_log = |log: &Range<usize>| {
        let rms = |left: &[f64]| ResidualStatistics::of(left[log.clone()].iter().copied()).rms;
        LogLeft {
            uncorrected: rms(&uncorrected),
            by_the_others: finite(rms(&by_the_others)),
            by_all: rms(&by_all),
            offset: finite(above(log) - mean),
        }
    };
    logs.iter().map(of_log).collect()
}

/// What a fit of the other logs, made as if there were no more, leaves of one as deployed; NaN where they do not settle a model.
fn left_by_others(series: &Series<'_>, log: &Range<usize>, asked: Model) -> Vec<f64> {
    match fit_of_others(series, log, asked) {
        Some(model) => predict(&model, Start::Unknown, series, log.clone()),
        None => vec![f64::NAN; log.len()],
    }
}

fn fit_of_others(series: &Series<'_>, log: &Range<usize>, asked: Model) -> Option<DriftModel> {
    let others = |of: &[f64]| [&of[..log.start], &of[log.end..]].concat();
    let (time_s, temperature, shown) = (others(series.time_s), others(series.temperature), others(series.shown));
    let (rate, weight) = (others(series.rate), others(series.weight));
    let logs = [&series.log[..log.start], &series.log[log.end..]].concat();
    let others = Series {
        time_s: &time_s,
        temperature: &temperature,
        shown: &shown,
        rate: &rate,
        weight: &weight,
        log: &logs,
        next: series.next,
    };
    let (coldest, hottest) = temperatures(&others, |_| true);
    let made = fit_of_all(&others, ValidRange::new(coldest, hottest)?, asked).ok()?;
    Some(made.fit.model)
}
