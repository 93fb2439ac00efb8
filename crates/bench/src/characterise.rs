//! From an unknown unit to its law: the ramp and its fit, the trim experiment and its fit, the two composed.

use zerorate_cal::compose::{Composed, chatter_warning, compose, compose_axis, steepest_slope_taps};
use zerorate_cal::log_fit::{AxisFit, FitOptions};
use zerorate_cal::quality::{Judgement, Verdict};
use zerorate_cal::recorded::{RampGroup, RampMeans, fit_axis};
use zerorate_cal::trim_fit::{TrimFit, fit_trim, tap_effects};
use zerorate_core::compensate::Mode;
use zerorate_core::drift::{HistoryState, evaluate_dynamic};
use zerorate_core::record::DeviceRecord;
use zerorate_core::trim::TapEffects;
use zerorate_core::units::{Axis, Celsius, Counts, Seconds, Taps, TemperatureScale};
use zerorate_core::wire::Request;

use crate::error::BenchError;
use crate::evaluate::drift_pp;
use crate::instruments::Witness;
use crate::kept::Kept;
use crate::procedure::{full_temperature, trim_experiment};
use crate::run::{Recorder, Session, Taken, row};

/// What is known of one axis before it is compensated.
#[derive(Debug, Clone)]
pub struct AxisCharacter {
    /// The drift and how well it holds.
    pub drift: AxisFit,
    /// What the device would take off at each group of the ramp, had it begun with the first, counts.
    pub predicted: Vec<f64>,
    /// The trim part's line, both ways.
    pub trim: TrimFit,
    /// What each tap of the working range does.
    pub effects: TapEffects,
    /// The law, and whether the wiper can follow it.
    pub composed: Composed,
    /// Zero-rate output over the ramp's hour, counts peak to peak.
    pub drift_pp_counts: f64,
    /// The plant's truth: the largest distance of the fitted curve from the deterministic drift of this run, counts.
    pub curve_error_counts: Option<f64>,
    /// The plant's truth: the slope of the taps that the experiment used, taps per count.
    pub plant_slope_taps_per_count: Option<f64>,
}

/// What is known of a unit before it is compensated.
#[derive(Debug, Clone)]
pub struct Character {
    /// The groups of the full-temperature test's hour.
    pub ramp: Vec<Taken>,
    /// Chamber time of the full-temperature test, its soak included.
    pub ramp_time: Seconds,
    /// X and Y.
    pub axes: [AxisCharacter; 2],
    /// The record for the device.
    pub record: DeviceRecord,
    /// What to look at, a sentence each.
    pub warnings: Vec<String>,
}

/// The full-temperature test, as it is kept.
pub const FULL_TEMPERATURE: &str = "full-temperature";
/// The trim experiment, as it is kept.
pub const TRIM_SWEEP: &str = "trim-sweep";

/// Stores the middle tap for power-up, on a simulated board, which is always new. On a real one that is done once, when
/// it is first set up (the register wears): it is advised.
///
/// # Errors
/// [`BenchError`].
pub fn first_time(session: &mut Session<'_>) -> Result<(), BenchError> {
    if !session.bench.surroundings.obeys() {
        session.progress.note("a new board? `zerorate device first-time` makes the middle tap that of power-up, once");
        return Ok(());
    }
    session.begin()?;
    session.bench.device.order(Request::StorePowerUpTap)?;
    Ok(())
}

/// The full-temperature test and the trim experiment, each into its recording; their fits, and the composed record.
///
/// # Errors
/// [`BenchError`].
pub fn characterise(
    session: &mut Session<'_>,
    serial: &str,
    full: Recorder,
    sweep: Recorder,
) -> Result<Character, BenchError> {
    characterise_once(session, serial, full, sweep, &Kept::nothing())
}

/// The same, of what was not carried through before.
///
/// # Errors
/// [`BenchError`].
pub fn characterise_once(
    session: &mut Session<'_>,
    serial: &str,
    mut full: Recorder,
    mut sweep: Recorder,
    kept: &Kept,
) -> Result<Character, BenchError> {
    let (ramp, ramp_time) = kept.once(FULL_TEMPERATURE, &mut full, |full| {
        let began = session.elapsed;
        let ramp = full_temperature::run(session, full)?;
        // A ramp that is rejected is not kept, so that the run can go on with another.
        Axis::BOTH.into_iter().try_for_each(|axis| fit_ramp(session, &ramp, axis).map(|_| ()))?;
        Ok((ramp, session.elapsed - began))
    })?;
    full.finish()?;
    let [x, y] = Axis::BOTH.map(|axis| fit_ramp(session, &ramp, axis));
    let drifts = [x?, y?];

    let measured = kept.once(TRIM_SWEEP, &mut sweep, |sweep| {
        trim_experiment::run(session, [extremes(&drifts[0]), extremes(&drifts[1])], sweep)
    })?;
    sweep.finish()?;

    let mut warnings = Vec::new();
    let mut axes = Vec::new();
    for (axis, drift) in Axis::BOTH.into_iter().zip(drifts) {
        let points = &measured.points[axis.index()];
        let setup = session.setup;
        let failed = |reason: String| BenchError::Fit { axis, reason };
        let trim = fit_trim(points, setup.centre(), setup.middle()).map_err(|error| failed(error.to_string()))?;
        let effects =
            tap_effects(&measured.sweep[axis.index()], setup.middle()).map_err(|error| failed(error.to_string()))?;
        let model = trim.trim(setup.centre(), Some(effects.clone())).map_err(|error| failed(error.to_string()))?;
        let dead_band = setup.trim.dead_band_taps;
        let scale = TemperatureScale::QUARTER_COUNTS;
        let composed = compose_axis(drift.drift.clone(), model, dead_band, setup.low_pass(), Mode::Hybrid, scale)
            .map_err(|error| failed(error.to_string()))?
            .with_history(drift.history.clone(), setup.group_period().0);
        let name = axis.name().to_uppercase();
        if let Some(digital_only) = &composed.digital_only {
            warnings.push(format!("axis {name}: {digital_only}"));
        }
        let noise = temperature_noise(&ramp, axis);
        let law = &composed.model;
        if let Some(warning) = chatter_warning(noise, steepest_slope_taps(&law.drift, &law.trim.line), dead_band) {
            warnings.push(format!("axis {name}: {warning}"));
        }
        axes.push(AxisCharacter {
            drift_pp_counts: drift_pp(&ramp, axis),
            predicted: predictions(&drift, ramp.iter().map(|taken| (taken.time.0, taken.temperature(axis).0))),
            curve_error_counts: curve_error(&ramp, axis, &drift),
            plant_slope_taps_per_count: session.bench.witness.as_deref().map(|w| plant_slope(w, axis, &trim)),
            drift,
            trim,
            effects,
            composed,
        });
    }
    let axes: [AxisCharacter; 2] =
        axes.try_into().map_err(|_| BenchError::Fit { axis: Axis::X, reason: "an axis is missing".into() })?;
    let models = [axes[0].composed.model.clone(), axes[1].composed.model.clone()];
    let record = compose(serial, TemperatureScale::QUARTER_COUNTS, &models)
        .map_err(|error| BenchError::Compose(error.to_string()))?;
    Ok(Character { ramp, ramp_time, axes, record, warnings })
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
        let reasons: Vec<String> = rejecting.map(|reason| reason.text).collect();
        BenchError::Rejected { reasons: reasons.join("; ") }
    })
}

/// What the device would take off at each of some times, seconds, and temperatures, counts, had it begun with the first.
fn predictions(fit: &AxisFit, groups: impl Iterator<Item = (f64, f64)>) -> Vec<f64> {
    let (mut state, mut before) = (HistoryState::default(), f64::NAN);
    let predict = |(time_s, temperature): (f64, f64)| {
        if let Some(history) = &fit.history {
            history.advance(&fit.drift, &mut state, temperature, time_s - before);
            before = time_s;
        }
        evaluate_dynamic(&fit.drift, fit.history.as_ref(), &state, temperature).0
    };
    groups.map(predict).collect()
}

/// The lowest and the highest reading of a drift.
fn extremes(fit: &AxisFit) -> [Counts; 2] {
    let valid = fit.drift.valid;
    let ends = [valid.min(), valid.max()].into_iter().chain(fit.drift.turning_points());
    let readings = ends.map(|temperature| fit.drift.evaluate(temperature).0);
    let (least, most) = readings.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(v), m.max(v)));
    [Counts(least), Counts(most)]
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
    let predicted = predictions(fit, truths.iter().map(|(time_s, truth)| (*time_s, truth.temperature_counts)));
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
