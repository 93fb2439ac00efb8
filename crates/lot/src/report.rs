//! `lot report`: a lot as one HTML page.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use zerorate_cal::quality::Verdict;
use zerorate_report::{LotAxis, LotBeside, LotLimit, LotReport, LotUnit, Quantity, WorstUnit};

use crate::export::{agrees, refit};
use crate::models::{self, ModelRow, ModelsError};

/// Units drawn.
const WORST: usize = 10;

/// A limits file: under `limits` a greatest value for each quantity, or a table with `min`, `max` or both.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct LimitsFile {
    #[serde(default)]
    limits: BTreeMap<String, toml::Value>,
}

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The rows.
    #[error(transparent)]
    Models(#[from] ModelsError),
    /// The limits file cannot be read.
    #[error("{path}: {reason}")]
    Limits {
        /// The file.
        path: String,
        /// What is wrong.
        reason: String,
    },
}

/// Reads a limits file.
///
/// # Errors
/// [`ReportError::Limits`].
pub fn limits(path: &Path) -> Result<Vec<LotLimit>, ReportError> {
    let wrong = |reason: String| ReportError::Limits { path: path.display().to_string(), reason };
    let text = std::fs::read_to_string(path).map_err(|error| wrong(error.to_string()))?;
    parse(&text).map_err(wrong)
}

fn parse(text: &str) -> Result<Vec<LotLimit>, String> {
    let file: LimitsFile = toml::from_str(text)
        .map_err(|error| format!("{}: give limits under [limits]", error.to_string().trim_end().replace('`', "'")))?;
    let known = || Quantity::ALL.map(Quantity::key).join(", ");
    if file.limits.is_empty() {
        return Err("no limit under [limits]".to_owned());
    }
    let limit = |(key, value): (&String, &toml::Value)| {
        let quantity = Quantity::ALL.into_iter().find(|quantity| quantity.key() == key);
        let quantity = quantity.ok_or_else(|| format!("'{key}' is no limit: there are {}", known()))?;
        let (min, max) = bounds(value).ok_or_else(|| {
            format!("{key} = {value}: give a greatest value, or {{ min = A, max = B }} with A not above B")
        })?;
        Ok(LotLimit { quantity, min, max })
    };
    file.limits.iter().map(limit).collect()
}

/// The least and the greatest value that a limit allows; `None` where it makes no sense.
fn bounds(value: &toml::Value) -> Option<(f64, f64)> {
    #[allow(clippy::cast_precision_loss)] // Limits are small.
    let number = |value: &toml::Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    let Some(table) = value.as_table() else {
        return number(value).filter(|max| max.is_finite()).map(|max| (f64::NEG_INFINITY, max));
    };
    let (mut min, mut max) = (f64::NEG_INFINITY, f64::INFINITY);
    for (key, value) in table {
        let bound = match key.as_str() {
            "min" => &mut min,
            "max" => &mut max,
            _ => return None,
        };
        *bound = number(value).filter(|value| value.is_finite())?;
    }
    (!table.is_empty() && min <= max).then_some((min, max))
}

/// The report of the rows in a file. Recordings are read again for the worst units; `dataset` says where they are now,
/// if not where they were fitted.
///
/// # Errors
/// [`ReportError`]; a recording that is gone is said in the report.
pub async fn report(models: &Path, dataset: Option<&str>, limits: Vec<LotLimit>) -> Result<LotReport, ReportError> {
    let (rows, beside) = models::read_whole(models)?;
    let mut units = units(&rows);
    units.sort_by(|a, b| a.day.total_cmp(&b.day).then_with(|| a.serial.cmp(&b.serial)));
    let (worst, undrawn) = worst(&rows, dataset).await;
    Ok(LotReport {
        source: models.display().to_string(),
        model: rows.first().map_or_else(String::new, |row| row.model_asked.clone()),
        units,
        limits,
        worst,
        undrawn,
        beside: beside.map(|beside| LotBeside {
            skipped: beside.skipped.into_iter().map(|skipped| (skipped.file, skipped.reason)).collect(),
            other_procedures: beside.other_procedures,
        }),
    })
}

fn units(rows: &[ModelRow]) -> Vec<LotUnit> {
    let seconds: Vec<f64> = rows.iter().map(|row| unix_s(&row.recorded_at)).collect();
    let first = seconds.iter().copied().fold(f64::INFINITY, f64::min);
    let mut units: Vec<LotUnit> = Vec::new();
    let mut last: Option<&str> = None;
    for (row, seconds) in rows.iter().zip(seconds) {
        if last != Some(&row.file) {
            last = Some(&row.file);
            let reasons = |of| row.reasons_of(of).into_iter().map(|reason| reason.text).collect();
            units.push(LotUnit {
                serial: row.unit_serial.clone(),
                file: row.file.clone(),
                station: row.station.clone(),
                day: (seconds - first) / 86_400.0,
                rejected: reasons(Verdict::Rejected),
                warned: reasons(Verdict::Warning),
                axes: Vec::new(),
            });
        }
        if let Some(unit) = units.last_mut().filter(|_| !row.model.is_empty()) {
            let values = [row.drift_pp, row.reading_mid, row.in_sample_rms, row.held_out_rms, row.held_out_pp];
            unit.axes.push(LotAxis { name: row.axis.clone(), values });
        }
    }
    units
}

/// Seconds since 1970 of an RFC 3339 time; NaN for another text.
fn unix_s(text: &str) -> f64 {
    chrono::DateTime::parse_from_rfc3339(text).map_or(f64::NAN, |time| time.timestamp() as f64)
}

async fn worst(rows: &[ModelRow], dataset: Option<&str>) -> (Vec<WorstUnit>, Vec<String>) {
    let mut sound: Vec<&ModelRow> = rows.iter().filter(|row| !row.rejected() && row.held_out_rms.is_finite()).collect();
    sound.sort_by(|a, b| b.held_out_rms.total_cmp(&a.held_out_rms));
    let (mut units, mut worst, mut undrawn) = (Vec::new(), Vec::new(), Vec::new());
    for row in sound {
        if worst.len() + undrawn.len() == WORST {
            break;
        }
        // The worse axis comes first.
        if units.contains(&&row.file) {
            continue;
        }
        units.push(&row.file);
        let refitted = refit(row, dataset).await.and_then(|(_, fit)| agrees(row, &fit).map(|_| fit));
        match refitted {
            Ok(fit) => worst.push(WorstUnit {
                serial: row.unit_serial.clone(),
                axis: row.axis.clone(),
                held_out_rms: row.held_out_rms,
                fit,
            }),
            Err(error) => undrawn.push(format!("{}: not drawn: {error}", row.unit_serial)),
        }
    }
    (worst, undrawn)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_a_number_or_two_and_another_name_is_refused() {
        let limits = parse("[limits]\nheld_out_rms_counts = 5\nreading_mid_counts = { min = 8000.0, max = 8400.0 }\n");
        let limits = limits.unwrap();
        let reading = limits.iter().find(|limit| limit.quantity == Quantity::Reading).unwrap();
        assert!((reading.min - 8000.0).abs() < 1e-9 && (reading.max - 8400.0).abs() < 1e-9);
        let held_out = limits.iter().find(|limit| limit.quantity == Quantity::HeldOut).unwrap();
        assert!(held_out.min == f64::NEG_INFINITY && (held_out.max - 5.0).abs() < 1e-9);
        let refused = parse("[limits]\nheld_out = 5.0\n").unwrap_err();
        assert!(refused.contains("'held_out' is no limit") && refused.contains("held_out_rms_counts"), "{refused}");
        for senseless in ["{ least = 1 }", "{}", "{ min = 8500, max = 7900 }", "nan", "'5'", "{ max = inf }"] {
            let refused = parse(&format!("[limits]\nreading_mid_counts = {senseless}\n")).unwrap_err();
            assert!(refused.contains("reading_mid_counts ="), "{refused}");
        }
        assert!(parse("").unwrap_err().contains("no limit"));
        let headless = parse("drift_pp_counts = 5\n").unwrap_err();
        assert!(
            headless.contains("'drift_pp_counts'") && headless.ends_with("give limits under [limits]"),
            "{headless}"
        );
    }
}
