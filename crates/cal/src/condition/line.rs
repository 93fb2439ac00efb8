//! A line through points.

/// The least-squares line through points at a place, and the rms of the points about it.
pub(super) fn line_at(points: &[(f64, f64)], place: f64) -> (f64, f64) {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / n, y + point.1 / n));
    let (rise, run) = points
        .iter()
        .fold((0.0, 0.0), |(rise, run), point| (rise + (point.0 - x) * (point.1 - y), run + (point.0 - x).powi(2)));
    let slope = rise / run;
    let squares: f64 = points.iter().map(|point| (point.1 - y - slope * (point.0 - x)).powi(2)).sum();
    (y + slope * (place - x), (squares / n).sqrt())
}
