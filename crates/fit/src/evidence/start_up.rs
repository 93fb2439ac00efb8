//! What follows switching on: parts of a rate that die away.

/// Time constants of what a gyro does after it is switched on, seconds, the shortest first, a factor of four apart. To an
/// hour's log the longest is a slow drift.
pub(super) const START_SECONDS: [f64; 3] = [150.0, 600.0, 2400.0];

/// What is left of each part at a time, seconds from the start.
pub(super) fn left(since_s: f64) -> [f64; START_SECONDS.len()] {
    START_SECONDS.map(|constant| libm::exp(-since_s / constant))
}
