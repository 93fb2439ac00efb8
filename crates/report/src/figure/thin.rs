//! Fewer points for the same picture: a figure is a few hundred pixels wide.

/// Points drawn of one series, at most about.
pub(super) const MOST: usize = 600;

/// Of each bin of successive points the first, the lowest and the highest, in their order: peaks survive, and the first
/// stands for what lies between them. Series of at most `most` points are returned as they are.
pub(super) fn thin(points: &[(f64, f64)], most: usize) -> Vec<(f64, f64)> {
    let bins = (most / 3).max(1);
    if points.len() <= most {
        return points.to_vec();
    }
    let mut kept = Vec::with_capacity(most);
    for bin in 0..bins {
        let start = bin * points.len() / bins;
        let end = (bin + 1) * points.len() / bins;
        let by_height = |a: &usize, b: &usize| points[*a].1.total_cmp(&points[*b].1);
        let lowest = (start..end).min_by(by_height).unwrap_or(start);
        let highest = (start..end).max_by(by_height).unwrap_or(start);
        let mut places = [start, lowest, highest];
        places.sort_unstable();
        for (index, place) in places.into_iter().enumerate() {
            if index == 0 || place != places[index - 1] {
                kept.push(points[place]);
            }
        }
    }
    // A line must end where its data ends.
    if let Some(last) = points.last()
        && kept.last() != Some(last)
    {
        kept.push(*last);
    }
    kept
}

/// Points to be drawn as dots: every so manieth, which keeps the look of a cloud, and of coarser bins the lowest and the
/// highest, so that no outlier is lost. At most about `most`.
pub(super) fn sample(points: &[(f64, f64)], most: usize) -> Vec<(f64, f64)> {
    if points.len() <= most {
        return points.to_vec();
    }
    let even = most * 2 / 3;
    let mut places: Vec<usize> = (0..even).map(|i| i * points.len() / even).collect();
    let bins = ((most - even) / 2).max(1);
    for bin in 0..bins {
        let range = bin * points.len() / bins..(bin + 1) * points.len() / bins;
        let by_height = |a: &usize, b: &usize| points[*a].1.total_cmp(&points[*b].1);
        places.extend(range.clone().min_by(by_height));
        places.extend(range.max_by(by_height));
    }
    places.sort_unstable();
    places.dedup();
    places.into_iter().map(|place| points[place]).collect()
}

/// The runs of finite points between those that are not.
pub(super) fn runs(points: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
    let finite = |point: &(f64, f64)| point.0.is_finite() && point.1.is_finite();
    points.split(|point| !finite(point)).filter(|run| !run.is_empty()).map(<[_]>::to_vec).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_peak_among_thousands_of_points_is_kept() {
        let mut points: Vec<(f64, f64)> = (0..10_000).map(|i| (f64::from(i), f64::from(i % 7))).collect();
        points[6321].1 = 99.0;
        points[17].1 = -99.0;
        let kept = thin(&points, 600);
        assert!(kept.len() <= 601);
        assert!(kept.contains(&points[6321]) && kept.contains(&points[17]));
        assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    #[test]
    fn an_outlier_in_a_cloud_is_drawn() {
        let mut points: Vec<(f64, f64)> = (0..10_000).map(|i| (f64::from(i), f64::from(i % 7))).collect();
        points[4321].1 = 99.0;
        let kept = sample(&points, 600);
        assert!(kept.len() <= 600 && kept.contains(&points[4321]));
    }

    #[test]
    fn a_short_series_is_left_alone() {
        let points = [(0.0, 1.0), (1.0, 2.0)];
        assert_eq!(thin(&points, 600), points);
    }

    #[test]
    fn a_hole_parts_a_line() {
        let points = [(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.0), (3.0, 4.0)];
        assert_eq!(runs(&points), [vec![(0.0, 1.0)], vec![(2.0, 3.0), (3.0, 4.0)]]);
    }
}
