//! What is to be known of a verification, in words.

use super::VerifiedAxis;
use zerorate_cal::log_fit::LogFit;
use zerorate_cal::quality::{Judgement, Reason, ReasonKind};
use zerorate_cal::units::{RateScale, RateUnit, TemperatureUnit, WrittenRate};
use zerorate_fit::folds::TELLING;

/// A larger share of the log outside what was measured is told. Two runs of one chamber's ramp end a few averages apart, and
/// that is less.
const TOLD_OUTSIDE: f64 = 0.02;

/// Averages that are outside by less than this part of the range are at its end.
const AT_THE_END: f64 = 0.01;

/// Of less of the range than this a run says nothing of a calibration but there.
const MUCH: f64 = 0.5;

/// How much of what was calibrated a run tells of, where that is little: by the axis of which it is least.
pub(super) fn little_seen(axes: &[VerifiedAxis], unit: TemperatureUnit) -> Option<String> {
    let seen = |axis: &VerifiedAxis| {
        let ([from, to], [min, max]) = (axis.temperature, axis.calibrated_temperature);
        (to.min(max) - from.max(min)).max(0.0) / (max - min)
    };
    let least = axes.iter().filter(|axis| seen(axis) < MUCH).min_by(|a, b| seen(a).total_cmp(&seen(b)))?;
    let ([from, to], [min, max]) = (least.temperature, least.calibrated_temperature);
    Some(format!(
        "the log has {:.0} % of the temperatures that were calibrated, {from:.1} to {to:.1} of {min:.1} to {max:.1} {}: what is told holds there alone",
        100.0 * seen(least),
        unit.name()
    ))
}

/// The reasons: what is wrong with the log, then what the calibration does to it.
pub(super) fn reasons(
    fit: &LogFit,
    axes: &[VerifiedAxis],
    unit: TemperatureUnit,
    told_in: Option<WrittenRate>,
) -> Vec<Reason> {
    let of_log = fit.judgement.reasons.iter().filter(|reason| !is_of_a_fit_alone(reason)).cloned();
    let mut judgement = Judgement::default();
    of_log
        .chain(worse(axes, told_in))
        .chain(worse_from_a_zero(axes, told_in))
        .chain(outside(axes, unit))
        .for_each(|reason| judgement.add(reason));
    judgement.reasons
}

/// A narrow span, a hole in it, one direction, and how well the log's own curve does are no faults of a log that is not fitted.
fn is_of_a_fit_alone(reason: &Reason) -> bool {
    use ReasonKind::{NarrowSpan, OneDirection, Unmeasured, WorseThanUncorrected};
    matches!(reason.kind, NarrowSpan | OneDirection | Unmeasured | WorseThanUncorrected)
}

fn worse(axes: &[VerifiedAxis], told_in: Option<WrittenRate>) -> impl Iterator<Item = Reason> {
    let left = move |axis: &VerifiedAxis| left_of(axis, [axis.corrected.rms, axis.raw.rms], told_in);
    axes.iter().filter(|axis| axis.worse).map(move |axis| {
        let text = format!("{}: worse than uncorrected: {} that were recorded", axis.name, left(axis));
        Reason::new(ReasonKind::WorseThanUncorrected, text)
    })
}

/// An axis that is no worse about its mean, of which a device with its zero at the start has more left all the same.
fn worse_from_a_zero(axes: &[VerifiedAxis], told_in: Option<WrittenRate>) -> impl Iterator<Item = Reason> {
    let worse = |axis: &&VerifiedAxis| !axis.worse && axis.deployed.rms > TELLING * axis.uncorrected.rms;
    let left = move |axis: &VerifiedAxis| left_of(axis, [axis.deployed.rms, axis.uncorrected.rms], told_in);
    axes.iter().filter(worse).map(move |axis| {
        let text = format!("{}: less a zero at the start, worse than uncorrected: {}", axis.name, left(axis));
        Reason::new(ReasonKind::WorseThanUncorrected, text)
    })
}

fn left_of(axis: &VerifiedAxis, figures: [f64; 2], told_in: Option<WrittenRate>) -> String {
    left_of_rates(axis.rate_unit, figures, told_in)
}

fn left_of_rates(unit: RateUnit, [left, of]: [f64; 2], told_in: Option<WrittenRate>) -> String {
    let scale = RateScale::of(unit, &[left, of], told_in);
    let same = if scale.number(left) == scale.number(of) { " (more by less than the digits show)" } else { "" };
    format!("{} rms is left of {}{same}", scale.told(left), scale.number(of))
}

/// Axes of one range are told together, by the largest share.
fn outside(axes: &[VerifiedAxis], unit: TemperatureUnit) -> impl Iterator<Item = Reason> {
    let range = |axis: &VerifiedAxis| axis.calibrated_temperature.map(f64::to_bits);
    let mut told: Vec<(Vec<&str>, &VerifiedAxis)> = Vec::new();
    let is_beyond = |axis: &&VerifiedAxis| {
        let ([from, to], [min, max]) = (axis.temperature, axis.calibrated_temperature);
        (min - from).max(to - max) > AT_THE_END * (max - min)
    };
    for axis in axes.iter().filter(|axis| axis.outside > TOLD_OUTSIDE).filter(is_beyond) {
        match told.iter_mut().find(|(_, first)| range(first) == range(axis)) {
            Some((names, first)) => {
                names.push(&axis.name);
                if axis.outside > first.outside {
                    *first = axis;
                }
            }
            None => told.push((vec![&axis.name], axis)),
        }
    }
    told.into_iter().map(move |(names, axis)| {
        let [min, max] = axis.calibrated_temperature;
        let text = format!(
            "{}: {:.0} % of the averages are outside the {min:.1} to {max:.1} {} that were measured for the calibration: there the curve goes on as it ends, for a little, and is then held",
            names.join(", "),
            100.0 * axis.outside,
            unit.name()
        );
        Reason::new(ReasonKind::OutsideRange, text)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_figures_that_are_written_alike_are_told_to_differ_by_less_than_that() {
        let left = |left: f64| left_of_rates(RateUnit::Dps, [left, 4.446_9], None);
        assert_eq!(left(4.4474), "4.447 dps rms is left of 4.447 (more by less than the digits show)");
        assert_eq!(left(5.0), "5.000 dps rms is left of 4.447");
    }
}
