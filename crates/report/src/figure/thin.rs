//! Fewer points for the same picture: a figure is a few hundred pixels wide.

/// A point, in the units of the axes.
pub(super) type Point = (f64, f64);

/// Points drawn of one series, at most about.
pub(super) const MOST: usize = 600;

/// Points of a line: of each bin of successive points the first, the lowest and the highest, and the last of all. Peaks
/// survive, and the first of a bin stands for what lies between them. At most about `most`.
pub(super) fn thin(points: &[Point], most: usize) -> Vec<Point> {
    let bins = (most / 3).max(1);
    // A line must end where its data ends.
    let ends = (0..bins).map(|bin| bin * points.len() / bins).chain(points.len().checked_sub(1));
    kept(points, most, bins, ends)
}

/// Points of a cloud: every so manieth, which keeps its look, and of coarser bins the lowest and the highest, so that no
/// outlier is lost. At most about `most`.
pub(super) fn sample(points: &[Point], most: usize) -> Vec<Point> {
    let even = most * 2 / 3;
    kept(points, most, ((most - even) / 2).max(1), (0..even).map(|i| i * points.len() / even))
}

/// The points at some places, with the lowest and the highest of each of so many bins, in their order. Of at most `most`
/// points all are kept.
fn kept(points: &[Point], most: usize, bins: usize, places: impl Iterator<Item = usize>) -> Vec<Point> {
    if points.len() <= most {
        return points.to_vec();
    }
    let by_height = |a: &usize, b: &usize| points[*a].1.total_cmp(&points[*b].1);
    let extremes = (0..bins).flat_map(|bin| {
        let range = bin * points.len() / bins..(bin + 1) * points.len() / bins;
        [range.clone().min_by(by_height), range.max_by(by_height)]
    });
    let mut places: Vec<usize> = places.chain(extremes.flatten()).collect();
    places.sort_unstable();
    places.dedup();
    places.into_iter().map(|place| points[place]).collect()
}

/// The runs of finite points between those that are not.
pub(super) fn runs(points: &[Point]) -> impl Iterator<Item = &[Point]> {
    points.split(|(x, y)| !(x.is_finite() && y.is_finite())).filter(|run| !run.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_peaks(peaks: &[(usize, f64)]) -> Vec<Point> {
        let mut points: Vec<Point> = (0..10_000).map(|i| (f64::from(i), f64::from(i % 7))).collect();
        peaks.iter().for_each(|(place, height)| points[*place].1 = *height);
        points
    }

    #[test]
    fn a_single_peak_among_thousands_of_points_is_kept() {
        let points = with_peaks(&[(6321, 99.0), (17, -99.0)]);
        let kept = thin(&points, 600);
        assert!(kept.len() <= 601);
        assert!(kept.contains(&points[6321]) && kept.contains(&points[17]));
        assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    #[test]
    fn an_outlier_in_a_cloud_is_drawn() {
        let points = with_peaks(&[(4321, 99.0)]);
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
        assert_eq!(runs(&points).collect::<Vec<_>>(), [&points[..1], &points[2..]]);
    }
}
