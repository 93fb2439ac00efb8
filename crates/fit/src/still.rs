//! An axis that reads one number and no other: a gyro that is dead, unplugged, or stuck.

/// Below so many rows one number may come by chance.
const LEAST_ROWS: u64 = 64;

/// An axis is stuck if it reads one number in so much of the log while the temperature goes over as much of its span: a gyro
/// that rests within its own resolution does so in a soak, and not on a ramp.
const SHARE: f64 = 1.0 / 8.0;

/// Rows in which an axis read one number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Still {
    /// The number.
    pub rate: f64,
    /// The first row of the log, and the first one after the last.
    pub rows: (u64, u64),
    /// How many of them have the number; between them may be some that have none.
    count: u64,
    /// The times of the first and the last of them, seconds; NaN without a time column.
    pub time_s: (f64, f64),
    /// The least and the greatest temperature.
    pub temperature: (f64, f64),
}

/// Looks for it while rows go by.
#[derive(Debug, Clone, Default)]
pub struct Stillness {
    now: Option<Still>,
    /// Those of [`LEAST_ROWS`] over which the temperature went furthest.
    longest: Option<Still>,
    rows: u64,
    temperature: Option<(f64, f64)>,
}

impl Stillness {
    /// Takes in a row: its number, what it reads, and its temperature and time.
    pub fn push(&mut self, row: u64, rate: f64, temperature: f64, time_s: f64) {
        self.rows += 1;
        let one = (temperature, temperature);
        self.temperature = Some(widened(self.temperature.unwrap_or(one), temperature));
        match &mut self.now {
            Some(now) if now.rate.to_bits() == rate.to_bits() => {
                now.rows.1 = row + 1;
                now.count += 1;
                now.time_s.1 = time_s;
                now.temperature = widened(now.temperature, temperature);
            }
            now => {
                let first = Still { rate, rows: (row, row + 1), count: 1, time_s: (time_s, time_s), temperature: one };
                self.longest = longer(self.longest, now.replace(first));
            }
        }
    }

    /// Where the axis was stuck, if it was.
    #[must_use]
    pub fn found(&self) -> Option<Still> {
        let longest = longer(self.longest, self.now)?;
        let long = longest.count >= LEAST_ROWS && longest.count as f64 >= SHARE * self.rows as f64;
        (long && longest.span() >= SHARE * length(self.temperature?)).then_some(longest)
    }
}

impl Still {
    /// Counts rows and times from the first of several logs.
    pub fn come_after(&mut self, rows: u64, seconds: f64) {
        self.rows = (self.rows.0 + rows, self.rows.1 + rows);
        self.time_s = (self.time_s.0 + seconds, self.time_s.1 + seconds);
    }

    fn span(&self) -> f64 {
        length(self.temperature)
    }
}

fn longer(one: Option<Still>, other: Option<Still>) -> Option<Still> {
    let long = |still: &Still| still.count >= LEAST_ROWS;
    one.into_iter().chain(other).filter(long).max_by(|a, b| a.span().total_cmp(&b.span()))
}

fn widened((least, most): (f64, f64), value: f64) -> (f64, f64) {
    (least.min(value), most.max(value))
}

fn length((least, most): (f64, f64)) -> f64 {
    most - least
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp from 0 to 50 degrees in 1000 rows.
    fn found(rate: impl Fn(u32) -> f64) -> Option<Still> {
        let mut stillness = Stillness::default();
        (0..1000).for_each(|row| stillness.push(row.into(), rate(row), 0.05 * f64::from(row), f64::from(row)));
        stillness.found()
    }

    #[test]
    fn an_axis_that_is_stuck_for_an_eighth_of_the_ramp_is_found() {
        let noisy = |row: u32| f64::from(row * 7919 % 100);
        assert_eq!(found(noisy), None);
        assert_eq!(found(|_| 0.0).unwrap().rows, (0, 1000));
        let half = found(|row| if row < 500 { noisy(row) } else { 0.125 }).unwrap();
        assert_eq!((half.rows, half.time_s, half.rate.to_bits()), ((500, 1000), (500.0, 999.0), 0.125_f64.to_bits()));
        assert_eq!(found(|row| if (300..400).contains(&row) { 3.0 } else { noisy(row) }), None);
        // A coarse gyro has steps of its own.
        assert_eq!(found(|row| f64::from(row / 100)), None);
    }

    #[test]
    fn rows_without_a_number_are_numbered_and_not_counted() {
        // 1000 rows of a ramp; in the first half every other rate is missing, in the second all are one.
        let mut stillness = Stillness::default();
        for row in (0..1000_u32).filter(|row| *row >= 500 || !row.is_multiple_of(2)) {
            let rate = if row < 500 { f64::from(row * 7919 % 100) } else { 0.125 };
            stillness.push(row.into(), rate, 0.05 * f64::from(row), f64::from(row));
        }
        let found = stillness.found().unwrap();
        assert_eq!((found.rows, found.count), ((500, 1000), 500));
    }

    #[test]
    fn a_gyro_that_rests_within_its_resolution_in_a_soak_is_not_stuck() {
        let mut stillness = Stillness::default();
        (0..1000_u32).for_each(|row| {
            let soak = row > 400;
            let rate = if soak { 1.0 } else { f64::from(row % 3) };
            stillness.push(row.into(), rate, 0.05 * f64::from(row.min(400)), f64::from(row));
        });
        assert_eq!(stillness.found(), None);
    }
}
