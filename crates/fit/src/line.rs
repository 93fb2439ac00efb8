//! The least-squares line through points.

/// A line, and how well its points settle it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// The points' mean, through which it goes.
    centre: (f64, f64),
    slope: f64,
    points: f64,
    /// The sum of the squares of their first coordinates about the mean.
    run: f64,
}

impl Line {
    /// Through some points; level where they stand above one another.
    #[must_use]
    pub fn through(points: &[(f64, f64)]) -> Self {
        let count = points.len() as f64;
        let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
        let run: f64 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
        let rise: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
        Self { centre: (x, y), slope: if run > 0.0 { rise / run } else { 0.0 }, points: count, run }
    }

    /// It at a place.
    #[must_use]
    pub fn at(&self, place: f64) -> f64 {
        self.centre.1 + self.slope * (place - self.centre.0)
    }

    /// How steep it is.
    #[must_use]
    pub fn slope(&self) -> f64 {
        self.slope
    }

    /// The mean of its points' places.
    #[must_use]
    pub fn centre(&self) -> f64 {
        self.centre.0
    }

    /// How far a point is above it.
    #[must_use]
    pub fn off(&self, point: (f64, f64)) -> f64 {
        point.1 - self.centre.1 - self.slope * (point.0 - self.centre.0)
    }

    /// The rms of its points about it.
    #[must_use]
    pub fn rms(&self, points: &[(f64, f64)]) -> f64 {
        (points.iter().map(|point| self.off(*point).powi(2)).sum::<f64>() / self.points).sqrt()
    }

    /// Its variance at a place, in that of a point: `1 / n + (x - mean)^2 / Sxx`.
    #[must_use]
    pub fn leverage(&self, place: f64) -> f64 {
        let far = if self.run > 0.0 { (place - self.centre.0).powi(2) / self.run } else { 0.0 };
        1.0 / self.points + far
    }

    /// Its standard error at a place, by how far its points are from it: of n - 2 degrees of freedom.
    #[must_use]
    pub fn error(&self, points: &[(f64, f64)], place: f64) -> f64 {
        self.rms(points) * (self.points / (self.points - 2.0) * self.leverage(place)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lines_error_is_numpys() {
        // p, c = numpy.polyfit([0, 1, 2, 3, 4], [0.1, 0.9, 2.2, 2.8, 4.1], 1, cov=True); x = numpy.array([5.5, 1])
        // numpy.polyval(p, 5.5), numpy.sqrt(x @ c @ x)
        let points = [(0.0, 0.1), (1.0, 0.9), (2.0, 2.2), (3.0, 2.8), (4.0, 4.1)];
        let line = Line::through(&points);
        let (at, error) = (line.at(5.5), line.error(&points, 5.5));
        assert!((at - 5.485000000).abs() < 1e-9 && (error - 0.225444006).abs() < 1e-9, "{at} {error}");
    }

    #[test]
    fn points_above_one_another_make_a_level_line() {
        let line = Line::through(&[(3.0, 1.0), (3.0, 5.0)]);
        assert!((line.at(100.0) - 3.0).abs() < 1e-12 && (line.leverage(100.0) - 0.5).abs() < 1e-12);
    }
}
