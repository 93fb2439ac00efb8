//! One axis of a board, as the files of its run tell of it.

use zerorate_board_run::folder::BoardRun;
use zerorate_board_run::summary::AxisSummary;
use zerorate_cal::calibration::{AxisCalibration, TrimCalibration};
use zerorate_cal::ramp_fit::RampMeans;
use zerorate_core::drift::Shape;
use zerorate_core::units::Axis;
use zerorate_fit::trim::TrimEstimate;

use crate::figure::Ink;
use crate::panels::{MINUTE_S, ink_of, name_of};

/// What stands in a run's files of one axis, and its ramp.
pub(super) struct BoardAxis<'a> {
    pub axis: Axis,
    /// As `X`.
    pub name: &'static str,
    pub ink: Ink,
    pub calibration: &'a AxisCalibration,
    pub summary: &'a AxisSummary,
    pub trim: &'a TrimCalibration,
    /// The trim's line by each point's own trimmed reading: the one that is deployed.
    pub paired: &'a TrimEstimate,
    /// The trim's line by the paper's formula.
    pub paper: &'a TrimEstimate,
    /// The group means of the full-temperature test.
    pub ramp: RampMeans,
    /// What the device would take off at each of them, had it been switched on with the first, counts.
    pub fitted: Vec<f64>,
}

impl<'a> BoardAxis<'a> {
    /// An axis of a run; `None` where a file does not tell of it.
    pub(super) fn of(run: &'a BoardRun, axis: Axis) -> Option<Self> {
        let calibration = run.calibration.axes.get(axis.name())?;
        let trim = calibration.trim.as_ref()?;
        let ramp = RampMeans::of(&run.full_temperature, axis);
        let rows = ramp.times_s.iter().copied().zip(ramp.temperatures.iter().copied());
        Some(Self {
            axis,
            name: name_of(axis),
            ink: ink_of(axis),
            calibration,
            summary: run.summary.axes.get(axis.name())?,
            trim,
            paired: trim.paired.as_ref()?,
            paper: trim.paper.as_ref()?,
            fitted: calibration.fit.model.biases(rows),
            ramp,
        })
    }

    /// The polynomial's coefficients, constant first; none of a table.
    pub(super) fn coefficients(&self) -> &[f64] {
        match self.calibration.drift().shape {
            Shape::Polynomial(_) => &self.summary.drift_raw_coefficients,
            Shape::Table(_) => &[],
        }
    }

    /// What the fit leaves of each group of the ramp, counts.
    pub(super) fn residuals(&self) -> impl Iterator<Item = f64> {
        self.ramp.readings.iter().zip(&self.fitted).map(|(reading, fitted)| reading - fitted)
    }

    /// Values of the ramp's groups over minutes since it began.
    pub(super) fn over_time(&self, values: &[f64]) -> Vec<(f64, f64)> {
        let began = self.ramp.times_s.first().copied().unwrap_or(0.0);
        let minutes = self.ramp.times_s.iter().map(|time_s| (time_s - began) / MINUTE_S);
        minutes.zip(values.iter().copied()).collect()
    }

    /// Values of the ramp's groups over their temperature.
    pub(super) fn over_temperature(&self, values: impl IntoIterator<Item = f64>) -> Vec<(f64, f64)> {
        self.ramp.temperatures.iter().copied().zip(values).collect()
    }

    /// The fitted curve, in order of temperature.
    pub(super) fn curve(&self) -> Vec<(f64, f64)> {
        let mut curve = self.over_temperature(self.fitted.iter().copied());
        curve.sort_by(|a, b| a.0.total_cmp(&b.0));
        curve
    }
}
