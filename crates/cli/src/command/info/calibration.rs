//! What is in a calibration.

use std::path::Path;

use anyhow::Result;
use serde::Serialize;
use zerorate_cal::calibration::{AxisCalibration, Calibration, Kind, Origin};
use zerorate_cal::units::{RateScale, RateUnit, from_to};
use zerorate_fit::drift_fit::ResidualOver;

use crate::screen::{Grid, Page, aligned, three_digits};

/// Digits of a SHA-256 that tell one file from another at a glance.
const SHORT_HASH: usize = 12;

#[derive(Debug, Serialize)]
pub struct Facts {
    calibrated: Kind,
    unit_serial: Option<String>,
    created_by: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    simulated: Option<String>,
    sources: Vec<Origin>,
    temperature_unit: &'static str,
    axes: Vec<Axis>,
    warnings: Vec<String>,
    /// How the rates of each unit are shown: of a log with gyros and accelerometers two.
    #[serde(skip)]
    scales: Vec<(RateUnit, RateScale)>,
}

#[derive(Debug, Serialize)]
struct Axis {
    name: String,
    model: String,
    rate_unit: RateUnit,
    temperature: [f64; 2],
    drift_pp: f64,
    in_sample_rms: Option<f64>,
    held_out_rms: Option<f64>,
    residual_over: Option<ResidualOver>,
    trim: Option<Trim>,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Trim {
    counts_per_tap: f64,
    taps_measured: usize,
    centre_counts: f64,
    dead_band_taps: f64,
    start_up_mode: &'static str,
}

impl Facts {
    pub fn read(file: &Path) -> Result<Self> {
        let calibration = Calibration::read(&file.into())?;
        let units = RateUnit::each(calibration.axes.values().map(|axis| axis.rate_unit));
        Ok(Self {
            scales: units.into_iter().map(|unit| (unit, calibration.scale(unit))).collect(),
            calibrated: calibration.kind,
            unit_serial: calibration.unit_serial,
            created_by: calibration.created_by,
            simulated: calibration.simulated,
            sources: calibration.sources,
            temperature_unit: calibration.temperature_unit.name(),
            axes: calibration.axes.iter().map(|(name, axis)| Axis::of(name, axis)).collect(),
            warnings: calibration.warnings,
        })
    }

    pub fn show(&self, file: &str, page: &mut Page) {
        let what = match self.calibrated {
            Kind::AnalogueBoard => "an analogue board",
            Kind::Log => "a log",
        };
        page.sentence("", &format!("{file}: the calibration of {what}"));
        let unit = self.unit_serial.clone().unwrap_or_else(|| "not given".to_owned());
        page.facts(&[("unit", unit), ("made by", self.created_by.clone())]);
        if let Some(simulated) = &self.simulated {
            page.facts(&[("from   ", format!("the simulated bench: {simulated}"))]);
        }
        for source in &self.sources {
            let hash = source.sha256.get(..SHORT_HASH).unwrap_or(&source.sha256);
            let recorded = source.started.as_ref().map(|started| format!(", recorded {started}")).unwrap_or_default();
            page.facts(&[("from   ", format!("{} ({}{recorded}, SHA-256 {hash}...)", source.file, source.content))]);
        }
        self.scales.iter().for_each(|(unit, scale)| self.show_axes(*unit, *scale, page));
        for axis in &self.axes {
            if let Some(trim) = &axis.trim {
                trim.show(&axis.name, page);
            }
        }
        let warnings =
            self.axes.iter().flat_map(|axis| axis.warnings.iter().map(|text| format!("{}: {text}", axis.name)));
        let warnings: Vec<String> = self.warnings.iter().cloned().chain(warnings).collect();
        if !warnings.is_empty() {
            page.heading("What to look at");
            warnings.iter().for_each(|warning| page.sentence("  - ", warning));
        }
    }

    /// The axes of one unit.
    fn show_axes(&self, unit: RateUnit, scale: RateScale, page: &mut Page) {
        let axes: Vec<&Axis> = self.axes.iter().filter(|axis| axis.rate_unit == unit).collect();
        page.gap();
        let mut grid = Grid::new("llrrrr");
        grid.head(["", "", "calibrated", "curve", "in-sample", "held out"]);
        let unit = scale.unit();
        grid.head([
            "axis",
            "model",
            self.temperature_unit,
            &format!("pp, {unit}"),
            &format!("rms, {unit}"),
            &format!("rms, {unit}"),
        ]);
        let column =
            |of: &dyn Fn(&Axis) -> f64| aligned(&axes.iter().map(|axis| scale.of_rate(of(axis))).collect::<Vec<_>>());
        let drift = column(&|axis| axis.drift_pp);
        let in_sample = column(&|axis| axis.in_sample_rms.unwrap_or(f64::NAN));
        let held_out = column(&|axis| axis.held_out_rms.unwrap_or(f64::NAN));
        for (place, axis) in axes.iter().enumerate() {
            let [min, max] = axis.temperature;
            let range = from_to(min, max);
            grid.row([&axis.name, &axis.model, &range, &drift[place], &in_sample[place], &held_out[place]]);
        }
        page.grid(&grid);
    }
}

impl Axis {
    fn of(name: &str, axis: &AxisCalibration) -> Self {
        let fit = &axis.fit.statistics;
        Self {
            name: name.to_owned(),
            model: axis.fit.chosen_model(),
            rate_unit: axis.rate_unit,
            temperature: [axis.fit.measured.min(), axis.fit.measured.max()],
            drift_pp: axis.measured_drift().peak_to_peak(),
            in_sample_rms: Some(fit.in_sample.rms),
            held_out_rms: fit.held_out.map(|residual| residual.rms),
            residual_over: Some(fit.residual_over),
            trim: axis.trim.as_ref().map(|trim| Trim {
                counts_per_tap: trim.trim.line.counts_per_tap().0,
                taps_measured: trim.trim.measured.as_ref().map_or(0, |measured| measured.effects().len()),
                centre_counts: trim.trim.line.centre().0,
                dead_band_taps: trim.dead_band_taps,
                start_up_mode: trim.start_up_mode.name(),
            }),
            warnings: axis.warnings.clone(),
        }
    }
}

impl Trim {
    fn show(&self, axis: &str, page: &mut Page) {
        let measured = if self.taps_measured == 0 {
            "none measured by itself".to_owned()
        } else {
            format!("{} measured by themselves", self.taps_measured)
        };
        let text = format!(
            "a tap moves it by {} counts ({measured}), towards {:.1} counts; dead band {} taps; starts in mode {}",
            three_digits(self.counts_per_tap),
            self.centre_counts,
            self.dead_band_taps,
            self.start_up_mode
        );
        page.facts(&[(&format!("trim {axis}"), text)]);
    }
}
