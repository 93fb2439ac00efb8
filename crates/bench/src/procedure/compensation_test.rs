//! The compensation test (paper, S11): the profile of the full-temperature test once more, one axis compensated, the
//! other left alone as the control; and the cooling ramp after it, where hysteresis does not cancel.

use serde::{Deserialize, Serialize};
use zerorate_core::compensate::Mode;
use zerorate_core::units::{Axis, Seconds};
use zerorate_core::wire::{Request, SampleWindow};

use crate::error::BenchError;
use crate::run::{Phase, Recorder, Session, Taken};
use crate::steps;

/// The groups of one test.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TestRun {
    /// The mode of the compensated axis.
    pub mode: Mode,
    /// The compensated axis; the other is the control.
    pub axis: Axis,
    /// The heating ramp.
    pub heating: Vec<Taken>,
    /// The cooling ramp; empty where none was asked for.
    pub cooling: Vec<Taken>,
}

/// How much of the test is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// Whether the cooling ramp follows.
    pub cooling: bool,
    /// Whether samples are streamed, to see what a tap change does to them.
    pub samples: bool,
}

/// Runs the test on a device that has its calibration.
///
/// The compensated axis finds its tap at the end of the soak, before the ramp begins. If the control then reads what the
/// full-temperature test did not read there (`before`), it is told: a supply left in the gyros' place would cost the whole test.
///
/// # Errors
/// [`BenchError`].
pub fn run(
    session: &mut Session<'_>,
    before: &[Taken],
    mode: Mode,
    axis: Axis,
    extent: Extent,
    recorder: &mut Recorder,
) -> Result<TestRun, BenchError> {
    let [cold, hot] = session.setup.ends();
    let chamber = &session.setup.chamber;
    let (soak, soak_groups, ramp_groups) = (Seconds(chamber.soak_s), chamber.soak_groups, chamber.ramp_groups);
    session.begin()?;
    session.bench.device.order(Request::SetMode { axis, mode })?;
    session.soak("cold soak", cold, soak)?;
    session.start(if extent.samples { steps::window(axis, session.first_second()) } else { SampleWindow::NONE })?;
    let name =
        |direction: &str| format!("compensation test, {} {}, {direction}", axis.name().to_uppercase(), mode.name());
    session.phase(&name("heating"), ramp_groups);
    let soak = session.until(soak_groups, Phase::Soak, recorder)?;
    if let Some(doubt) = soak.last().and_then(|last| control_is_elsewhere(before, last, axis.other())) {
        let told = session.warnings.add(doubt);
        session.progress.note(&told);
    }
    let heating = session.ramp(hot, ramp_groups, Phase::Heating, recorder)?;
    let mut cooling = Vec::new();
    if extent.cooling {
        session.phase(&name("cooling"), ramp_groups);
        cooling = session.ramp(cold, ramp_groups, Phase::Cooling, recorder)?;
    }
    session.stop()?;
    recorder.next_run();
    Ok(TestRun { mode, axis, heating, cooling })
}

/// What is told of a control that is more than half of its drift away from what it read at the same temperature before.
fn control_is_elsewhere(before: &[Taken], now: &Taken, control: Axis) -> Option<String> {
    let temperature = now.temperature(control).0;
    let from_there = |taken: &&Taken| (taken.temperature(control).0 - temperature).abs();
    let then = before.iter().min_by(|a, b| from_there(a).total_cmp(&from_there(b)))?.zro(control).0;
    let readings = || before.iter().map(|taken| taken.zro(control).0);
    let drift = readings().fold(f64::NEG_INFINITY, f64::max) - readings().fold(f64::INFINITY, f64::min);
    let reads = now.zro(control).0;
    ((reads - then).abs() > 0.5 * drift).then(|| {
        format!(
            "{}, which is not compensated, reads {reads:.0} counts after the soak, and in the full-temperature test it read {then:.0} there: are the gyros connected, and is the supply off? Ctrl-C stops the run; --resume goes on with this test",
            control.name().to_uppercase()
        )
    })
}
