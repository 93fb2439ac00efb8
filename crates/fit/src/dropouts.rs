//! Stretches in which a sensor showed something else: its reading jumps away from one row to the next, and jumps back.
//!
//! A part heats over many rows. A reading that goes most of a way from one row to the next, and comes back the same way, is a
//! broken line or a sensor's own word for an error, and no temperature of a part. Where it jumps once and stays, nobody knows
//! which side is true, unless one side is the very beginning or end of a log.

use std::ops::Range;

use crate::folds::FOLDS;
use crate::robust::median;

/// A jump is this many times what the rows around typically change by from one to the next.
const JUMP: f64 = 5.0;

/// Groups on each side from which that is taken.
const NEIGHBOURS: usize = 10;

/// What some successive rows show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// Their mean; NaN of none.
    pub mean: f64,
    /// The least and greatest.
    pub range: (f64, f64),
    /// The largest fall (below 0) and rise from one row to the next; the first row's is from the row before.
    pub leap: (f64, f64),
}

/// The dropouts of an uninterrupted series. A jump is larger than `margin`, which a coarse reading's steps are to stay below,
/// and most of the way to what is shown in between.
#[must_use]
pub fn dropouts(shown: &[Shown], margin: f64) -> Vec<Range<usize>> {
    let sizes: Vec<f64> = shown.iter().map(|shown| shown.leap.1.max(-shown.leap.0)).collect();
    let jump = |place: usize, size: f64| {
        let around = place.saturating_sub(NEIGHBOURS)..(place + NEIGHBOURS + 1).min(sizes.len());
        size > margin && size > JUMP * median(&mut sizes[around].to_vec())
    };
    let is_most = |size: f64, stretch: Range<usize>, from: f64| {
        let far = |shown: &Shown| (shown.range.0 - from).abs().max((shown.range.1 - from).abs());
        shown[stretch].iter().all(|shown| shown.mean.is_nan() || far(shown) < 2.0 * size)
    };
    let mean = |place: usize| shown.get(place).map(|shown| shown.mean).filter(|mean| mean.is_finite());
    let comes_back = |start: usize, end: usize| {
        let Some((before, after)) = start.checked_sub(1).and_then(mean).zip(mean(end + 1)) else { return false };
        let (from, to) = (shown[start].leap, shown[end].leap);
        [(from.1, -to.0), (-from.0, to.1)].into_iter().any(|(away, back)| {
            let size = away.min(back);
            jump(start, size)
                && jump(end, size)
                && is_most(size, start..end + 1, before)
                && 2.0 * (after - before).abs() < size
        })
    };
    // What is longer than a fold is no dropout.
    let longest = shown.len() / FOLDS;
    let mut found = Vec::new();
    let mut start = 0;
    while start < shown.len() {
        let ends = start..(start + longest).min(shown.len());
        let size = sizes[start];
        let end = if !jump(start, size) {
            None
        } else if let Some(end) = ends.into_iter().find(|end| comes_back(start, *end)) {
            found.push(start..end + 1);
            Some(end + 1)
        } else if start < longest.min(NEIGHBOURS)
            && mean(start + 1).is_some_and(|after| is_most(size, 0..start + 1, after))
        {
            found.push(0..start + 1);
            Some(start + 1)
        } else if shown.len() - start <= longest.min(NEIGHBOURS)
            && start.checked_sub(1).and_then(mean).is_some_and(|before| is_most(size, start..shown.len(), before))
        {
            found.push(start..shown.len());
            Some(shown.len())
        } else {
            None
        };
        start = end.unwrap_or(start + 1);
    }
    found
}

/// Where the reading jumps from one row to the next and stays there: either side may be true. The same kind of jump as of a
/// dropout; what is shown before and after it is as far apart.
#[must_use]
pub fn jumps_that_stay(shown: &[Shown], margin: f64) -> Vec<usize> {
    let sizes: Vec<f64> = shown.iter().map(|shown| shown.leap.1.max(-shown.leap.0)).collect();
    // What went away and comes back is a dropout, however near the ramp is to where it goes.
    let comes_back = |place: usize| {
        let (down, up) = shown[place].leap;
        let back = |shown: &Shown| if up > -down { -shown.leap.0 } else { shown.leap.1 };
        let beside = &shown[place.saturating_sub(1)..(place + 2).min(shown.len())];
        beside.iter().any(|shown| 2.0 * back(shown) > up.max(-down))
    };
    let stays = |place: &usize| {
        let around = place.saturating_sub(NEIGHBOURS)..(place + NEIGHBOURS + 1).min(sizes.len());
        let size = sizes[*place];
        let beside =
            place.checked_sub(1).and_then(|before| Some((shown.get(before)?.mean, shown.get(place + 1)?.mean)));
        size > margin
            && size > JUMP * median(&mut sizes[around].to_vec())
            && beside.is_some_and(|(before, after)| 2.0 * (after - before).abs() > size)
            && !comes_back(*place)
    };
    (0..shown.len()).filter(stays).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Groups of twenty rows of a temperature with a noise of two hundredths, as a table made by hand would show them.
    fn of_rows(rows: &[f64]) -> Vec<Shown> {
        let noisy: Vec<f64> =
            rows.iter().zip(0_u32..).map(|(t, row)| t + 1e-3 * f64::from(row * 7919 % 41) - 0.02).collect();
        let of = |(group, own): (usize, &[f64])| {
            let from = (20 * group).saturating_sub(1);
            let leaps = || noisy[from..20 * group + own.len()].windows(2).map(|pair| pair[1] - pair[0]);
            Shown {
                mean: own.iter().sum::<f64>() / own.len() as f64,
                range: own.iter().fold((f64::NAN, f64::NAN), |(a, b), t| (a.min(*t), b.max(*t))),
                leap: leaps().fold((0.0, 0.0), |(a, b): (f64, f64), leap| (a.min(leap), b.max(leap))),
            }
        };
        noisy.chunks(20).enumerate().map(of).collect()
    }

    fn ramp() -> Vec<f64> {
        (0..4000).map(|row| -20.0 + 0.02 * f64::from(row)).collect()
    }

    #[test]
    fn a_reading_that_jumps_away_and_back_is_found_whatever_it_jumps_to() {
        assert_eq!(dropouts(&of_rows(&ramp()), 1.0), []);
        for (rows, expected) in [(1007..1017, 50..51), (1007..1107, 50..56), (1000..1020, 50..52), (1003..1203, 50..61)]
        {
            for shows in [85.0, 40.0, -127.0] {
                let mut rows_of = ramp();
                rows_of[rows.clone()].fill(shows);
                assert_eq!(dropouts(&of_rows(&rows_of), 1.0), std::slice::from_ref(&expected), "{rows:?} at {shows}");
            }
        }
    }

    #[test]
    fn at_the_beginning_and_the_end_of_a_log_it_need_not_come_from_or_go_to_anywhere() {
        let mut rows = ramp();
        rows[..30].fill(85.0);
        rows[3950..].fill(0.0);
        assert_eq!(dropouts(&of_rows(&rows), 1.0), [0..2, 197..200]);
    }

    #[test]
    fn what_heats_and_cools_is_no_dropout_however_fast() {
        // To 60 degrees and back, by a time constant of forty rows; in coarse rows by steps of two degrees.
        let decay = |row: usize, from: f64, to: f64| to + (from - to) * (-(row as f64) / 40.0).exp();
        let fast: Vec<f64> = (0..400)
            .map(|_| 20.0)
            .chain((0..300).map(|row| decay(row, 20.0, 60.0)))
            .chain((0..2000).map(|row| decay(row, 60.0, 20.0)))
            .collect();
        assert_eq!(dropouts(&of_rows(&fast), 1.0), []);
        let stairs: Vec<f64> = (0..4000).map(|row: u32| 2.0 * f64::from(row.min(4000 - row) / 100)).collect();
        assert_eq!(dropouts(&of_rows(&stairs), 4.0), []);
        // It went to another place and stayed: either may be true.
        let steps: Vec<f64> = (0..4000).map(|row| if row < 2000 { 20.0 } else { 60.0 }).collect();
        assert_eq!(dropouts(&of_rows(&steps), 1.0), []);
        assert_eq!(jumps_that_stay(&of_rows(&steps), 1.0), [100]);
        for other in [&fast, &stairs, &ramp()] {
            assert_eq!(jumps_that_stay(&of_rows(other), 4.0), []);
        }
        // It drops to 0 now and then, and the ramp goes through 0.
        let mut dropping: Vec<f64> = (0..400).map(|row: u32| -20.0 + 0.1 * f64::from(row)).collect();
        (0..40).for_each(|group| dropping[10 * group + 3] = 0.0);
        assert_eq!(jumps_that_stay(&of_rows(&dropping), 1.0), []);
    }
}
