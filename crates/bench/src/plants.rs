//! The plants that the simulated bench offers by name.

use zerorate_sim::{ChamberParameters, Plant, PlantParameters};

use crate::setup::SetUp;

/// A plant by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlantKind {
    /// The paper's board: eq. (1) for the drift, Y with the corrected sign.
    Paper,
    /// A board drawn from the population of real drift curves.
    Typical,
}

impl PlantKind {
    /// `paper` or `typical`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Typical => "typical",
        }
    }

    /// A unit of this plant, everything in it drawn from a seed.
    #[must_use]
    pub fn build(self, seed: u64) -> Plant {
        let parameters = match self {
            Self::Paper => PlantParameters::paper(),
            Self::Typical => PlantParameters::typical(seed),
        };
        Plant::new(parameters, seed)
    }

    /// How fast the air of its chamber goes to a set point, kelvins a minute: it has no ramp of its own to be set.
    #[must_use]
    pub fn chamber_k_per_min(self) -> f64 {
        ChamberParameters::default().heating_k_per_min
    }

    /// The set-up that goes with it.
    #[must_use]
    pub fn setup(self) -> SetUp {
        match self {
            Self::Paper => SetUp::paper(),
            Self::Typical => SetUp::typical(),
        }
    }
}

#[cfg(test)]
mod tests {
    use zerorate_core::units::{Celsius, Seconds};

    use super::*;

    #[test]
    fn a_plants_chamber_goes_as_fast_as_is_told_of_it() {
        for kind in [PlantKind::Paper, PlantKind::Typical] {
            for to in [60.0, -40.0] {
                let mut plant = kind.build(7);
                let from = plant.chamber_air();
                plant.chamber_set_point(Celsius(to)).unwrap();
                plant.wait(Seconds(600.0));
                let went = (plant.chamber_air() - from).0.abs() / 10.0;
                // Its regulation's ripple is a tenth of a kelvin.
                assert!((went - kind.chamber_k_per_min()).abs() < 0.03, "{kind:?} to {to} C: {went} K/min");
            }
        }
    }
}
