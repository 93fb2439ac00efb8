//! The command that fits a run and those of a calibration as one: only where it will do what is meant.

use std::path::{Path, PathBuf};

use zerorate_apply::verify::Verified;
use zerorate_cal::calibration::{Calibration, Kind, Origin, sha256};
use zerorate_cal::source::Source;
use zerorate_cal::table::{Columns, Table};
use zerorate_cal::units::WrittenRate;

use crate::log_arguments::ColumnArguments;
use crate::output::{argument, word};

/// The command, where the logs are of the same axes that seem to be of the same unit, for of another the two would be nobody's;
/// where the calibration's own logs are found; and where tables of them are read alike, in the calibration's unit.
pub(super) fn join(
    (path, calibration): (&Path, &Calibration),
    (log, verified): (&Path, &Verified),
    asked: &ColumnArguments,
) -> Option<String> {
    let same = verified.axes.iter().all(|axis| axis.name == axis.log_axis) && verified.missing.is_empty();
    let is_other = verified.axes.iter().any(|axis| axis.worse) || verified.passed == Some(false);
    if !same || is_other || verified.in_sample || calibration.kind != Kind::Log {
        return None;
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut logs = calibration.sources.iter().map(|log| found(folder, log)).collect::<Option<Vec<PathBuf>>>()?;
    logs.push(log.to_owned());
    let is_table = calibration.sources.iter().all(|log| log.autopilot().is_none());
    let rate_unit = if is_table { unit_to_say(&logs, calibration, &asked.columns())? } else { None };
    let logs: Vec<String> = logs.iter().map(|log| argument(log)).collect();
    let own = [rate_unit.map(|unit| format!("--rate-unit {}", word(&unit.to_string()))), model(calibration)];
    let serial = calibration.unit_serial.as_ref().map(|serial| format!("--serial {}", word(serial)));
    let labels = calibration.labels.iter().map(|(name, words)| format!("--label {}", word(&format!("{name}={words}"))));
    let own: String =
        own.into_iter().flatten().chain(serial).chain(labels).map(|option| format!(" {option}")).collect();
    let (logs, columns) = (logs.join(" "), asked.typed());
    Some(format!("zerorate fit {logs}{columns}{own} --out both.calibration.json --report both.report.html"))
}

/// A log of the calibration: it knows them by name, and most lie beside it. Another file of that name is none.
fn found(folder: &Path, log: &Origin) -> Option<PathBuf> {
    let places = [folder.join(&log.file), PathBuf::from(&log.file)];
    places.into_iter().find(|place| place.is_file() && sha256(&place.into()).is_ok_and(|own| own == log.sha256))
}

/// The unit of rates that has to be said for all of some tables to be read as the calibration was; `Some(None)` where their names say
/// it. `None` where they cannot be read alike.
fn unit_to_say(logs: &[PathBuf], calibration: &Calibration, asked: &Columns) -> Option<Option<WrittenRate>> {
    if read_alike(logs, calibration, asked) {
        return Some(None);
    }
    let unit = calibration.axes.values().find_map(|axis| WrittenRate::of(axis.rate_unit));
    let said = Columns { rate_unit: unit, ..asked.clone() };
    (asked.rate_unit.is_none() && read_alike(logs, calibration, &said)).then_some(unit)
}

/// Whether some tables have the same columns in the same order, of the calibration's axes and in its unit, and nothing of the unit is
/// guessed.
fn read_alike(logs: &[PathBuf], calibration: &Calibration, asked: &Columns) -> bool {
    let names = |log: &PathBuf| {
        let resolved = asked.resolve(&Table::open(&Source::from(log)).ok()?).ok()?;
        let rates = || resolved.sensors.iter().flat_map(|sensor| sensor.rates.iter().map(move |rate| (sensor, rate)));
        let is_own = |name: &str, unit| calibration.axes.get(name).is_none_or(|axis| axis.rate_unit == unit);
        let known = rates().all(|(sensor, rate)| !sensor.is_rate_guessed && is_own(&rate.name, sensor.rate_unit));
        known.then(|| rates().map(|(_, rate)| rate.name.clone()).collect::<Vec<_>>())
    };
    let names: Option<Vec<Vec<String>>> = logs.iter().map(names).collect();
    names.is_some_and(|names| names.windows(2).all(|pair| pair[0] == pair[1]))
}

/// The model, where one was asked for: a choice has more than one candidate.
fn model(calibration: &Calibration) -> Option<String> {
    let was_chosen = calibration.axes.values().any(|axis| axis.fit.statistics.candidates.len() > 1);
    let first = calibration.axes.values().next().filter(|_| !was_chosen)?;
    Some(format!("--model {}", first.model()))
}
