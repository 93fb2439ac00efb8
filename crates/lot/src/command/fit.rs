//! `zerorate lot fit`.

use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use clap::Args;
use zerorate_cal::quality::{Reason, Verdict};
use zerorate_cal::ramp_fit::verdict_of;
use zerorate_fit::model::Model;
use zerorate_lot::engine::{Address, Cluster, Engine};
use zerorate_lot::run::{FitRun, JudgedUnit, Summary};
use zerorate_report::number::counted;
use zerorate_report::{alike, few};

use super::{Outcome, bar, wait};

/// Lines of a list shown at most; --json has all.
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
            print(&summary, self.allow_narrow);
        }
        let clean = summary.rejected.is_empty() && summary.skipped.is_empty();
        Ok(if clean { Outcome::Done } else { Outcome::Rejected })
    }
}

fn print(summary: &Summary, narrow: bool) {
    let Summary { units, fits, reused, warnings, warned, rejected, skipped, .. } = summary;
    let (seconds, files) = (summary.seconds, counted(skipped.len(), "file"));
    say!("{}, {} in {seconds:.1} s ({reused} done before)", counted(*units, "unit"), counted(*fits, "fit"));
    say!("{warnings} with warnings, {} rejected, {files} skipped", rejected.len());
    if summary.other_procedures > 0 {
        let others = usize::try_from(summary.other_procedures).unwrap_or(usize::MAX);
        say!("{} of other procedures passed over", counted(others, "recording"));
    }
    if let (Some(median), Some(worst)) = (summary.median_held_out_rms_counts, &summary.worst) {
        say!(
            "held-out residual, counts rms: median {median:.2}, worst {:.2} ({} {})",
            worst.held_out_rms_counts,
            worst.serial,
            worst.axis
        );
    }
    let mut looked_at: Vec<&JudgedUnit> = rejected.iter().chain(warned).collect();
    looked_at.sort_by_key(|unit| (&unit.serial, &unit.file));
    let reject = |reason: &Reason| verdict_of(reason, narrow) == Verdict::Rejected;
    let why = rejected.iter().map(|unit| {
        let reasons = unit.reasons.iter().filter(|reason| reject(reason)).map(|reason| reason.text.as_str());
        format!("{} ({}): {}", unit.serial, unit.file, reasons.collect::<Vec<_>>().join("; "))
    });
    let lists = [
        ("Rejected", why.collect()),
        ("Warnings", told(&looked_at, *units, &|reason| verdict_of(reason, narrow) == Verdict::Warning)),
        ("Skipped", skipped.iter().map(|file| format!("{}: {}", file.file, file.reason)).collect::<Vec<_>>()),
    ];
    for (heading, lines) in lists.iter().filter(|(_, lines)| !lines.is_empty()) {
        say!("\n{heading}");
        lines.iter().take(SHOWN).for_each(|line| say!("  {line}"));
        if lines.len() > SHOWN {
            say!("  and {} more: `json` has all", lines.len() - SHOWN);
        }
    }
    say!("\nWritten: {}", summary.models.display());
    say!("To look at it: zerorate lot report {}", summary.models.display());
}

/// What there is to look at; what several units are told in the same words is said once.
fn told(units: &[&JudgedUnit], all: usize, of: &dyn Fn(&Reason) -> bool) -> Vec<String> {
    let each = units.iter().flat_map(|&unit| {
        let reasons = unit.reasons.iter().filter(|reason| of(reason));
        reasons.map(move |reason| (unit, reason.text.clone()))
    });
    let line = |(text, units): (String, Vec<&JudgedUnit>)| match units.as_slice() {
        [unit] => format!("{} ({}): {text}", unit.serial, unit.file),
        several if several.len() == all => format!("all {all} units: {text}"),
        several => {
            let serials: Vec<&str> = several.iter().map(|unit| unit.serial.as_str()).collect();
            format!("{} units ({}): {text}", several.len(), few(&serials))
        }
    };
    alike(each).into_iter().map(line).collect()
}
