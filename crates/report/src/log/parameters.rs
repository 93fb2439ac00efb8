//! The fit of a log as other programs' parameters, for the page.

use super::Parameters;
use zerorate_cal::export::{ExportOptions, Format, export};
use zerorate_cal::log_fit::LogFit;
use zerorate_cal::units::RateUnit;
use zerorate_cal::units::TemperatureUnit;

/// The forms that a page shows: those of autopilots, which people paste.
const SHOWN: [(Format, &str); 3] = [
    (Format::Px4, "PX4 (QGroundControl)"),
    (Format::ArduPilot, "ArduPilot (Mission Planner, MAVProxy)"),
    (Format::MethodicConfigurator, "ArduPilot (MethodicConfigurator)"),
];

/// The parameters of a fit; none for rates in counts or a rejected log.
pub(super) fn of(fit: &LogFit) -> Vec<Parameters> {
    let Some(first) = fit.axes.first() else { return Vec::new() };
    if first.temperature_unit != TemperatureUnit::C
        || fit.axes.iter().any(|axis| axis.calibration.rate_unit == RateUnit::Counts)
    {
        return Vec::new();
    }
    // Without what a file needs and parameters do not: sources, serial.
    let Ok(calibration) = fit.to_calibration(Vec::new(), None) else { return Vec::new() };
    let shown = SHOWN.iter().map(|(format, program)| Parameters {
        program: (*program).to_owned(),
        command: format!("zerorate export calibration.json --format {format} --out {}", format.file_name()),
        text: export(&calibration, *format, &ExportOptions::default())
            .map(|exported| exported.text)
            .map_err(|error| error.to_string()),
    });
    shown.collect()
}
