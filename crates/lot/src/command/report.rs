//! `zerorate lot report`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use zerorate_cal::source::whole_file::write_whole;
use zerorate_lot::{out, report};
use zerorate_report::LotReport;
use zerorate_report::number::counted;

use super::{Outcome, tell, wait};

/// Write a lot's report as one HTML page: distribution, worst units, yield, the process over time
///
/// A limits file is TOML: under [limits], drift_pp_counts, in_sample_rms_counts, held_out_rms_counts, held_out_pp_counts
/// and reading_mid_counts, each a greatest value or { min = A, max = B }.
#[derive(Debug, Args)]
pub struct Report {
    /// The rows that `zerorate lot fit` wrote
    #[arg(value_name = "MODELS")]
    models: PathBuf,

    /// The limits, as TOML
    #[arg(long, value_name = "FILE")]
    limits: Option<PathBuf>,

    /// Where the recordings are now, if not where they were fitted
    #[arg(long, value_name = "DATASET")]
    dataset: Option<String>,

    /// Write the page here
    #[arg(long, value_name = "FILE", default_value = "lot.html")]
    out: PathBuf,
}

impl Report {
    pub fn run(&self) -> Result<Outcome> {
        out::check(&self.out, [self.models.as_path()].into_iter())?;
        let models = self.models.display().to_string();
        let is_one = |path: &Path| fs::read_to_string(path).is_ok_and(|page| LotReport::is_page_of(&page, &models));
        out::check_kind(&self.out, "the page of these models", is_one)?;
        let limits = self.limits.as_deref().map(report::limits).transpose()?.unwrap_or_default();
        let report = wait(report::report(&self.models, self.dataset.as_deref(), limits))??;
        write_whole(&self.out, report.to_html().as_bytes())
            .with_context(|| format!("{}: cannot be written", self.out.display()))?;
        report.undrawn_notes().iter().for_each(|sentence| tell(&format!("note: {sentence}")));
        let outside = Some(report.outside()).filter(|_| !report.limits.is_empty());
        let outside = outside.map(|units| format!(", {units} outside the limits")).unwrap_or_default();
        let (units, warned) = (counted(report.units.len(), "unit"), report.warned());
        say!("{units}, {} pass, {} rejected{outside}, {warned} with warnings", report.passed(), report.rejected());
        match &report.beside {
            Some(beside) if beside.skipped.is_empty() => {}
            Some(beside) => say!("{} skipped: the page says why", counted(beside.skipped.len(), "file")),
            None => tell("note: which files were skipped is not told: an earlier version fitted them"),
        }
        say!("Written: {}", self.out.display());
        let all = report.passed() == report.units.len() && report.skipped().is_empty();
        Ok(if all { Outcome::Done } else { Outcome::Rejected })
    }
}
