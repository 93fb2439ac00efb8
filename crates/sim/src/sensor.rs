//! The gyro's temperature output, on its package, as the board amplifies it for the A/D.

use crate::gyro::ROOM_C;

/// The temperature channel's constants, after its amplifier.
///
/// The paper does not give its temperature scale; 34 counts a degree and 8500 counts at -40 C make its equations drift
/// by as much as its figures show (docs/paper.md). At 250 uV a count that is 8.5 mV/K and 2.6775 V at 25 C, close to what
/// such a gyro gives by itself (ADXRS620: 9 mV/K, 2.5 V at 25 C).
#[derive(Debug, Clone, PartialEq)]
pub struct SensorParameters {
    /// Volts at 25 C. Default 2.6775: 10 710 counts.
    pub room_v: f64,
    /// Volts per kelvin. Default 8.5e-3: 34 counts.
    pub slope_v_per_k: f64,
    /// White noise of a sample in volts rms, its low-pass included. Default 750e-6: 3 counts (assumed).
    pub noise_v: f64,
}

impl Default for SensorParameters {
    fn default() -> Self {
        Self { room_v: 2.6775, slope_v_per_k: 8.5e-3, noise_v: 750e-6 }
    }
}

impl SensorParameters {
    /// The noise-free voltage at a package temperature.
    pub(crate) fn volts(&self, package_c: f64) -> f64 {
        self.room_v + self.slope_v_per_k * (package_c - ROOM_C)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paper_s_range_reads_8500_to_11900_counts() {
        let counts = |package_c| SensorParameters::default().volts(package_c) / 250e-6;
        assert!((counts(-40.0) - 8500.0).abs() < 1e-6 && (counts(60.0) - 11_900.0).abs() < 1e-6);
    }
}
