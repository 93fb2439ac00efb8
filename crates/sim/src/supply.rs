//! The fine supply that stands in for the gyros in the trim experiment (paper, 2.3).

use crate::random::{Source, Stream};

/// The supply's constants: a six-digit calibrator's (assumed).
#[derive(Debug, Clone, PartialEq)]
pub struct SupplyParameters {
    /// The finest step that can be set, in volts. Default 10e-6: 0.06 count on the paper's board.
    pub resolution_v: f64,
    /// Noise at the A/D's input in volts rms. Default 20e-6.
    pub noise_v: f64,
    /// Standard deviation of a supply's own constant offset in volts. Default 50e-6.
    pub offset_spread_v: f64,
}

impl Default for SupplyParameters {
    fn default() -> Self {
        Self { resolution_v: 10e-6, noise_v: 20e-6, offset_spread_v: 50e-6 }
    }
}

/// One supply.
#[derive(Debug, Clone)]
pub(crate) struct Supply {
    parameters: SupplyParameters,
    offset_v: f64,
}

impl Supply {
    pub(crate) fn new(parameters: SupplyParameters, seed: u64) -> Self {
        let offset_v = parameters.offset_spread_v * Stream::of_board(seed, Source::SupplyOffset).normal();
        Self { parameters, offset_v }
    }

    /// What stands at the terminals when `asked_v` is set.
    pub(crate) fn output_v(&self, asked_v: f64) -> f64 {
        let step_v = self.parameters.resolution_v;
        (asked_v / step_v).round() * step_v + self.offset_v
    }

    pub(crate) fn noise_v(&self) -> f64 {
        self.parameters.noise_v
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_supply_gives_what_is_asked_to_its_resolution_plus_a_constant() {
        let supply = Supply::new(SupplyParameters::default(), 1);
        let offset_v = supply.output_v(2.5) - 2.5;
        assert!(offset_v.abs() < 250e-6);
        assert!((supply.output_v(2.500_014) - 2.500_01 - offset_v).abs() < 1e-12);
    }
}
