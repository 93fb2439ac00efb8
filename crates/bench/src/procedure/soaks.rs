//! The traditional test, to compare with: one soak after another, each until everything inside is at one temperature.
//! Uncompensated, both wipers at the middle tap, as on the ramp.

use serde::{Deserialize, Serialize};
use zerorate_core::units::{Axis, Celsius, Counts, Seconds};
use zerorate_core::wire::SampleWindow;

use crate::checkpoint::Checkpoints;
use crate::error::BenchError;
use crate::plan::Part;
use crate::run::{Extent, Phase, Recorder, Session, Taken};
use crate::setup::GROUPS_A_SOAK;

/// What a soak came to.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Soak {
    /// Mean temperature and zero-rate reading of X and Y.
    pub means: [(Counts, Counts); 2],
    /// Chamber time from the way to it to its end.
    pub chamber_time: Seconds,
    /// Where the chamber was sent.
    pub set_point: Celsius,
}

/// Soaks at every temperature of the set-up that the ramp covers, one hour each, and takes a minute of groups at the
/// end of each.
///
/// # Errors
/// [`BenchError`].
pub fn run(session: &mut Session<'_>, recorder: &mut Recorder) -> Result<Vec<Soak>, BenchError> {
    run_once(session, recorder, &Checkpoints::none())
}

/// How far the recording had got when the last of the soaks that are kept was done.
#[must_use]
pub fn extent(kept: &Checkpoints, soaks: usize) -> Option<Extent> {
    (0..soaks).rev().find_map(|index| kept.extent(&name(index)))
}

/// The share of them that is still to do, 0 to 1.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn left(kept: &Checkpoints, soaks: usize) -> f64 {
    let left = (0..soaks).filter(|&index| kept.extent(&name(index)).is_none()).count();
    left as f64 / soaks.max(1) as f64
}

fn name(index: usize) -> String {
    format!("soak-{}", index + 1)
}

/// The same, of the soaks that were not carried through before.
///
/// # Errors
/// [`BenchError`].
pub fn run_once(
    session: &mut Session<'_>,
    recorder: &mut Recorder,
    kept: &Checkpoints,
) -> Result<Vec<Soak>, BenchError> {
    let temperatures = session.setup.soaks();
    let hold = Seconds(session.setup.chamber.soak_s);
    let is_left = (0..temperatures.len()).any(|index| kept.extent(&name(index)).is_none());
    if is_left {
        session.part(Part::Soaks);
    }
    // On a bench that obeys, every run begins alike.
    if session.bench.power.obeys() || is_left {
        session.begin()?;
    }
    let mut soaks = Vec::with_capacity(temperatures.len());
    for (index, &set_point) in temperatures.iter().enumerate() {
        let what = format!("soak {} of {} at {} C", index + 1, temperatures.len(), set_point.0);
        soaks.push(kept.once(&name(index), recorder, |recorder| {
            let began = session.elapsed;
            session.soak(&what, set_point, hold)?;
            session.start(SampleWindow::NONE)?;
            let taken = session.until(GROUPS_A_SOAK, Phase::Soak, recorder)?;
            session.stop()?;
            recorder.next_run();
            let means = Axis::BOTH.map(|axis| mean(&taken, axis));
            Ok(Soak { means, chamber_time: session.elapsed - began, set_point })
        })?);
    }
    Ok(soaks)
}

fn mean(taken: &[Taken], axis: Axis) -> (Counts, Counts) {
    #[allow(clippy::cast_precision_loss)]
    let n = taken.len() as f64;
    let sum = |of: fn(&Taken, Axis) -> Counts| taken.iter().map(|t| of(t, axis).0).sum::<f64>() / n;
    (Counts(sum(Taken::temperature)), Counts(sum(Taken::zro)))
}
