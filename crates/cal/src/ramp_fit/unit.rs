//! The verdict on a unit from the ramps of its axes: one for a recording alone and for one of a lot.

use zerorate_core::units::Axis;

use super::{RampMeans, fit_axis, verdict_of};
use crate::log_fit::{AxisFit, AxisVerdict, FitOptions, one_way};
use crate::quality::{Judgement, Reason};

/// A unit, judged and fitted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct UnitFit {
    /// The verdict on the unit. A reason of one axis names it, one that the axes share names them all.
    pub judgement: Judgement,
    /// The verdict on each axis.
    pub verdicts: Vec<AxisVerdict>,
    /// The axes that could be fitted, of a rejected unit too: to be looked at.
    pub axes: Vec<AxisFit>,
}

impl UnitFit {
    /// Judges and fits the ramps of X and Y, each by itself. `expected` is the number of groups that the set-up gives a ramp.
    #[must_use]
    pub fn of(ramps: &[RampMeans; 2], expected: Option<u64>, options: &FitOptions) -> Self {
        let mut unit = Self::default();
        for (axis, means) in Axis::BOTH.into_iter().zip(ramps) {
            let mut judgement = Judgement::default();
            unit.axes.extend(fit_axis(axis.name(), means, expected, options, &mut judgement));
            unit.verdicts.push(AxisVerdict { name: axis.name().to_owned(), judgement });
        }
        for reason in shared(&unit.verdicts) {
            unit.judgement.add_as(verdict_of(&reason, options.allow_narrow), reason);
        }
        let measured = ramps.iter().filter(|means| !means.temperatures.is_empty());
        let passed = |means: &RampMeans| means.temperatures.iter().map(|temperature| (*temperature, true)).collect();
        // Each axis went the same way.
        one_way::reason(&measured.map(passed).collect::<Vec<_>>())
            .into_iter()
            .for_each(|reason| unit.judgement.add(reason));
        unit
    }
}

/// The reasons of all axes; what is said of several in the same words is said once, of all of them.
fn shared(verdicts: &[AxisVerdict]) -> Vec<Reason> {
    let mut all: Vec<(Vec<&str>, Reason)> = Vec::new();
    for AxisVerdict { name, judgement } in verdicts {
        for reason in &judgement.reasons {
            let text = reason.text.strip_prefix(&format!("{name}: ")).unwrap_or(&reason.text).to_owned();
            let bare = Reason { text, ..*reason };
            match all.iter_mut().find(|(_, other)| *other == bare) {
                Some((names, _)) => names.push(name),
                None => all.push((vec![name], bare)),
            }
        }
    }
    let named = |(names, reason): (Vec<&str>, Reason)| Reason {
        text: format!("{}: {}", names.join(", "), reason.text),
        ..reason
    };
    all.into_iter().map(named).collect()
}
