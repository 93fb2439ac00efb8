//! `zerorate lot group`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use zerorate_lot::engine::Engine;
use zerorate_lot::raw::group;

use super::{Outcome, wait};

/// Sum raw samples to groups, once: some 500 to 1
///
/// Raw samples are Parquet with the columns group_number, axis (x and y), temperature_counts and zro_counts, whole numbers and none
/// missing. The sums are exact, in order, under the names of a recording's columns; a recording, which a fit reads, has the
/// unit, its set-up and the ramp's phases as well.
#[derive(Debug, Args)]
pub struct Group {
    /// The raw samples: a folder, a file, a glob in quotes, or s3://BUCKET/PREFIX
    #[arg(value_name = "DATASET")]
    dataset: String,

    /// Write the sums here, as Parquet
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

impl Group {
    pub fn run(&self) -> Result<Outcome> {
        let grouped = wait(group(&Engine::embedded(), &self.dataset, &self.out))??;
        say!("{} rows of sums in {:.3} s", grouped.rows, grouped.seconds);
        say!("Written: {}", self.out.display());
        Ok(Outcome::Done)
    }
}
