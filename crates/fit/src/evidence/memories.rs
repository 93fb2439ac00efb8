//! What may be remembered of a series' temperatures, and where each memory is.

use nalgebra::DMatrix;
use zerorate_core::drift::{Drift, History, HistoryState, Memory, Polynomial, Scale, Shape, Term, ValidRange};

use super::start_up;
use crate::series::Series;

/// Half-widths of the plays as shares of the span of temperature: the smallest still stands clear of a sensor's noise, the
/// largest is known once the temperature has gone over six tenths of the span.
const PLAY_SHARES: [f64; 3] = [0.03, 0.1, 0.3];

/// Time constants of the lags, seconds, the shortest first, a factor of four apart: a package against its board, a board in
/// its box, a box in its room.
const LAG_SECONDS: [f64; 3] = [30.0, 120.0, 480.0];

/// A lag is told from all else where this much of what it adds, root mean square, is something else. Of the shortest it is 0.54 and
/// more between soaks; along ramps 0.1, and 0.4 where the temperature comes in coarse steps.
const TOLD: f64 = 0.5;

/// As much of a longer one, beside the shortest.
const TOLD_BESIDE: f64 = 0.25;

/// Memories, plays first, and their `m - T`.
#[derive(Debug, Clone)]
pub(super) struct Memories {
    pub which: Vec<Memory>,
    /// A row a memory, a column a group, in the temperature's unit.
    pub ahead: DMatrix<f64>,
}

impl Memories {
    /// The ones that can be told of a series whose used rates span `measured`, the curve believed over `valid`: plays where it went
    /// both ways; lags there too, and where it moved and stood in turn, those that can be told of it.
    pub(super) fn of(series: &Series<'_>, measured: ValidRange, valid: ValidRange) -> Self {
        let span = measured.max() - measured.min();
        let of = |which: Vec<Memory>| Self { ahead: ahead(series, valid, &which), which };
        let plays = || PLAY_SHARES.map(|share| Memory::Play { half_width: share * span });
        let lags = LAG_SECONDS.map(|time_constant_s| Memory::Lag { time_constant_s });
        let timed = series.time_s.iter().all(|time| time.is_finite());
        match (series.goes_both_ways(), timed) {
            (true, true) => return of([plays(), lags].concat()),
            (true, false) => return of(plays().to_vec()),
            (false, true) => {}
            (false, false) => return of(Vec::new()),
        }
        let all = of(lags.to_vec());
        let told = all.told(series, measured);
        let is_any = told.first().is_some_and(|shortest| *shortest >= TOLD);
        let kept: Vec<usize> = (0..told.len()).filter(|&lag| is_any && told[lag] > TOLD_BESIDE).collect();
        Self { which: kept.iter().map(|&lag| lags[lag]).collect(), ahead: all.ahead.select_rows(&kept) }
    }

    /// How much of what each memory adds is told from the curve and from what follows switching on, root mean square, 0 to 1. Along a
    /// steady ramp a lag is a level that begins like a start-up, and where a box warms by itself it is a slope; where the temperature
    /// goes from soak to soak it comes and goes at each.
    fn told(&self, series: &Series<'_>, measured: ValidRange) -> Vec<f64> {
        let Some(scale) = Scale::spanning(measured.min(), measured.max()) else { return Vec::new() };
        let used: Vec<usize> = (0..series.rate.len()).filter(|&group| series.is_used(group)).collect();
        let mut began = f64::NAN;
        let others: Vec<Vec<f64>> = (used.iter().enumerate())
            .map(|(place, &group)| {
                if place == 0 || series.log[group] != series.log[used[place - 1]] {
                    began = series.time_s[group];
                }
                let x = scale.x(series.temperature[group]);
                let curve = [1.0, x, x * x, x * x * x];
                [&curve[..], &start_up::left(series.time_s[group] - began)].concat()
            })
            .collect();
        let Some(width) = others.first().map(Vec::len) else { return Vec::new() };
        let others = DMatrix::from_fn(used.len(), width, |row, column| others[row][column]);
        let adds = self.ahead.select_columns(&used).transpose();
        let Ok(fitted) = others.clone().svd(true, true).solve(&adds, f64::EPSILON) else { return Vec::new() };
        let left = &adds - others * fitted;
        left.column_iter().zip(adds.column_iter()).map(|(left, adds)| left.norm() / adds.norm()).collect()
    }
}

/// Each memory's `m - T` at each group, anew with each log, as a device has it whose curve is believed over `valid`.
fn ahead(series: &Series<'_>, valid: ValidRange, which: &[Memory]) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(which.len(), series.rate.len());
    // A history whose weights are all nothing, for its memories alone.
    let share = 1.0 / which.len() as f64;
    let terms: Vec<Term> = which.iter().map(|&memory| Term { memory, weight: 0.0, behind: 0.0, share }).collect();
    let flat = Scale::spanning(valid.min(), valid.max())
        .and_then(|scale| Polynomial::new(scale, &[0.0, 0.0]))
        .map(Shape::Polynomial);
    let history = flat.clone().and_then(|shape| History::new(shape, &terms));
    let Some((history, shape)) = history.zip(flat) else { return all };
    let drift = Drift { shape, valid };
    let (mut state, mut before) = (HistoryState::default(), f64::NAN);
    for (group, (&time, &temperature)) in series.time_s.iter().zip(series.temperature).enumerate() {
        if series.begins(group) {
            state = HistoryState::default();
        }
        history.advance(&drift, &mut state, temperature, time - before);
        before = time;
        all.column_mut(group).copy_from_slice(&history.ahead(&state)[..which.len()]);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::NextRun;

    /// What is told of an hour and a half of a board that follows its air by 60 s.
    fn told(air: impl Fn(f64) -> f64, step: f64) -> Vec<Memory> {
        let mut board = air(0.0);
        let follow = |group: u32| {
            let air = air(f64::from(10 * group));
            board += (air - board) * (1.0 - (-10.0_f64 / 60.0).exp());
            (board / step).round() * step
        };
        let temperature: Vec<f64> = (0..540).map(follow).collect();
        let time_s: Vec<f64> = (0..540).map(|group| 10.0 * f64::from(group)).collect();
        let (rate, weight, log) = (vec![0.0; 540], vec![1.0; 540], vec![0; 540]);
        let series = Series {
            time_s: &time_s,
            temperature: &temperature,
            shown: &temperature,
            rate: &rate,
            weight: &weight,
            log: &log,
            next: NextRun::Another,
        };
        let range = |min, max| ValidRange::new(min, max).unwrap();
        Memories::of(&series, range(-20.0, 50.0), range(-28.0, 58.0)).which
    }

    #[test]
    fn lags_are_told_between_soaks_and_not_along_a_ramp() {
        let ramp = |t: f64| -20.0 + 70.0 * t / 5400.0;
        let by_itself = |t: f64| 50.0 - 70.0 * (-t / 1350.0).exp();
        for step in [0.01, 0.5] {
            assert!(told(ramp, step).is_empty() && told(by_itself, step).is_empty(), "steps of {step}");
        }
        for soaks in [4.0, 8.0, 12.0] {
            let soaked = told(|t| -20.0 + 70.0 * (t / 5400.0 * soaks).floor() / (soaks - 1.0), 0.01);
            assert!(!soaked.is_empty() && soaked.iter().all(|memory| matches!(memory, Memory::Lag { .. })), "{soaks}");
        }
        assert_eq!(told(|t| 50.0 - 70.0 * (t / 2700.0 - 1.0).abs(), 0.01).len(), 6, "there and back");
    }
}
