//! What is to be known of a verification, in words.

use zerorate_fit::boot::BOOT_S;

use super::VerifiedAxis;
use zerorate_cal::log_fit::LogFit;
use zerorate_cal::quality::{Judgement, Reason, ReasonKind};
use zerorate_cal::units::{RateScale, TemperatureUnit, WrittenRate, from_to};

/// A larger share of the log outside what was measured is told. Two runs of one chamber's ramp end a few averages apart, and
/// that is less.
const TOLD_OUTSIDE: f64 = 0.02;

/// Averages that are outside by less than this part of the range are at its end.
const AT_THE_END: f64 = 0.01;

/// What is left of a run is by chance at most so many times what held-out folds tell of it.
const TOLD_TIMES: f64 = 2.0;

/// Of less of the range than this a run says nothing of a calibration but there.
const MUCH: f64 = 0.5;

/// How much of what was calibrated a run tells of, where that is little: by the axis of which it is least, and which axes they are
/// where it is not all of them.
pub(super) fn little_seen(axes: &[VerifiedAxis], unit: TemperatureUnit) -> Option<String> {
    let seen = |axis: &VerifiedAxis| {
        let ([from, to], [min, max]) = (axis.temperature, axis.calibrated_temperature);
        (to.min(max) - from.max(min)).max(0.0) / (max - min)
    };
    let little: Vec<&VerifiedAxis> = axes.iter().filter(|axis| seen(axis) < MUCH).collect();
    let least = little.iter().min_by(|a, b| seen(a).total_cmp(&seen(b)))?;
    let whose = if little.len() == axes.len() {
        "the log has".to_owned()
    } else {
        let names: Vec<&str> = little.iter().map(|axis| axis.name.as_str()).collect();
        format!("{}: its rates are at", names.join(", "))
    };
    let ([from, to], [min, max]) = (least.temperature, least.calibrated_temperature);
    Some(format!(
        "{whose} {:.0} % of the temperatures that were calibrated, {} of {} {}: what is told holds there alone",
        100.0 * seen(least),
        from_to(from, to),
        from_to(min, max),
        unit.name()
    ))
}

/// That the zero at the start rests on few averages, where rows are so far apart that little more than one is in half a minute.
pub(super) fn few_in_the_zero(averaged_over_s: Option<f64>) -> Option<String> {
    let apart = averaged_over_s.filter(|apart| *apart > 0.5 * BOOT_S)?;
    let few = if apart < 2.0 / 3.0 * BOOT_S { "two of them" } else { "one of them" };
    Some(format!(
        "averages are {apart:.0} s apart, so the zero at the start is {few}: its noise is in all that is told less a zero"
    ))
}

/// The reasons: what is wrong with the log, then what the calibration does to it; `alike`: over averages that can be held
/// against those of the calibration's fit.
pub(super) fn reasons(
    fit: &LogFit,
    axes: &[VerifiedAxis],
    unit: TemperatureUnit,
    told_in: Option<WrittenRate>,
    alike: bool,
) -> Vec<Reason> {
    let of_log = fit.judgement.reasons.iter().filter(|reason| !is_of_a_fit_alone(reason)).cloned();
    let mut judgement = Judgement::default();
    of_log
        .chain(worse(axes, told_in))
        .chain(more_than_told(axes, told_in, alike))
        .chain(outside(axes, unit))
        .for_each(|reason| judgement.add(reason));
    judgement.reasons
}

/// A narrow span, a hole in it, logs apart, one direction, and how well the log's own curve does are no faults of a log that is
/// not fitted.
fn is_of_a_fit_alone(reason: &Reason) -> bool {
    use ReasonKind::{LogsApart, NarrowSpan, OneDirection, Unmeasured, WorseThanUncorrected};
    matches!(reason.kind, LogsApart | NarrowSpan | OneDirection | Unmeasured | WorseThanUncorrected)
}

/// About its mean, or, of an axis that is no worse so, of what a device has left with its zero at the start.
fn worse(axes: &[VerifiedAxis], told_in: Option<WrittenRate>) -> impl Iterator<Item = Reason> {
    axes.iter().filter(|axis| axis.worse).map(move |axis| {
        let text = if axis.worse_about_mean {
            let left = left_of(axis, [axis.corrected.rms, axis.raw.rms], told_in);
            format!("{}: worse than uncorrected: {left} that were recorded", axis.name)
        } else {
            let left = left_of(axis, [axis.deployed.rms, axis.uncorrected.rms], told_in);
            format!("{}: less a zero at the start, worse than uncorrected: {left}", axis.name)
        };
        Reason::new(ReasonKind::WorseThanUncorrected, text)
    })
}

/// A run on which much more is left than the fit told of averages that are `alike`.
fn more_than_told(axes: &[VerifiedAxis], told_in: Option<WrittenRate>, alike: bool) -> impl Iterator<Item = Reason> {
    axes.iter().filter(move |_| alike).filter_map(move |axis| {
        let told = axis.fit_told.filter(|told| axis.deployed.rms > TOLD_TIMES * told.rms)?;
        let scale = RateScale::of(axis.rate_unit, &[axis.deployed.rms], told_in);
        let text = format!(
            "{}: less a zero at the start {} rms is left, {:.1} times what the fit told: this run has something that the \
             calibration's had not, or is of another unit",
            axis.name,
            scale.told(axis.deployed.rms),
            axis.deployed.rms / told.rms
        );
        Some(Reason::new(ReasonKind::MoreThanTold, text))
    })
}

fn left_of(axis: &VerifiedAxis, [left, of]: [f64; 2], told_in: Option<WrittenRate>) -> String {
    let scale = RateScale::of(axis.rate_unit, &[left, of], told_in);
    format!("{} rms is left of {}", scale.told(left), scale.number(of))
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
        let there = if axis.goes_on { "goes on as it ends, for a little, and is then held" } else { "is held" };
        let text = format!(
            "{}: {:.0} % of the averages are outside the {} {} that were measured for the calibration: there the curve {there}",
            names.join(", "),
            100.0 * axis.outside,
            from_to(min, max),
            unit.name()
        );
        Reason::new(ReasonKind::OutsideRange, text)
    })
}

#[cfg(test)]
mod tests {
    use zerorate_fit::boot::take_zero_off;

    use super::*;

    /// As many as the zero leaves without a prediction, which it is.
    #[test]
    fn a_zero_of_few_averages_is_told_with_how_many_they_are() {
        for (apart, told) in [(10.0, None), (15.5, Some(2)), (19.5, Some(2)), (20.0, Some(1)), (60.0, Some(1))] {
            let (times, all): (Vec<f64>, Vec<usize>) =
                (0..20_u8).map(|row| (apart * f64::from(row), usize::from(row))).unzip();
            let mut left = vec![1.0; 20];
            take_zero_off(&mut left, &times, &all);
            let in_the_zero = left.iter().filter(|left| left.is_nan()).count();
            let text = few_in_the_zero(Some(apart));
            assert_eq!(text.is_some(), told.is_some(), "{apart}");
            if let Some((text, told)) = text.zip(told) {
                assert_eq!(in_the_zero, told, "{apart}");
                assert!(text.contains(["one of them", "two of them"][told - 1]), "{apart}: {text}");
            }
        }
        assert_eq!(few_in_the_zero(None), None);
    }
}
