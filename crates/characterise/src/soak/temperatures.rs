//! What a log's temperatures say of its soaks.

use std::collections::VecDeque;

/// The temperature is averaged over so many samples before a bias is taken from it, so that its noise does not become the
/// rate's.
const SMOOTHED: usize = 21;

pub(super) fn extremes(values: &[f64]) -> [f64; 2] {
    let finite = values.iter().filter(|value| value.is_finite());
    finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[min, max], value| [min.min(*value), max.max(*value)])
}

/// Means over some neighbours, of those that are numbers; none where there is none.
pub(super) fn smoothed(values: &[f64]) -> Vec<f64> {
    let half = SMOOTHED / 2;
    let (mut sums, mut counts) = (vec![0.0], vec![0_u32]);
    for value in values {
        let finite = value.is_finite();
        sums.push(sums[sums.len() - 1] + if finite { *value } else { 0.0 });
        counts.push(counts[counts.len() - 1] + u32::from(finite));
    }
    let mean = |place: usize| {
        let (from, to) = (place.saturating_sub(half), (place + half + 1).min(values.len()));
        (sums[to] - sums[from]) / f64::from(counts[to] - counts[from])
    };
    (0..values.len()).map(mean).collect()
}

/// How often temperatures go by as much as `span`.
pub(super) fn crossings(temperatures: &[f64], span: f64) -> usize {
    let mut finite = temperatures.iter().copied().filter(|temperature| temperature.is_finite());
    let Some(mut mark) = finite.next() else { return 0 };
    finite
        .filter(|now| {
            let crosses = (now - mark).abs() >= span;
            mark = if crosses { *now } else { mark };
            crosses
        })
        .count()
}

/// The longest run of places whose temperatures stay within `most` of each other: the first, and the one after the last.
pub(super) fn longest_soak(temperatures: &[f64], most: f64) -> (usize, usize) {
    let (mut lows, mut highs): (VecDeque<usize>, VecDeque<usize>) = (VecDeque::new(), VecDeque::new());
    let (mut from, mut best) = (0, (0, 0));
    for (place, now) in temperatures.iter().enumerate().filter(|(_, now)| now.is_finite()) {
        while lows.back().is_some_and(|last| temperatures[*last] >= *now) {
            lows.pop_back();
        }
        while highs.back().is_some_and(|last| temperatures[*last] <= *now) {
            highs.pop_back();
        }
        lows.push_back(place);
        highs.push_back(place);
        while let (Some(low), Some(high)) = (lows.front().copied(), highs.front().copied()) {
            if temperatures[high] - temperatures[low] <= most {
                break;
            }
            // The earlier of the two is what has to go.
            from = low.min(high) + 1;
            lows.retain(|kept| *kept >= from);
            highs.retain(|kept| *kept >= from);
        }
        if place + 1 - from > best.1 - best.0 {
            best = (from, place + 1);
        }
    }
    best
}
