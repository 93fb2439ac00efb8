//! The fit, and what the page gets of it.

use std::collections::BTreeMap;
use std::error::Error;

use serde::Serialize;
use zerorate_cal::calibration::Calibration;
use zerorate_cal::fit::fit;
use zerorate_cal::log_fit::LogFit;
use zerorate_cal::recording::Recording;
use zerorate_cal::source::Source;
use zerorate_export::{ExportOptions, Format, export};
use zerorate_report::LogPage;
use zerorate_words::sentence;

use crate::asked::Asked;

/// What the page shows and saves.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// The logs were read, and judged.
    Fitted(Box<Fitted>),
    /// They cannot be fitted; the sentence says why, and what to do.
    Error(String),
}

/// What was read, and judged.
#[derive(Debug, Serialize)]
pub struct Fitted {
    /// As `zerorate fit --json` prints it.
    pub fit: LogFit,
    /// The report, one page of HTML.
    pub report: String,
    /// What can be saved: nothing of a log that was rejected.
    pub files: Vec<Saved>,
    /// What to know of how the log was read.
    pub notes: Vec<String>,
}

/// A file to save.
#[derive(Debug, Serialize)]
pub struct Saved {
    /// What it is.
    pub what: &'static str,
    /// Its name.
    pub name: String,
    /// What is in it.
    pub text: String,
}

impl Answer {
    /// Fits logs as they were asked for; an error is an answer too.
    #[must_use]
    pub fn of(asked: &Asked, sources: &[Source]) -> Self {
        match fitted(asked, sources) {
            Ok(fitted) => Self::Fitted(Box::new(fitted)),
            Err(error) => Self::Error(sentence(&*error)),
        }
    }
}

fn fitted(asked: &Asked, sources: &[Source]) -> Result<Fitted, Box<dyn Error>> {
    let fit = fit(sources, &asked.options()?)?;
    let (origins, units, serial) = (fit.origins(sources)?, asked.told_in()?, asked.serial());
    let labels = BTreeMap::new();
    let page = LogPage {
        fit: &fit,
        units,
        serial,
        labels: &labels,
        chamber: None,
        sources: &origins,
        next_command: None,
        export_command: None,
    };
    let report = page.to_html();
    let mut notes = fit.notes.clone();
    let mut files = Vec::new();
    if !fit.judgement.rejected() {
        let name = sources.first().map_or("log", Source::short_name);
        let name = name.strip_suffix(".gz").unwrap_or(name);
        let name = name.rsplit_once('.').map_or(name, |(name, _)| name);
        files.push(Saved { what: "report", name: format!("{name}.report.html"), text: report.clone() });
        if matches!(sources, [source] if Recording::is_one(source)) {
            notes.push("the calibration of a board's recording is made by the command: `zerorate fit`".to_owned());
        } else {
            let calibration = fit.to_calibration(origins, serial.map(str::to_owned))?;
            let calibration = Calibration { told_in: units, ..calibration };
            let text = calibration.to_json()?;
            files.push(Saved { what: "calibration", name: format!("{name}.calibration.json"), text });
            files.extend(fit.autopilot.and_then(|autopilot| parameters(&calibration, autopilot.into())));
        }
    }
    Ok(Fitted { fit, report, files, notes })
}

/// The parameters of the autopilot that wrote the log; why there are none stands in the report.
fn parameters(calibration: &Calibration, format: Format) -> Option<Saved> {
    let exported = export(calibration, format, &ExportOptions::default()).ok()?;
    Some(Saved { what: "parameters", name: format.file_name().to_owned(), text: exported.text })
}
