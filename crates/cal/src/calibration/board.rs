//! What a calibration says of the board that it was made on.

use serde::{Deserialize, Serialize};
use zerorate_core::board::BoardNumbers;

/// A board's converter and temperature sensors, in the terms of its set-up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BoardScale {
    /// Bits of the converter.
    pub converter_bits: u32,
    /// Counts of the temperature reading a kelvin.
    pub counts_per_kelvin: f64,
    /// Noise of one sample of it, counts rms.
    pub temperature_noise_counts: f64,
}

impl BoardScale {
    /// As a device record has it; `None` where it makes no sense.
    #[must_use]
    pub fn numbers(&self) -> Option<BoardNumbers> {
        BoardNumbers::new(self.converter_bits, self.counts_per_kelvin, self.temperature_noise_counts)
    }
}
