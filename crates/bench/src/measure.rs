//! What is known of a unit before it is compensated: the full-temperature test and the trim experiment, their fits, and the
//! calibration composed of them.

use zerorate_cal::calibration::{AxisCalibration, Calibration, Kind, TrimCalibration};
use zerorate_cal::compose::{DigitalOnly, chatter_warning, steepest_slope_taps};
use zerorate_cal::log_fit::{AxisFit, FitOptions};
use zerorate_cal::quality::{Judgement, OR_ALLOW_NARROW, Verdict};
use zerorate_cal::ramp_fit::{RampGroup, RampMeans, fit_axis};
use zerorate_cal::units::TemperatureUnit;
use zerorate_core::drift::Drift;
use zerorate_core::record::{AxisModel, DeviceRecord};
use zerorate_core::trim::Trim;
use zerorate_core::units::{Axis, Celsius, Counts, Seconds, Taps};
use zerorate_core::wire::Request;
use zerorate_fit::trim::{TrimFit, fit_trim, tap_effects};

use crate::checkpoint::Checkpoints;
use crate::error::BenchError;
use crate::evaluate::{self, drift_pp};
use crate::instruments::Witness;
use crate::plan::Part;
use crate::procedure::trim_experiment::TrimMeasurements;
use crate::procedure::{full_temperature, trim_experiment};
use crate::run::{Phase, Recorder, Session, Taken, row};
use crate::setup::SetUp;

/// What is known of one axis before it is compensated.
#[derive(Debug, Clone)]
pub struct MeasuredAxis {
    /// The drift and how well it holds.
    pub drift: AxisFit,
    /// The trim part's line, both ways.
    pub trim: TrimFit,
    /// The law, as the record holds it.
    pub law: AxisModel,
    /// Set where the wiper cannot follow.
    pub digital_only: Option<DigitalOnly>,
    /// Zero-rate output over the heating ramp's hour, counts peak to peak.
    pub drift_pp_counts: f64,
    /// The plant's truth: the largest distance of the fitted curve from the deterministic drift of this run, counts.
    pub curve_error_counts: Option<f64>,
    /// The plant's truth: the slope of the taps that the experiment used, taps per count.
    pub plant_slope_taps_per_count: Option<f64>,
}

/// What is known of a unit before it is compensated.
#[derive(Debug, Clone)]
pub struct Measured {
    /// The groups of the full-temperature test's hour.
    pub ramp: Vec<Taken>,
    /// Chamber time of the full-temperature test, its soak included.
    pub ramp_time: Seconds,
    /// X and Y.
    pub axes: [MeasuredAxis; 2],
    /// What came of it.
    pub calibration: Calibration,
    /// The record for the device.
    pub record: DeviceRecord,
}

/// The full-temperature test, as a checkpoint.
pub const FULL_TEMPERATURE: &str = "full-temperature";
/// The trim experiment, as a checkpoint.
pub const TRIM_SWEEP: &str = "trim-sweep";

/// Stores the middle tap for power-up, on a simulated board, which is always new. On a real one that is done once, when
/// it is first set up (the register wears), by whoever sets it up.
///
/// # Errors
/// [`BenchError`].
pub fn first_time(session: &mut Session<'_>) -> Result<(), BenchError> {
    if session.bench.clock.is_none() {
        return Ok(());
    }
    session.begin()?;
    session.bench.device.order(Request::StorePowerUpTap)?;
    Ok(())
}

/// The full-temperature test and the trim experiment, each into its recording; their fits, and the calibration.
///
/// # Errors
/// [`BenchError`].
pub fn measure(
    session: &mut Session<'_>,
    serial: &str,
    full: Recorder,
    sweep: Recorder,
) -> Result<Measured, BenchError> {
    measure_on(session, serial, full, sweep, &Checkpoints::none())
}

/// The same, of what was not carried through before.
///
/// # Errors
/// [`BenchError`].
pub fn measure_on(
    session: &mut Session<'_>,
    serial: &str,
    mut full: Recorder,
    mut sweep: Recorder,
    checkpoints: &Checkpoints,
) -> Result<Measured, BenchError> {
    // What cannot be used is no checkpoint: it is judged before it is done with, and a run that goes on runs it again.
    let (ramp, ramp_time) = checkpoints.once(FULL_TEMPERATURE, &mut full, |full| {
        session.part(Part::FullTemperature);
        let began = session.elapsed;
        let ramp = full_temperature::run(session, full)?;
        Ok((ramp, session.elapsed - began))
    })?;
    let drifts = fit_ramps(session, &ramp).inspect_err(|_| checkpoints.withdraw(FULL_TEMPERATURE))?;
    full.finish()?;

    let measured = checkpoints.once(TRIM_SWEEP, &mut sweep, |sweep| {
        session.part(Part::TrimExperiment);
        trim_experiment::run(session, drifts.each_ref().map(|fit| extremes(fit.calibration.drift())), sweep)
    })?;
    let trims = fit_trims(session.setup, &measured).inspect_err(|_| checkpoints.withdraw(TRIM_SWEEP))?;
    sweep.finish()?;
    compose(session, serial, ramp, ramp_time, drifts, trims)
}

/// The trim of X and Y, and what a calibration keeps of it.
fn fit_trims(setup: &SetUp, measured: &TrimMeasurements) -> Result<Vec<(TrimFit, TrimCalibration)>, BenchError> {
    let mut trims = Vec::new();
    for axis in Axis::BOTH {
        let failed = |reason: &dyn std::fmt::Display| fit_error(axis, reason);
        let points = &measured.points[axis.index()];
        let trim = fit_trim(points, setup.centre(), setup.middle()).map_err(|error| failed(&error))?;
        let effects = tap_effects(&measured.sweep[axis.index()], setup.middle()).map_err(|error| failed(&error))?;
        let model = trim.trim(setup.centre(), Some(effects)).map_err(|error| failed(&error))?;
        let calibration = TrimCalibration {
            trim: model,
            points: trim.points.clone(),
            paired: Some(trim.paired),
            paper: Some(trim.paper),
            dead_band_taps: setup.trim.dead_band_taps,
            low_pass: setup.low_pass(),
            start_up_mode: setup.start_up_mode(),
        };
        trims.push((trim, calibration));
    }
    Ok(trims)
}

/// The calibration of what was fitted, and its record.
fn compose(
    session: &Session<'_>,
    serial: &str,
    ramp: Vec<Taken>,
    ramp_time: Seconds,
    drifts: [AxisFit; 2],
    trims: Vec<(TrimFit, TrimCalibration)>,
) -> Result<Measured, BenchError> {
    let with_trim = |(axis, (drift, (_, trim))): (Axis, (&AxisFit, &(TrimFit, TrimCalibration)))| {
        let calibration = AxisCalibration { trim: Some(trim.clone()), ..drift.calibration.clone() };
        (axis.name().to_owned(), calibration)
    };
    let axes = Axis::BOTH.into_iter().zip(drifts.iter().zip(&trims)).map(with_trim).collect();
    let mut calibration = Calibration {
        temperature_scale: Some(session.setup.temperature_scale()),
        board: Some(session.setup.board_scale()),
        group_period_s: Some(session.setup.group_period().0),
        labels: session.setup.labels.clone(),
        setup: serde_json::to_value(session.setup).ok(),
        ..Calibration::new(Kind::AnalogueBoard, Some(serial.to_owned()), Vec::new(), TemperatureUnit::Counts, axes)
    };
    let made = calibration.to_device_record().map_err(|error| BenchError::Compose(error.to_string()))?;
    let mut measured = Vec::new();
    for (((axis, drift), (trim, _)), law) in Axis::BOTH.into_iter().zip(drifts).zip(trims).zip(made.models) {
        let name = axis.name().to_uppercase();
        let digital_only = made.digital_only.iter().find(|(own, _)| *own == axis).map(|(_, why)| *why);
        if let Some(digital_only) = &digital_only {
            calibration.warnings.push(format!("axis {name}: {digital_only}"));
            let trim = calibration.axes.get_mut(axis.name()).and_then(|own| own.trim.as_mut());
            trim.into_iter().for_each(|trim| trim.start_up_mode = law.start_up_mode);
        } else {
            // A wiper that stands does not chatter.
            let slope = steepest_slope_taps(&law.drift, &law.trim.line);
            let warning = chatter_warning(temperature_noise(&ramp, axis), slope, law.dead_band);
            calibration.warnings.extend(warning.map(|warning| format!("axis {name}: {warning}")));
        }
        if let Some(warning) = uneven_taps(&law.trim) {
            calibration.warnings.push(format!("axis {name}: {warning}"));
        }
        measured.push(MeasuredAxis {
            drift_pp_counts: drift_pp(&ramp, axis, Phase::Heating).unwrap_or(f64::NAN),
            curve_error_counts: curve_error(&ramp, axis, &drift),
            plant_slope_taps_per_count: session.bench.witness.as_deref().map(|w| plant_slope(w, axis, &trim)),
            drift,
            trim,
            law,
            digital_only,
        });
    }
    let axes = measured.try_into().map_err(|_| fit_error(Axis::X, &"an axis is missing"))?;
    Ok(Measured { ramp, ramp_time, axes, calibration, record: made.record })
}

/// Where the slope by the supply's voltages is not that of the taps measured one by one: over a narrow span each point's half a
/// tap is a large part of it.
fn uneven_taps(trim: &Trim) -> Option<String> {
    /// A part's own unevenness is less.
    const ALIKE: f64 = 0.06;
    let effects = trim.measured.as_ref()?.effects();
    let (first, last) = (effects.first()?.0, effects.last()?.0);
    let (by_taps, by_voltages) = ((last - first) / (effects.len() - 1) as f64, trim.line.counts_per_tap().0.abs());
    let is_other = (by_voltages / by_taps - 1.0).abs() > ALIKE;
    is_other.then(|| {
        format!(
            "by the supply's voltages a tap is {by_voltages:.2} counts, and by the taps themselves {by_taps:.2}: over a narrow trim.span_counts a point's half a tap is a large part of it; if a wider one brings them no nearer, the part's own taps are uneven there, and each is corrected by its own"
        )
    })
}

fn fit_error(axis: Axis, reason: &dyn std::fmt::Display) -> BenchError {
    BenchError::Fit { axis, reason: reason.to_string() }
}

/// The drift of X and Y.
fn fit_ramps(session: &Session<'_>, ramp: &[Taken]) -> Result<[AxisFit; 2], BenchError> {
    let [x, y] = Axis::BOTH.map(|axis| fit_ramp(session, ramp, axis));
    Ok([x?, y?])
}

/// The fit of a ramp, judged as `zerorate fit` judges its recording.
fn fit_ramp(session: &Session<'_>, ramp: &[Taken], axis: Axis) -> Result<AxisFit, BenchError> {
    let mut means = RampMeans::default();
    for taken in ramp {
        let unknown = Celsius(f64::NAN);
        means.push(&RampGroup::from(&row(taken, axis, (taken.report.group.0, taken.time.0), unknown, unknown)));
    }
    let options = FitOptions { model: session.setup.model(), ..FitOptions::default() };
    let mut judgement = Judgement::default();
    let fit = fit_axis(axis.name(), &means, None, &options, &mut judgement);
    fit.filter(|_| !judgement.rejected()).ok_or_else(|| {
        let rejecting = judgement.reasons.into_iter().filter(|reason| reason.kind.verdict() == Verdict::Rejected);
        // A narrow range is allowed where a log is fitted, and not here.
        let reasons: Vec<String> = rejecting.map(|reason| reason.text.replace(OR_ALLOW_NARROW, "")).collect();
        BenchError::Rejected { reasons: reasons.join("; ") }
    })
}

/// The lowest and the highest reading of a drift.
fn extremes(drift: &Drift) -> [Counts; 2] {
    let valid = drift.valid;
    let ends = [valid.min(), valid.max()].into_iter().chain(drift.turning_points());
    let readings = ends.map(|temperature| drift.evaluate(temperature).0);
    evaluate::extremes(readings).map(Counts)
}

/// The noise of a group's mean temperature, counts rms: from the scatter of its samples.
fn temperature_noise(ramp: &[Taken], axis: Axis) -> f64 {
    let variance_of_mean = |taken: &Taken| {
        let sums = &taken.report.axes[axis.index()].sums;
        sums.variance_of_temperature() / f64::from(sums.n)
    };
    #[allow(clippy::cast_precision_loss)]
    let n = ramp.len() as f64;
    (ramp.iter().map(variance_of_mean).sum::<f64>() / n).sqrt()
}

fn curve_error(ramp: &[Taken], axis: Axis, fit: &AxisFit) -> Option<f64> {
    let truths: Option<Vec<_>> =
        ramp.iter().map(|taken| Some((taken.time.0, taken.truth.as_ref()?.axes[axis.index()].clone()))).collect();
    let truths = truths?;
    let at = truths.iter().map(|(time_s, truth)| (*time_s, truth.temperature_counts));
    let predicted = fit.calibration.fit.model.biases(at);
    let off = predicted.iter().zip(&truths).map(|(predicted, (_, truth))| (predicted - truth.drift_counts).abs());
    Some(off.fold(0.0, f64::max))
}

/// The slope of the plant's own taps over those that the experiment ended at, by least squares.
fn plant_slope(witness: &dyn Witness, axis: Axis, trim: &TrimFit) -> f64 {
    let taps = trim.points.iter().map(|point| point.tap.get());
    let (first, last) = taps.fold((u16::MAX, 0), |(first, last), tap| (first.min(tap), last.max(tap)));
    let truths: Vec<(f64, f64)> =
        (first..=last).filter_map(Taps::new).map(|tap| (f64::from(tap.get()), witness.tap_counts(axis, tap))).collect();
    #[allow(clippy::cast_precision_loss)]
    let n = truths.len() as f64;
    let (mean_tap, mean_counts) =
        (truths.iter().map(|t| t.0).sum::<f64>() / n, truths.iter().map(|t| t.1).sum::<f64>() / n);
    let products: f64 = truths.iter().map(|t| (t.0 - mean_tap) * (t.1 - mean_counts)).sum();
    let squares: f64 = truths.iter().map(|t| (t.0 - mean_tap) * (t.0 - mean_tap)).sum();
    -squares / products
}

#[cfg(test)]
mod tests {
    use zerorate_core::trim::{TapEffects, TrimLine};

    use super::*;

    /// Taps of 31 counts, and a line of so many.
    fn told(counts_per_tap: f64) -> Option<String> {
        let middle = Taps::new(511).unwrap();
        let effects: Vec<Counts> = (0..21).map(|tap| Counts(31.0 * f64::from(tap - 10))).collect();
        let measured = TapEffects::new(Taps::new(501).unwrap(), &effects);
        let line = TrimLine::new(-1.0 / counts_per_tap, 0.0, Counts(8200.0), middle).unwrap();
        uneven_taps(&Trim { line, measured })
    }

    #[test]
    fn a_slope_that_is_not_the_taps_own_is_told() {
        assert_eq!(told(31.5), None);
        assert!(told(34.3).unwrap().contains("a tap is 34.30 counts, and by the taps themselves 31.00"));
        assert!(told(28.0).is_some());
    }
}
