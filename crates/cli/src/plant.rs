//! The simulated plants by name.

use clap::ValueEnum;
use zerorate_bench::plants::PlantKind;

/// A plant by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Plant {
    /// The paper's board: its equation (1), Y with the sign corrected
    Paper,
    /// A board drawn from a population of real drift curves
    Typical,
}

impl Plant {
    /// The bench's plant of this name.
    pub const fn kind(self) -> PlantKind {
        match self {
            Self::Paper => PlantKind::Paper,
            Self::Typical => PlantKind::Typical,
        }
    }
}
