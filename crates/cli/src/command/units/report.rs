//! What lies beneath a folder, as its page has it.

use chrono::DateTime;
use zerorate_bench::board::Axis;
use zerorate_report::{UnitAxis, UnitCalibration, UnitCalibrations, UnitsReport};

use super::found::{AxisOfRun, Run, Unit};

/// Seconds in a day.
const DAY_S: f64 = 86_400.0;

/// The page's contents.
pub fn of(folder: &str, units: &[Unit], unreadable: &[String]) -> UnitsReport {
    let unit = |unit: &Unit| UnitCalibrations {
        serial: unit.name(),
        calibrations: unit.runs.iter().map(calibration).collect(),
    };
    UnitsReport { folder: folder.to_owned(), units: units.iter().map(unit).collect(), unreadable: unreadable.to_vec() }
}

fn calibration(run: &Run) -> UnitCalibration {
    let started = run.started.as_deref().and_then(|started| DateTime::parse_from_rfc3339(started).ok());
    // Seconds since 1970 are far below 2^53.
    #[allow(clippy::cast_precision_loss)]
    let day = started.map(|started| started.timestamp() as f64 / DAY_S);
    let axes = Axis::BOTH.map(|axis| run.axes.get(axis.name()).map(of_axis));
    UnitCalibration { made: run.made(), day, verdict: run.verdict, axes }
}

fn of_axis(axis: &AxisOfRun) -> UnitAxis {
    UnitAxis {
        drift: axis.drift_pp_counts,
        trim: axis.trim_residual_pp_counts,
        hybrid: axis.hybrid_residual_pp_counts,
        change: axis.change_counts,
    }
}
