//! A second scale of the x axis, along the top: the same places in another unit.

use super::scale::Scale;

/// Ticks along the top, about: each has its unit behind it.
const ALONG_THE_TOP: f64 = 6.0;

/// How another unit follows from that of the x axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Second {
    /// The unit, as it stands behind a tick's number.
    pub unit: &'static str,
    /// Where it is zero, in the unit of the axis.
    pub zero: f64,
    /// How many units of the axis make one of it.
    pub one: f64,
}

impl Second {
    /// A value of the axis in this unit.
    pub fn of(&self, value: f64) -> f64 {
        (value - self.zero) / self.one
    }

    /// Round numbers of this unit over a range of the axis: where each is on the axis, and its label.
    pub(super) fn ticks(&self, (from, to): (f64, f64)) -> Vec<(f64, String)> {
        let (a, b) = (self.of(from), self.of(to));
        let ticks = Scale::over(Some((a.min(b), a.max(b))), ALONG_THE_TOP).ticks;
        let on_the_axis =
            |(at, label): (f64, String)| (self.zero + self.one * at, format!("{label}\u{a0}{}", self.unit));
        ticks.into_iter().map(on_the_axis).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_degrees_stand_where_their_counts_are() {
        // The paper's: 34 counts a degree, 9860 at none.
        let celsius = Second { unit: "°C", zero: 9860.0, one: 34.0 };
        let ticks = celsius.ticks((8500.0, 11_900.0));
        let labels: Vec<&str> = ticks.iter().map(|(_, label)| label.as_str()).collect();
        assert_eq!(
            labels,
            ["\u{2212}40\u{a0}°C", "\u{2212}20\u{a0}°C", "0\u{a0}°C", "20\u{a0}°C", "40\u{a0}°C", "60\u{a0}°C"]
        );
        assert_eq!((ticks[0].0, ticks[5].0), (8500.0, 11_900.0));
    }
}
