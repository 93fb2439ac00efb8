//! What speaks against a unit.

use zerorate_fit::folds::FOLDS;
use zerorate_fit::residual::Residuals;

use super::{AxisSurvey, FoldSurvey};
use crate::log_fit::FitOptions;
use crate::quality::{Judgement, Reason, ReasonKind};
use crate::units::TemperatureUnit;

/// A fold with fewer groups is not searched for stuck values: chance could make them equal.
const SEARCHED: u64 = 8;

/// One group in so many may be lost.
const MAY_BE_LOST: u64 = 100;

/// Of a span of groups at least one in so many must be there.
const LEAST_SHARE: u64 = 2;

/// Distances this many times the rms are far: of a million groups of noise not one is further than 5.
const FAR: f64 = 6.0;

/// No distance is far that is less than a step of the converter: a reading without noise moves by such.
const CONVERTERS_STEP_COUNTS: f64 = 1.0;

/// The kurtosis above which a few distances dwarf the others; noise has 3.
const KURTOSIS: f64 = 12.0;

/// Judges what an axis's ramps have to offer, before a fit. `expected` is the number of groups that the set-up gives a
/// ramp.
pub fn judge_survey(
    judgement: &mut Judgement,
    axis: &str,
    survey: &AxisSurvey,
    expected: Option<u64>,
    options: &FitOptions,
) {
    let groups = survey.groups();
    judgement.rows(axis, groups, "group", options.model.least_coefficients());
    if groups == 0 {
        return;
    }
    let (min, max) = survey.temperature();
    judgement.span(min, max, TemperatureUnit::Counts, options.allow_narrow);
    let searched = || survey.folds.iter().filter(|fold| fold.groups >= SEARCHED);
    let stands = |of: fn(&FoldSurvey) -> (f64, f64)| {
        let still = |fold: &&FoldSurvey| (of(fold).1 - of(fold).0).abs() <= 0.0;
        (searched().filter(still).count(), searched().find(still).map_or(f64::NAN, |fold| of(fold).0))
    };
    let (still, at) = stands(|fold| fold.temperature);
    let named = judgement.reasons.iter().any(|reason| reason.kind == ReasonKind::StuckTemperature);
    if still > 0 && !named {
        let text = format!(
            "{axis}: the temperature stands at {at:.2} counts for {still} of the ramp's {FOLDS} folds: its sensor is stuck"
        );
        judgement.add(Reason::new(ReasonKind::StuckTemperature, text));
    }
    let (still, at) = stands(|fold| fold.reading);
    if still > 0 {
        let text = format!(
            "{axis}: the reading stands at {at:.2} counts for {still} of the ramp's {FOLDS} folds: its line is stuck"
        );
        judgement.add(Reason::new(ReasonKind::StuckReading, text));
    }
    if survey.saturated > 0 {
        let text = format!("{axis}: {} of {groups} groups are at an end of the converter", survey.saturated);
        judgement.add(Reason::new(ReasonKind::Saturated, text));
    }
    if let Some((lowest, highest)) = survey.taps.filter(|(lowest, highest)| lowest < highest) {
        let text = format!(
            "{axis}: the wiper moved between taps {lowest} and {highest}, so the reading is not the gyro's drift alone: fit the recording of the full-temperature test, in which it stays"
        );
        judgement.add(Reason::new(ReasonKind::WiperMoved, text));
    }
    let taken = survey.span.1 - survey.span.0 + 1;
    if taken > LEAST_SHARE * groups {
        let text = format!(
            "{axis}: {groups} groups are there of the {taken} from {} to {}: their numbers are damaged, or most were lost",
            survey.span.0, survey.span.1
        );
        judgement.add(Reason::new(ReasonKind::LostGroups, text));
    }
    if survey.repeated > 0 {
        let text =
            format!("{axis}: {} of {groups} groups have a number that another has: they are damaged", survey.repeated);
        judgement.add(Reason::new(ReasonKind::LostGroups, text));
    }
    let Some(expected) = expected else { return };
    if taken < expected {
        let text = format!("the recording ends after {taken} of its ramp's {expected} groups: the run was cut");
        judgement.add(Reason::new(ReasonKind::CutRun, text));
    } else if groups + groups / MAY_BE_LOST < expected {
        // What stood between two ramps is in the span as well.
        let text =
            format!("{groups} of its ramps' {expected} groups are there: the others were lost, or the run was cut");
        judgement.add(Reason::new(ReasonKind::CutRun, text));
    }
}

/// Judges how far the groups of an axis are from the groups beside them ([`distances`](super::neighbours::distances)).
pub(super) fn judge_distances(judgement: &mut Judgement, axis: &str, distances: &Residuals) {
    let (largest, rms, kurtosis) = (distances.largest(), distances.rms(), distances.kurtosis());
    if largest > CONVERTERS_STEP_COUNTS.max(FAR * rms) && kurtosis > KURTOSIS {
        let text = format!(
            "{axis}: groups lie up to {largest:.0} counts from the groups beside them, {:.0} times the rms: a few outliers among groups that agree (kurtosis {kurtosis:.0}; noise has 3)",
            largest / rms
        );
        judgement.add(Reason::new(ReasonKind::Outliers, text));
    }
}
