//! Cells of a column that were filled with 0 where there was no reading: by a logger that asks more often than its sensor answers,
//! or by whoever closed holes. Between readings that are none of it, 0 is far more common than a number comes again by chance.

/// The fewest runs of zeros of which it can be said.
const LEAST_RUNS: u64 = 20;

/// Their share of all rows, at least.
const LEAST_SHARE: f64 = 0.005;

/// And so many times the share of rows that have the number of the row before: as common a number is of a coarse converter.
const REPEATS: f64 = 5.0;

/// Looks for it while rows go by.
#[derive(Debug, Clone, Default)]
pub struct Filled {
    rows: u64,
    /// Runs of zeros with other numbers on both sides, and the zeros in them.
    runs: u64,
    zeros: u64,
    /// Zeros since the last other number.
    open: u64,
    last: Option<f64>,
    repeats: u64,
}

impl Filled {
    /// Takes in the next number; what is none says nothing.
    pub fn push(&mut self, value: f64) {
        if !value.is_finite() {
            return;
        }
        self.rows += 1;
        if value.abs() <= 0.0 {
            self.open += 1;
            return;
        }
        if self.open > 0 && self.last.is_some() {
            (self.runs, self.zeros) = (self.runs + 1, self.zeros + self.open);
        }
        self.open = 0;
        let is_repeated = self.last.replace(value).is_some_and(|last| last.to_bits() == value.to_bits());
        self.repeats += u64::from(is_repeated);
    }

    /// How many zeros were filled in; `None` where they may be readings.
    #[must_use]
    pub fn found(&self) -> Option<u64> {
        let (runs, rows) = (self.runs as f64, self.rows as f64);
        let readings = (self.rows - self.zeros).max(1) as f64;
        let chance = LEAST_SHARE + REPEATS * self.repeats as f64 / readings;
        (self.runs >= LEAST_RUNS && runs > chance * rows).then_some(self.zeros)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mixed::mixed;

    fn found(values: impl Iterator<Item = f64>) -> Option<u64> {
        let mut filled = Filled::default();
        values.for_each(|value| filled.push(value));
        filled.found()
    }

    /// Uniform noise of -1 to 1, in steps.
    fn noise(step: f64) -> impl Fn(u64) -> f64 {
        move |row| ((2.0 * (mixed(row) >> 11) as f64 / (1_u64 << 53) as f64 - 1.0) / step).round() * step
    }

    #[test]
    fn zeros_between_readings_are_filled_in_at_any_pace() {
        let noise = noise(1e-6);
        for every in [2, 3, 10, 50] {
            let told = found((0..6000).map(|row| if row % every == 1 { 0.0 } else { noise(row) }));
            assert!(told.is_some_and(|told| told.abs_diff(6000 / every) <= 1), "{every}: {told:?}");
        }
        // Some in succession, and minus nothing.
        assert_eq!(found((0..6000).map(|row| if row % 20 < 5 { -0.0 } else { 1.0 + noise(row) })), Some(1495));
    }

    #[test]
    fn a_coarse_converters_zeros_and_those_of_a_sensor_that_stopped_are_readings() {
        for step in [0.01, 0.1, 0.3, 0.7, 1.0] {
            assert_eq!(found((0..6000).map(noise(step))), None, "{step}");
        }
        let noise = noise(1e-6);
        assert_eq!(found((0..6000).map(|row| if (2000..5000).contains(&row) { 0.0 } else { noise(row) })), None);
        assert_eq!(found((0..6000).map(|_| 0.0)), None);
        // What holds a reading until the next.
        assert_eq!(found((0..6000).map(|row| if row % 50 == 1 { 0.0 } else { noise(row / 2) })), None);
    }
}
