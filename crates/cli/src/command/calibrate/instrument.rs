//! Who obeys at the bench.

use clap::ValueEnum;

/// An instrument by who obeys.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Instrument {
    /// The simulated bench's
    Simulated,
    /// A person, told what to do
    Manual,
}
