//! Groups in which an axis that has noise reads one number: its sensor had stopped, or was at the end of its range.

use super::group::all_of;
use super::{DropReason, Excluded, Group, Tally};
use zerorate_fit::robust::median;

/// Rows of which it is no chance that all are alike, where noise is a step and more: less than one in a thousand million.
const LEAST_ROWS: u32 = 20;

/// Beside such groups lie some in which only part of the rows read it: at the end of a range noise is cut off on one side, and
/// of half of it six tenths of the scatter are left.
const CUT_OFF: f64 = 0.8;

/// So little of a step is the rounding of a mean of equal numbers.
const ROUNDING: f64 = 1e-3;

/// Where an axis read one number.
#[derive(Debug, Clone, PartialEq)]
pub struct Stopped {
    /// The axis, by its place among the rate columns.
    pub axis: usize,
    /// The number, rate units.
    pub rate: f64,
    /// Which end of all rates that were read it is, if any.
    pub end: Option<End>,
    /// Where.
    pub interval: Excluded,
}

/// An end of all rates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// No rate is below it.
    Least,
    /// No rate is above it.
    Greatest,
}

/// Leaves out the groups of an axis in which it reads one number, and those beside them that read it in part. `rate_step` is the
/// least change from one rate to another. Of an axis without noise of a step nothing is known: it may rest within its resolution.
pub fn leave_out_stopped(groups: &mut [Group], tally: &mut Tally, axis: usize, rate_step: f64) -> Vec<Stopped> {
    let kept = |group: &Group| group.axes[axis].rows > 0;
    let mut scatters: Vec<f64> = groups
        .iter()
        .filter(|group| kept(group))
        .map(|group| group.axes[axis].scatter)
        .filter(|s| s.is_finite())
        .collect();
    // Groups that were stopped are the fewer, or it would be an axis that is stuck.
    let typical = median(&mut scatters);
    if typical.is_nan() || typical < rate_step {
        return Vec::new();
    }
    let rates = || groups.iter().filter(|group| kept(group)).map(|group| group.axes[axis].rate);
    let (least, greatest) = (rates().fold(f64::INFINITY, f64::min), rates().fold(f64::NEG_INFINITY, f64::max));
    let is_stopped = |group: &Group| {
        let part = &group.axes[axis];
        part.rows >= LEAST_ROWS && part.scatter <= ROUNDING * rate_step
    };
    let is_cut_off = |group: &Group| kept(group) && group.axes[axis].scatter < CUT_OFF * typical;
    let mut found: Vec<Stopped> = Vec::new();
    let mut place = 0;
    while place < groups.len() {
        if !is_stopped(&groups[place]) {
            place += 1;
            continue;
        }
        let (log, rate) = (groups[place].log, groups[place].axes[axis].rate);
        let goes_on = |group: &&Group| group.log == log && is_cut_off(group);
        let from = place - groups[..place].iter().rev().take_while(goes_on).count();
        let to = place + groups[place..].iter().take_while(goes_on).count();
        let run = &groups[from..to];
        let end = match rate {
            rate if rate - least <= rate_step => Some(End::Least),
            rate if greatest - rate <= rate_step => Some(End::Greatest),
            _ => None,
        };
        let interval = Excluded {
            reason: DropReason::StoppedRate,
            rows: (run[0].first_row, run[run.len() - 1].end_row),
            time_s: (run[0].times_s.0, run[run.len() - 1].times_s.1),
            temperature: run.iter().map(|group| group.temperatures).reduce(all_of).unwrap_or((f64::NAN, f64::NAN)),
        };
        // A mean of equal numbers is that number but for its last digits.
        let rate = format!("{rate:.8e}").parse().unwrap_or(rate);
        found.push(Stopped { axis, rate, end, interval });
        for part in groups[from..to].iter_mut().map(|group| &mut group.axes[axis]) {
            tally.add(DropReason::StoppedRate, u64::from(part.rows));
            (part.rows, part.weight) = (0, 0.0);
        }
        place = to;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::Length;
    use super::super::group::Grouping;
    use super::*;
    use crate::log::Rows;
    use crate::units::TemperatureUnit;

    /// A ramp of an hour at 10 Hz, noise of 0.01 in steps of 0.001, its reading as `shown` makes it of the rate.
    fn found(shown: impl Fn(f64, f64) -> f64) -> (Vec<Stopped>, Vec<Group>, Tally) {
        let mut state = 3_u32;
        let mut uniform = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        let times: Vec<f64> = (0..36_000).map(|row| 0.1 * f64::from(row)).collect();
        let temperature: Vec<f64> = times.iter().map(|time| time / 60.0).collect();
        let rates: Vec<f64> = times
            .iter()
            .map(|time| {
                let noise = 0.01 * (0..12).map(|_| uniform()).sum::<f64>();
                (1000.0 * shown(*time, 0.5 * time / 3600.0 + noise)).round() / 1000.0
            })
            .collect();
        let mut grouping = Grouping::new(1, Length::Rows { rows: 100, step_s: 0.1 }, TemperatureUnit::C, 0);
        let values = [rates];
        grouping.push_rows(&Rows {
            sensor: 0,
            part: 0,
            first_row: 0,
            time_s: &times,
            temperature: &temperature,
            values: &values,
        });
        let step = grouping.rate_steps()[0];
        let (mut groups, mut tallies) = grouping.finish();
        let found = leave_out_stopped(&mut groups, &mut tallies[0], 0, step);
        (found, groups, tallies.remove(0))
    }

    /// The rate is above 0.4 from 2880 s on; noise carries it there some 200 s before.
    #[test]
    fn a_rate_at_the_end_of_its_range_is_left_out_and_named() {
        let (found, groups, tally) = found(|_, rate| rate.min(0.4));
        let [stopped] = &found[..] else { panic!("{found:?}") };
        assert_eq!((stopped.rate, stopped.end), (0.4, Some(End::Greatest)));
        assert!((2750.0..2920.0).contains(&stopped.interval.time_s.0), "{:?}", stopped.interval);
        assert!(tally.count(DropReason::StoppedRate) > 6_000);
        // What is left is of the line, to a hundredth of the noise and a half.
        let kept = groups.iter().filter(|group| group.axes[0].rows > 0);
        let worst = kept.map(|group| (group.axes[0].rate - 0.5 * group.time_s / 3600.0).abs()).fold(0.0, f64::max);
        assert!(worst < 0.005, "{worst}");
    }

    #[test]
    fn a_rate_that_stood_still_for_a_while_is_left_out_and_one_that_did_not_is_kept() {
        let (stood, _, _) = found(|time, rate| if (1000.0..1200.0).contains(&time) { 0.14 } else { rate });
        let [stopped] = &stood[..] else { panic!("{stood:?}") };
        assert_eq!((stopped.rate, stopped.end), (0.14, None));
        let (from, to) = stopped.interval.time_s;
        assert!((980.0..=1000.0).contains(&from) && (1199.0..1220.0).contains(&to), "{from} to {to}");
        assert_eq!(found(|_, rate| rate).0, []);
        // In steps that are larger than its noise it may well read one number.
        assert_eq!(found(|_, rate| (20.0 * rate).round() / 20.0).0, []);
    }
}
