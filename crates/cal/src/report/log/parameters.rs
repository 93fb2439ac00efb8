//! The fit of a log as other programs' parameters, for the page.

use super::Parameters;
use crate::calibration::{AxisCalibration, CREATED_BY, Calibration, Kind, ResidualOver};
use crate::interop::export::{ExportOptions, Format, export};
use crate::log_fit::LogFit;
use crate::quality::TemperatureUnit;
use crate::table::RateUnit;

/// The forms that a page shows: those of autopilots, which people paste.
const SHOWN: [(Format, &str); 3] = [
    (Format::Px4, "PX4 (QGroundControl)"),
    (Format::ArduPilot, "ArduPilot (Mission Planner, MAVProxy)"),
    (Format::MethodicConfigurator, "ArduPilot (MethodicConfigurator)"),
];

/// The parameters of a fit; none for rates in counts or a rejected log.
pub(super) fn of(fit: &LogFit) -> Vec<Parameters> {
    let Some(first) = fit.axes.first() else { return Vec::new() };
    if first.temperature_unit != TemperatureUnit::C || fit.axes.iter().any(|axis| axis.rate_unit == RateUnit::Counts) {
        return Vec::new();
    }
    // Without what a file needs and parameters do not: sources, serial, warnings.
    let calibration = Calibration {
        kind: Kind::Log,
        unit_serial: None,
        created_by: CREATED_BY.to_owned(),
        sources: Vec::new(),
        temperature_unit: first.temperature_unit,
        temperature_scale: None,
        group_period_s: None,
        axes: fit
            .axes
            .iter()
            .map(|axis| (axis.name.clone(), AxisCalibration::of_fit(axis, ResidualOver::Groups)))
            .collect(),
        warnings: Vec::new(),
        setup: None,
    };
    let shown = SHOWN.iter().map(|(format, program)| Parameters {
        program: (*program).to_owned(),
        command: format!("zerorate export calibration.json --format {format} --out {}", format.file_name()),
        text: export(&calibration, *format, &ExportOptions::default())
            .map(|exported| exported.text)
            .map_err(|error| error.to_string()),
    });
    shown.collect()
}
