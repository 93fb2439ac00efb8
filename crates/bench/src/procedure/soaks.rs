//! The traditional test, to compare with: one soak after another, each until everything inside is at one temperature.

use serde::{Deserialize, Serialize};
use zerorate_core::units::{Axis, Celsius, Counts, Seconds};
use zerorate_core::wire::SampleWindow;

use crate::error::BenchError;
use crate::run::{Phase, Recorder, Session, Taken};

/// Groups averaged at the end of each soak: one minute of the paper's.
const GROUPS: u32 = 40;

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
    let temperatures = session.setup.chamber.soaks_c.clone();
    let hold = Seconds(session.setup.chamber.soak_s);
    session.begin()?;
    let mut points = Vec::with_capacity(temperatures.len());
    let began = session.elapsed;
    for (index, &temperature) in temperatures.iter().enumerate() {
        let what = format!("soak {} of {} at {temperature:.0} C", index + 1, temperatures.len());
        session.soak(&what, Celsius(temperature), hold)?;
        session.start(SampleWindow::NONE)?;
        let taken = session.until(GROUPS, Phase::Soak, recorder)?;
        session.stop()?;
        recorder.next_run();
        points.push(Axis::BOTH.map(|axis| mean(&taken, axis)));
    }
    Ok(Soaks { points, chamber_time: session.elapsed - began })
}

fn mean(taken: &[Taken], axis: Axis) -> (Counts, Counts) {
    #[allow(clippy::cast_precision_loss)]
    let n = taken.len() as f64;
    let sum = |of: fn(&Taken, Axis) -> Counts| taken.iter().map(|t| of(t, axis).0).sum::<f64>() / n;
    (Counts(sum(Taken::temperature)), Counts(sum(Taken::zro)))
}
