//! `zerorate lot fit`.

use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use clap::Args;
use zerorate_fit::model::Model;
use zerorate_lot::engine::{Address, Cluster, Engine};
use zerorate_lot::run::{FitRun, JudgedUnit, Summary};

use super::{Outcome, bar, wait};

/// Rejected units and skipped files shown at most; --json has all.
const SHOWN: usize = 40;

/// Fit every recording of a lot: one row a unit and axis
///
/// Each unit's drift is fitted on its own scale, judged, and each of its ramp's eight folds is predicted by the fit of
/// the others. A file that is damaged or no recording is named and left out. A run that was ended goes on where it was:
/// units whose recording is as it was are not fitted again.
#[derive(Debug, Args)]
pub struct Fit {
    /// The recordings: a folder (looked through whole), a glob in quotes, or s3://BUCKET/PREFIX
    #[arg(value_name = "DATASET")]
    dataset: String,

    /// Write the rows here, as Parquet
    #[arg(long, value_name = "FILE")]
    out: PathBuf,

    /// The drift model: auto, poly:1 to poly:5, or table:1 to table:32
    #[arg(long, value_name = "MODEL", default_value = "auto")]
    model: Model,

    /// Accept a temperature span under 10 C; the rows then hold for that span alone
    #[arg(long)]
    allow_narrow: bool,

    /// Fit everything again, whatever an earlier run has done
    #[arg(long)]
    fresh: bool,

    /// Run the queries on a Ballista 55 cluster, as df://localhost:50050
    #[arg(long, value_name = "df://HOST:PORT")]
    cluster: Option<Address>,

    /// With --cluster: the longest that one query may take, all attempts together, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 600)]
    deadline: u64,

    /// With --cluster: attempts after the first
    #[arg(long, value_name = "N", default_value_t = 2)]
    retries: u32,

    /// Print JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

impl Fit {
    pub fn run(&self) -> Result<Outcome> {
        let engine = match &self.cluster {
            None => Engine::embedded(),
            Some(address) => Engine::Cluster(Cluster {
                address: address.clone(),
                deadline: Duration::from_secs(self.deadline),
                retries: self.retries,
            }),
        };
        let run = FitRun {
            dataset: self.dataset.clone(),
            out: self.out.clone(),
            model: self.model,
            allow_narrow: self.allow_narrow,
            engine,
            fresh: self.fresh,
        };
        let bar = bar(0);
        let summary = wait(run.run(&|done, all| {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        }))??;
        bar.finish_and_clear();
        if self.json {
            // Programs read parameters' own names.
            _ = writeln!(io::stdout(), "{}", serde_json::to_string_pretty(&summary)?);
        } else {
            print(&summary);
        }
        let clean = summary.rejected.is_empty() && summary.skipped.is_empty();
        Ok(if clean { Outcome::Done } else { Outcome::Rejected })
    }
}

fn print(summary: &Summary) {
    let Summary { units, fits, reused, warnings, warned, rejected, skipped, .. } = summary;
    say!("{units} units, {fits} fits in {:.1} s ({reused} units were done before)", summary.seconds);
    say!("{warnings} with warnings, {} rejected, {} files skipped", rejected.len(), skipped.len());
    if summary.other_procedures > 0 {
        say!("{} recordings of other procedures passed over", summary.other_procedures);
    }
    if let (Some(median), Some(worst)) = (summary.median_held_out_rms_counts, &summary.worst) {
        say!(
            "held-out residual, counts rms: median {median:.2}, worst {:.2} ({} {})",
            worst.held_out_rms_counts,
            worst.serial,
            worst.axis
        );
    }
    judged("Rejected", rejected);
    judged("With warnings", warned);
    if !skipped.is_empty() {
        say!("\nSkipped");
    }
    for file in skipped.iter().take(SHOWN) {
        say!("  {}: {}", file.file, file.reason);
    }
    let left: usize =
        [rejected.len(), warned.len(), skipped.len()].iter().map(|count| count.saturating_sub(SHOWN)).sum();
    if left > 0 {
        say!("\nand {left} more: --json has all");
    }
    say!("\nWritten: {}", summary.models.display());
    say!("To look at it: zerorate lot report {}", summary.models.display());
}

fn judged(heading: &str, units: &[JudgedUnit]) {
    if !units.is_empty() {
        say!("\n{heading}");
    }
    for unit in units.iter().take(SHOWN) {
        let reasons: Vec<&str> = unit.reasons.iter().map(|reason| reason.text.as_str()).collect();
        say!("  {} ({}): {}", unit.serial, unit.file, reasons.join("; "));
    }
}
