//! What curve and taps leave of the groups of an axis's tests.

use zerorate_core::compensate::Mode;
use zerorate_core::drift::ValidRange;
use zerorate_core::trim::Trim;
use zerorate_core::units::{Axis, Taps};

use crate::folder::BoardRun;
use zerorate_cal::calibration::AxisCalibration;
use zerorate_cal::compose::steepest_slope;
use zerorate_recording::{GroupRow, Phase, Recording};

/// One group of a test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Left {
    pub group: u32,
    /// Its temperature reading, counts.
    pub temperature: f64,
    /// The reading less the measured effect of its tap and less the fitted drift, counts: what is left whatever the mode.
    pub counts: f64,
    pub tap: u16,
}

/// One switch-on: a heating ramp, and the cooling ramp after it where one was recorded.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Run {
    pub heating: Vec<Left>,
    pub cooling: Vec<Left>,
}

/// The tests of an axis, as the compensated one and as the control.
pub(super) struct AxisTests<'a> {
    pub axis: Axis,
    pub runs: Vec<Run>,
    /// The temperatures that were fitted, counts.
    pub measured: ValidRange,
    /// The step of the temperature that the law sees, counts; 0 where none is known.
    pub step: f64,
    /// Without sign.
    pub counts_per_tap: f64,
    pub dead_band_taps: f64,
    calibration: &'a AxisCalibration,
    run: &'a BoardRun,
}

impl<'a> AxisTests<'a> {
    /// `None` where the files do not tell of the axis.
    pub(super) fn of(run: &'a BoardRun, axis: Axis) -> Option<Self> {
        let calibration = run.calibration.axes.get(axis.name())?;
        let own = calibration.trim.as_ref()?;
        let trim = &own.trim;
        let of_recording = |recording: &'a Recording| {
            Axis::BOTH.map(|compensated| of_run(&switched_on(recording, compensated, axis), calibration, trim))
        };
        Some(Self {
            axis,
            runs: run.tests.iter().flat_map(of_recording).filter(|run| !run.heating.is_empty()).collect(),
            measured: calibration.fit.measured,
            step: run.calibration.temperature_scale.map_or(0.0, |scale| scale.step),
            counts_per_tap: trim.line.counts_per_tap().0.abs(),
            dead_band_taps: own.dead_band_taps,
            calibration,
            run,
        })
    }

    /// Every ramp of them.
    pub(super) fn ramps(&self) -> impl Iterator<Item = &[Left]> {
        self.runs.iter().flat_map(|run| [&run.heating[..], &run.cooling[..]])
    }

    /// The heating ramps.
    pub(super) fn heating(&self) -> impl Iterator<Item = &[Left]> {
        self.runs.iter().map(|run| &run.heating[..])
    }

    /// The modes in which the axis was compensated while it heated, in the order of the tests.
    pub(super) fn modes(&self) -> Vec<Mode> {
        let mut modes = Vec::new();
        let rows = self.run.tests.iter().flat_map(|recording| &recording.rows);
        for row in rows.filter(|row| row.axis == self.axis && row.phase == Phase::Heating && row.mode != Mode::Off) {
            if !modes.contains(&row.mode) {
                modes.push(row.mode);
            }
        }
        modes
    }

    /// The fitted curve's steepest slope over the measured range, counts a count, without sign.
    pub(super) fn steepest_slope(&self) -> f64 {
        steepest_slope(self.calibration.drift(), self.measured)
    }

    /// How samples scatter within a group of the tests, counts rms.
    pub(super) fn sample_scatter(&self) -> f64 {
        let rows = self.run.tests.iter().flat_map(|recording| &recording.rows);
        let (mut variances, mut groups) = (0.0, 0.0);
        for sums in rows.filter(|row| row.axis == self.axis && row.sums.n > 0).map(|row| row.sums) {
            let (n, sum, squares) = (u128::from(sums.n), u128::from(sums.zro), u128::from(sums.zro_sq));
            // In integers, so that nothing cancels.
            #[allow(clippy::cast_precision_loss)]
            let variance = (n * squares).saturating_sub(sum * sum) as f64 / (n * n) as f64;
            variances += variance;
            groups += 1.0;
        }
        (variances / f64::max(groups, 1.0)).sqrt()
    }
}

/// An axis's rows of the test in which this axis was compensated.
fn switched_on(recording: &Recording, compensated: Axis, axis: Axis) -> Vec<&GroupRow> {
    let groups = recording.rows.chunk_by(|a, b| a.group == b.group);
    let is_of_the_test = |group: &&[GroupRow]| group.iter().any(|row| row.axis == compensated && row.mode != Mode::Off);
    groups.filter(is_of_the_test).flatten().filter(|row| row.axis == axis && row.sums.n > 0).collect()
}

fn of_run(rows: &[&GroupRow], calibration: &AxisCalibration, trim: &Trim) -> Run {
    let temperature = |row: &GroupRow| row.sums.mean_temperature().0;
    // The soak before the ramp too: a history begins there.
    let fitted = calibration.fit.model.biases(rows.iter().map(|row| (row.t_s, temperature(row))));
    let mut run = Run::default();
    for (row, fitted) in rows.iter().zip(fitted) {
        let ramp = match row.phase {
            Phase::Heating => &mut run.heating,
            Phase::Cooling => &mut run.cooling,
            Phase::Soak | Phase::Supply => continue,
        };
        let Some(tap) = Taps::new(row.tap) else { continue };
        let counts = row.sums.mean_zro().0 - trim.effect(tap).0 - fitted;
        ramp.push(Left { group: row.group, temperature: temperature(row), counts, tap: row.tap });
    }
    run
}
