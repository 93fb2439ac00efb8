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

/// What the soaks came to.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Soaks {
    /// Mean temperature and zero-rate reading of X and Y at each soak.
    pub points: Vec<[(Counts, Counts); 2]>,
    /// Chamber time from the way to the first soak to the last one's end.
    pub chamber_time: Seconds,
}

/// Soaks at every temperature of the set-up, one hour each, and takes a minute of groups at the end of each.
///
/// # Errors
/// [`BenchError`].
pub fn run(session: &mut Session<'_>, recorder: &mut Recorder) -> Result<Soaks, BenchError> {
    run_once(session, recorder, &Checkpoints::none())
}

/// How far the recording had got when the last of the soaks that are kept was done.
#[must_use]
pub fn extent(kept: &Checkpoints, soaks: usize) -> Option<Extent> {
    (0..soaks).rev().find_map(|index| kept.extent(&name(index)))
}

fn name(index: usize) -> String {
    format!("soak-{}", index + 1)
}

/// The same, of the soaks that were not carried through before.
///
/// # Errors
/// [`BenchError`].
pub fn run_once(session: &mut Session<'_>, recorder: &mut Recorder, kept: &Checkpoints) -> Result<Soaks, BenchError> {
    let temperatures = session.setup.chamber.soaks_c.clone();
    let hold = Seconds(session.setup.chamber.soak_s);
    let is_left = (0..temperatures.len()).any(|index| kept.extent(&name(index)).is_none());
    if is_left {
        session.part(Part::Soaks);
    }
    // On a bench that obeys, every run begins alike.
    if session.bench.surroundings.obeys() || is_left {
        session.begin()?;
    }
    let mut points = Vec::with_capacity(temperatures.len());
    let began = session.elapsed;
    // What the soaks took that an earlier part of the run carried through.
    let mut earlier = Seconds(0.0);
    for (index, &temperature) in temperatures.iter().enumerate() {
        let what = format!("soak {} of {} at {temperature:.0} C", index + 1, temperatures.len());
        let before = session.elapsed;
        let (point, took) = kept.once(&name(index), recorder, |recorder| {
            session.soak(&what, Celsius(temperature), hold)?;
            session.start(SampleWindow::NONE)?;
            let taken = session.until(GROUPS_A_SOAK, Phase::Soak, recorder)?;
            session.stop()?;
            recorder.next_run();
            Ok((Axis::BOTH.map(|axis| mean(&taken, axis)), session.elapsed - before))
        })?;
        points.push(point);
        if session.elapsed.0.total_cmp(&before.0).is_eq() {
            earlier = earlier + took;
        }
    }
    Ok(Soaks { points, chamber_time: session.elapsed - began + earlier })
}

fn mean(taken: &[Taken], axis: Axis) -> (Counts, Counts) {
    #[allow(clippy::cast_precision_loss)]
    let n = taken.len() as f64;
    let sum = |of: fn(&Taken, Axis) -> Counts| taken.iter().map(|t| of(t, axis).0).sum::<f64>() / n;
    (Counts(sum(Taken::temperature)), Counts(sum(Taken::zro)))
}
