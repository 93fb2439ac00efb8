//! What stands between the simulated A/D and the processor.

use anyhow::{Result, ensure};
use clap::ValueEnum;
use zerorate_bench::calibrated::Unit;
use zerorate_bench::instruments::Bench;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;

/// An acquisition by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Acquisition {
    /// The simulated acquisition port
    Port,
    /// None: the processor drives the A/D itself
    Direct,
}

impl Acquisition {
    /// The simulated bench with this acquisition.
    pub fn bench(self, kind: PlantKind, seed: u64, setup: &SetUp, unit: &Unit) -> Result<Bench> {
        match self {
            Self::Port => Ok(simulated::bench(kind.build(seed), setup, &unit.serial)),
            Self::Direct => {
                let conversions = setup.acquisition.oversampling;
                ensure!(
                    conversions == 1,
                    "acquisition.oversampling is {conversions}: a processor that drives the A/D itself has time for one \
                     conversion a sample; set it to 1, or take --acquisition port"
                );
                Ok(simulated::direct_bench(kind.build(seed), setup, &unit.serial))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_processor_that_drives_the_converter_itself_does_not_oversample() {
        let unit = Unit::new("ZR-0001", None).expect("a serial number");
        let mut setup = SetUp::paper();
        setup.acquisition.oversampling = 16;
        let refused = Acquisition::Direct.bench(PlantKind::Paper, 1, &setup, &unit).err();
        assert!(refused.is_some_and(|why| why.to_string().contains("acquisition.oversampling is 16")));
    }
}
