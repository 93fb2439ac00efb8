//! The rows that a fit sees: groups, and of a long record averages of neighbours.

use nalgebra::DMatrix;

use super::columns::Columns;
use crate::robust::{MAD_TO_SIGMA, median};
use crate::series::Series;

/// Rows of a fit, at most: of a longer record neighbours are averaged, so that a fit takes as long whatever the record.
const ROWS: usize = 400;

/// Without times groups are taken to be this far apart, seconds.
const GROUP_S: f64 = 10.0;

/// No row's noise is taken for more than this many times the usual variance, however few samples it has.
const MOST_VARIANCE: f64 = 20.0;

/// The rows of a fit, in order of time.
pub(super) struct Averages {
    /// A column of the matrix a row of the fit: the columns' values, and the rate less `level` over `spread`.
    pub rows: DMatrix<f64>,
    pub time_s: Vec<f64>,
    /// Of the white noise, against that of the usual row.
    pub variance: Vec<f64>,
    /// Whether it is the first of a log.
    pub begins: Vec<bool>,
    /// How soon after the start of a log one was, at the soonest, seconds.
    pub soonest_s: f64,
    pub level: f64,
    pub spread: f64,
}

impl Averages {
    /// The averages of the used groups that `keep` keeps. `None` of fewer than three.
    pub(super) fn new(series: &Series<'_>, columns: &Columns, keep: impl Fn(usize) -> bool) -> Option<Self> {
        let groups = series.rate.len();
        let factor = groups.div_ceil(ROWS).max(1);
        let used: Vec<usize> = (0..groups).filter(|&group| series.is_used(group) && keep(group)).collect();
        // No average is of two logs.
        let parts: Vec<&[usize]> =
            used.chunk_by(|&a, &b| a / factor == b / factor && series.log[a] == series.log[b]).collect();
        if parts.len() < 3 {
            return None;
        }
        let width = columns.kinds.len();
        let mut rows = DMatrix::zeros(width + 1, parts.len());
        let (mut time_s, mut weights, mut begins) = (Vec::new(), Vec::new(), Vec::new());
        for (place, part) in parts.iter().enumerate() {
            let weight: f64 = part.iter().map(|&group| series.weight[group]).sum();
            let mut row = rows.column_mut(place);
            let mut mean_time = 0.0;
            for &group in *part {
                let share = series.weight[group] / weight;
                row.rows_mut(0, width).axpy(share, &columns.rows.column(group), 1.0);
                row[width] += share * series.rate[group];
                let time = series.time_s[group];
                mean_time += share * if time.is_finite() { time } else { GROUP_S * group as f64 };
            }
            time_s.push(mean_time);
            weights.push(weight);
            begins.push(place == 0 || series.log[part[0]] != series.log[parts[place - 1][0]]);
        }
        let usual = median(&mut weights.clone());
        let variance = weights.iter().map(|weight| (usual / weight).min(MOST_VARIANCE)).collect();
        let rates = rows.row(width).transpose();
        let level = rates.mean();
        let spread = rates.variance().sqrt().max(f64::MIN_POSITIVE);
        rows.row_mut(width).iter_mut().for_each(|rate| *rate = (*rate - level) / spread);
        let logs = series.logs();
        let since_start = |(part, time): (&&[usize], &f64)| {
            let log = logs.iter().find(|log| log.contains(&part[0]))?;
            Some(time - series.time_s[log.start])
        };
        let soonest_s = parts.iter().zip(&time_s).filter_map(since_start).fold(f64::INFINITY, f64::min);
        let mut averages = Self { rows, time_s, variance, begins, soonest_s, level, spread };
        averages.leave_spikes_out();
        Some(averages)
    }

    /// Gives rows next to no weight that stand out from the median of their neighbours: one alone would be taken for the
    /// noise of all.
    fn leave_spikes_out(&mut self) {
        /// Neighbours to either side.
        const REACH: usize = 6;
        /// Standard deviations from their median: of normal noise none in a lifetime.
        const FAR: f64 = 8.0;
        /// What a spike's variance is multiplied by.
        const NOTHING: f64 = 1e6;
        let rates: Vec<f64> = self.rows.row(self.rows.nrows() - 1).iter().copied().collect();
        let off: Vec<f64> = (0..rates.len())
            .map(|place| {
                let near = place.saturating_sub(REACH)..(place + REACH + 1).min(rates.len());
                (rates[place] - median(&mut rates[near].to_vec())).abs()
            })
            .collect();
        let usual = MAD_TO_SIGMA * median(&mut off.clone());
        for (_, variance) in off.iter().zip(&mut self.variance).filter(|(off, _)| **off > FAR * usual + f64::EPSILON) {
            *variance *= NOTHING;
        }
    }
}
