//! Intervals of a line: joined, in common, and how long they are.

/// From one value to another.
pub type Interval = (f64, f64);

/// From the least to the greatest of some values; from infinity down of none.
pub fn ends(values: impl IntoIterator<Item = f64>) -> Interval {
    values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), own| (least.min(own), most.max(own)))
}

/// Intervals without overlap, in order.
#[must_use]
pub fn joined(mut intervals: Vec<Interval>) -> Vec<Interval> {
    intervals.retain(|(from, to)| from <= to);
    intervals.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut joined: Vec<Interval> = Vec::new();
    for (from, to) in intervals {
        match joined.last_mut() {
            Some(last) if from <= last.1 => last.1 = last.1.max(to),
            _ => joined.push((from, to)),
        }
    }
    joined
}

/// The widest hole between values, and the span of all; `None` of fewer than two.
#[must_use]
pub fn widest_hole(mut values: Vec<f64>) -> Option<(Interval, f64)> {
    values.sort_by(f64::total_cmp);
    let span = values.last()? - values.first()?;
    let hole = values.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    Some(((hole[0], hole[1]), span))
}

/// What two sets of joined intervals have in common.
#[must_use]
pub fn common(a: &[Interval], b: &[Interval]) -> Vec<Interval> {
    let both = |a: &Interval, b: &Interval| (a.0.max(b.0), a.1.min(b.1));
    a.iter().flat_map(|a| b.iter().map(move |b| both(a, b))).filter(|(from, to)| from < to).collect()
}

/// How long intervals without overlap are together.
#[must_use]
pub fn length(intervals: &[Interval]) -> f64 {
    intervals.iter().map(|(from, to)| to - from).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_joined_where_they_touch_and_shared_where_both_are() {
        let one = joined(vec![(5.0, 9.0), (0.0, 2.0), (1.0, 3.0), (3.0, 4.0), (8.0, 7.0)]);
        assert_eq!(one, [(0.0, 4.0), (5.0, 9.0)]);
        let shared = common(&one, &joined(vec![(3.5, 6.0), (8.5, 12.0)]));
        assert_eq!((shared.as_slice(), length(&shared)), (&[(3.5, 4.0), (5.0, 6.0), (8.5, 9.0)][..], 2.0));
    }
}
