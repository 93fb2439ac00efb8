//! A board's temperature reading in degrees C, by the set-up that the calibration was made with.

use zerorate_core::units::{Celsius, Counts};

use super::Calibration;

/// The scale of a board's temperature reading, as its set-up has it: a part's own is some degrees off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CelsiusScale {
    /// The reading at 0 C.
    pub at_zero: Counts,
    /// Counts a degree.
    pub counts_per_celsius: f64,
}

impl CelsiusScale {
    /// A reading in degrees C.
    #[must_use]
    pub fn celsius(self, reading: Counts) -> Celsius {
        Celsius((reading.0 - self.at_zero.0) / self.counts_per_celsius)
    }
}

impl Calibration {
    /// The scale of the temperature reading; `None` where the calibration has no set-up that says so, as that of a log.
    #[must_use]
    pub fn celsius_scale(&self) -> Option<CelsiusScale> {
        let board = self.setup.as_ref()?.get("board")?;
        let number = |name: &str| board.get(name)?.as_f64().filter(|number| number.is_finite());
        let counts_per_celsius = number("counts_per_celsius").filter(|counts| *counts != 0.0)?;
        Some(CelsiusScale { at_zero: Counts(number("counts_at_zero_celsius")?), counts_per_celsius })
    }
}
