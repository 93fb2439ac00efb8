//! The full-temperature test (paper, S6): one heating ramp, both wipers at the middle tap.
//!
//! Soak an hour at the cold end, send the chamber to the hot end, record; the model is made from the first hour. Where the
//! set-up asks for it, the way back down is recorded as well, as long.

use zerorate_core::units::{Axis, Seconds};
use zerorate_core::wire::SampleWindow;

use crate::error::BenchError;
use crate::run::{Phase, Recorder, Session, Taken};

/// Runs the test and returns the groups of its ramps; the end of the soak is in the recording only.
///
/// # Errors
/// [`BenchError`].
pub fn run(session: &mut Session<'_>, recorder: &mut Recorder) -> Result<Vec<Taken>, BenchError> {
    let [cold, hot] = session.setup.ends();
    let chamber = &session.setup.chamber;
    let (soak, soak_groups, ramp_groups) = (Seconds(chamber.soak_s), chamber.soak_groups, chamber.ramp_groups);
    session.begin()?;
    session.soak("cold soak", cold, soak)?;
    session.start(SampleWindow::NONE)?;
    session.phase("full-temperature ramp", ramp_groups);
    session.until(soak_groups, Phase::Soak, recorder)?;
    let mut ramp = session.ramp(hot, ramp_groups, Phase::Heating, recorder)?;
    if chamber.cooling_ramp {
        session.phase("full-temperature ramp, cooling", ramp_groups);
        ramp.extend(session.ramp(cold, ramp_groups, Phase::Cooling, recorder)?);
    }
    session.stop()?;
    for axis in Axis::BOTH {
        if let Some(taken) = ramp.iter().find(|taken| taken.report.axes[axis.index()].saturated) {
            return Err(BenchError::Saturated {
                axis,
                whence: format!("at a temperature reading of {:.0} counts", taken.temperature(axis).0),
                remedy: "The drift leaves the converter's range at the middle tap: adjust the circuit's centre or gain",
            });
        }
    }
    Ok(ramp)
}
