//! `zerorate lot export`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use zerorate_lot::export::{ExportError, export};

use super::{Outcome, tell, wait};

/// Write one unit's calibration and device record: the same files as `zerorate fit` makes of its recording alone
#[derive(Debug, Args)]
pub struct Export {
    /// The unit's serial
    #[arg(value_name = "UNIT")]
    unit: String,

    /// The rows that `zerorate lot fit` wrote
    #[arg(long, value_name = "FILE", default_value = "models.parquet")]
    models: PathBuf,

    /// Where the recordings are now, if not where they were fitted
    #[arg(long, value_name = "DATASET")]
    dataset: Option<String>,

    /// Write calibration.json and device-record.bin into this folder; it is made
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl Export {
    pub fn run(&self) -> Result<Outcome> {
        match wait(export(&self.models, self.dataset.as_deref(), &self.unit, &self.out))? {
            Ok(exported) => {
                say!("Calibration:   {}", exported.calibration.display());
                say!("Device record: {}", exported.record.display());
                if exported.disagreement > 0.0 {
                    say!("The fit agrees with its row to {:.0e} of its range", exported.disagreement);
                } else {
                    say!("The fit is its row's");
                }
                exported.warnings.iter().for_each(|warning| tell(&format!("warning: {warning}")));
                Ok(Outcome::Done)
            }
            Err(error @ ExportError::Rejected { .. }) => {
                tell(&error.to_string());
                Ok(Outcome::Rejected)
            }
            Err(error) => Err(error.into()),
        }
    }
}
