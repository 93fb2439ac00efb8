//! `zerorate lot simulate`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use zerorate_lot::simulate::{Simulation, TRUTH};

use super::{Outcome, bar};

/// Write a lot to try: recordings of random typical units, some of them bad, and the truth about which
///
/// Bad units have stuck sensors, cut runs, another unit's serial, or outliers. Group sums only, with 20 samples a
/// group: a unit takes a fiftieth of a second.
#[derive(Debug, Args)]
pub struct Simulate {
    /// How many units
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    units: u32,

    /// The seed that everything is drawn from
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,

    /// The part of the units that are bad
    #[arg(long, value_name = "PART", default_value_t = 0.03)]
    bad: f64,

    /// Record the way back down too, as long again: what `--model auto` needs to see hysteresis
    #[arg(long)]
    cooling: bool,

    /// Write the recordings into this folder; it is made
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl Simulate {
    pub fn run(&self) -> Result<Outcome> {
        anyhow::ensure!((0.0..=1.0).contains(&self.bad), "--bad {}: give a part from 0 to 1", self.bad);
        let bar = bar(u64::from(self.units));
        let simulation = Simulation {
            units: self.units,
            seed: self.seed,
            out: self.out.clone(),
            bad: self.bad,
            cooling: self.cooling,
        };
        let truth = simulation.run(&|| bar.inc(1))?;
        bar.finish_and_clear();
        let bad = truth.units.iter().filter(|unit| unit.defect.is_some()).count();
        say!("{} recordings in {}, {bad} of them bad ({TRUTH} says which)", self.units, self.out.display());
        say!("To fit them: zerorate lot fit {} --out models.parquet", self.out.display());
        Ok(Outcome::Done)
    }
}
