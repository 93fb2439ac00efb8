//! The ramp's curve beside the soaks, which no fit has seen.

use zerorate_cal::summary::{AxisSoaks, Check, SoakPoint, Soaks};
use zerorate_core::units::{Axis, Seconds};

use crate::evaluate::extremes;
use crate::measure::Measured;
use crate::procedure::soaks;
use crate::setup::{Limits, SetUp};
use crate::verify::at_most;

/// The comparison; `None` where no soak was made.
#[must_use]
pub fn compared(soaks: &soaks::Soaks, setup: &SetUp, measured: &Measured) -> Option<Soaks> {
    let hours = |time: Seconds| time.0 / 3600.0;
    let [ramp_hours, soak_hours] = [measured.ramp_time, soaks.chamber_time].map(hours);
    (!soaks.points.is_empty()).then(|| Soaks {
        ramp_hours,
        soak_hours,
        hours_saved: soak_hours - ramp_hours,
        axes: Axis::BOTH.map(|axis| (axis.name().to_owned(), of_axis(soaks, setup, measured, axis))).into(),
    })
}

fn of_axis(soaks: &soaks::Soaks, setup: &SetUp, measured: &Measured, axis: Axis) -> AxisSoaks {
    let drift = measured.axes[axis.index()].drift.calibration.drift();
    let points: Vec<SoakPoint> = setup
        .chamber
        .soaks_c
        .iter()
        .zip(&soaks.points)
        .map(|(&chamber_c, point)| {
            let (temperature, zro) = point[axis.index()];
            let ramp_counts = drift.evaluate(temperature.0).0;
            SoakPoint { chamber_c, temperature_counts: temperature.0, zro_counts: zro.0, ramp_counts }
        })
        .collect();
    let ramp = measured.ramp.iter().map(|taken| taken.temperature(axis).0);
    let [coldest, hottest] = extremes(ramp);
    let inside = points.iter().filter(|soak| (coldest..=hottest).contains(&soak.temperature_counts));
    let max_difference_counts = inside.map(|soak| (soak.zro_counts - soak.ramp_counts).abs()).reduce(f64::max);
    AxisSoaks { max_difference_counts, points }
}

/// Holds the differences against the limit.
#[must_use]
pub fn check(soaks: &Soaks, limits: &Limits) -> Vec<Check> {
    let limit = limits.soak_difference_counts;
    let axes = soaks.axes.iter().filter_map(|(axis, soaks)| Some((axis, soaks.max_difference_counts?)));
    let what = |axis: &str| format!("{}, soaks: largest distance from the ramp's curve", axis.to_uppercase());
    axes.map(|(axis, difference)| at_most(what(axis), limit, difference)).collect()
}
