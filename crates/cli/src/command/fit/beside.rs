//! A chamber's recording beside a log: `--chamber`.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde::Serialize;
use zerorate_cal::in_chamber::{InChamber, SOAKS_TOLD, SoakRow};
use zerorate_cal::log_fit::LogFit;
use zerorate_cal::recording::ChamberRecording;
use zerorate_cal::units::WrittenRate;
use zerorate_words::as_options;

use crate::screen::{Grid, Page, aligned};

/// Which recording, and when it began.
#[derive(Debug, Args)]
pub struct Beside {
    /// The recording of the chamber in which the board lay, by `zerorate chamber`: shown beside the log, with what sensor and rate were
    /// at the end of each soak. The fit does not use it. Both are joined by the time of day
    #[arg(long, value_name = "FILE", help_heading = "Chamber")]
    chamber: Option<PathBuf>,

    /// The log's second at which the chamber's recording began, where the log does not know the time of day
    #[arg(long, value_name = "SECONDS", requires = "chamber", allow_negative_numbers = true, help_heading = "Chamber")]
    chamber_at: Option<f64>,
}

impl Beside {
    /// The recording beside a fit, if one was given.
    pub fn joined(&self, fit: &LogFit) -> Result<Option<InChamber>> {
        let Some(file) = &self.chamber else { return Ok(None) };
        ensure!(self.chamber_at.is_none_or(f64::is_finite), "--chamber-at: give a number of seconds");
        let recording = ChamberRecording::read(&file.into())?;
        let name = file.display().to_string();
        let joined = InChamber::join(fit, &name, &recording, self.chamber_at);
        let told = |mut joined: InChamber| {
            joined.told.iter_mut().for_each(|sentence| *sentence = as_options(sentence));
            Some(joined)
        };
        joined.map(told).map_err(|error| anyhow::anyhow!(as_options(&error.to_string()))).context(name)
    }
}

/// A fit and what stood about it, as JSON has them.
#[derive(Serialize)]
pub struct Fitted<'a> {
    #[serde(flatten)]
    pub fit: &'a LogFit,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chamber: Option<&'a InChamber>,
}

/// What stood about the log, as people read it.
pub fn soaks(page: &mut Page, fit: &LogFit, chamber: &InChamber, asked: Option<WrittenRate>) {
    page.heading("In the chamber, at the end of each soak");
    chamber.told.iter().for_each(|sentence| page.sentence("  ", sentence));
    page.gap();
    let rows: Vec<SoakRow> = chamber.rows(fit, asked);
    if rows.is_empty() {
        page.sentence("  ", &format!("No soak of {} ended while the log was recorded.", chamber.recording));
        return;
    }
    let column = |of: fn(&SoakRow) -> f64, decimals: usize| -> Vec<String> {
        rows.iter().map(|row| format!("{:.decimals$}", of(row))).collect()
    };
    let columns = [
        // Without a zero below 0.
        column(|row| (row.soak.from_s / 60.0).round() + 0.0, 0),
        column(|row| (row.soak.to_s / 60.0).round() + 0.0, 0),
        column(|row| row.soak.set_c, 1),
        column(|row| row.soak.air_c, 1),
        column(|row| row.axis.sensor_c, 1),
        column(|row| row.axis.sensor_c - row.soak.air_c, 1),
    ];
    let residuals = aligned(&rows.iter().map(|row| row.residual).collect::<Vec<_>>());
    let mut grid = Grid::new("rrrrrrlrl");
    grid.head(["from", "to", "set to", "air", "sensor", "above air", "", "residual", ""]);
    grid.head(["min", "min", "C", "C", "C", "K", "axis", "mean", ""]);
    for (place, (row, residual)) in rows.iter().zip(residuals).enumerate() {
        let cells = columns.iter().map(|column| column[place].clone());
        grid.row(cells.chain([row.axis.name.clone(), residual, row.unit.to_owned()]));
    }
    page.grid(&grid);
    page.gap();
    page.sentence("  ", SOAKS_TOLD);
}
