//! The way back that no test went: what the control of another axis's test shows of it.

use zerorate_core::units::{Axis, Counts};

use crate::evaluate::extremes;
use crate::procedure::compensation_test::TestRun;
use crate::run::Taken;

/// Parts of the range in which readings of both ways are compared.
const PARTS: u32 = 20;

/// Groups of either way in a part, at least.
const FEWEST: usize = 5;

/// Of each axis that no test cooled, how far it read otherwise on the way back as another's control, where that is more than is told
/// to be left of it: a sentence each. Tests with what is left in them, counts peak to peak.
pub(crate) fn untested(tests: &[(&TestRun, f64)]) -> impl Iterator<Item = String> {
    Axis::BOTH.into_iter().filter_map(|axis| {
        let own = || tests.iter().filter(|(run, _)| run.axis == axis);
        let was_cooled = own().any(|(run, _)| !run.cooling.is_empty());
        let told = own().map(|(_, left)| *left).reduce(f64::min)?;
        let others = tests.iter().filter(|(run, _)| run.axis != axis);
        let apart = others.filter_map(|(run, _)| apart(&run.heating, &run.cooling, axis)).reduce(f64::max)?;
        (!was_cooled && apart > told).then(|| {
            format!(
                "axis {}: its tests only heat, and as the control of the other axis it read up to {apart:.1} counts otherwise cooling than heating, at equal temperatures: the {told:.1} counts that are told to be left are of heating alone",
                axis.name().to_uppercase()
            )
        })
    })
}

/// The most that an axis reads otherwise on one of two ramps than on the other, in means over parts of their temperatures; `None` where they have
/// none in common. A ramp is longer at some temperatures of a part than at others, and the axis drifts there: the way up is taken
/// at the way back's own mean temperature, on the straight line between two of its parts.
fn apart(heating: &[Taken], cooling: &[Taken], axis: Axis) -> Option<f64> {
    let ends = extremes(heating.iter().map(|taken| taken.temperature(axis).0));
    let [up, back] = [heating, cooling].map(|ramp| means(ramp, axis, ends));
    let otherwise = |(temperature, reading): &(f64, f64)| {
        let pair = up.windows(2).find(|pair| (pair[0].0..=pair[1].0).contains(temperature))?;
        let [(from, first), (to, last)] = [pair[0], pair[1]];
        Some((reading - first - (last - first) * (temperature - from) / (to - from)).abs())
    };
    back.iter().filter_map(otherwise).reduce(f64::max)
}

/// Mean temperature and reading of a ramp in each part of a range in which it has groups enough, counts.
fn means(ramp: &[Taken], axis: Axis, [from, to]: [f64; 2]) -> Vec<(f64, f64)> {
    let width = (to - from) / f64::from(PARTS);
    let mean = |part: u32| {
        let begins = from + width * f64::from(part);
        let is_within = |taken: &&Taken| (begins..begins + width).contains(&taken.temperature(axis).0);
        let within: Vec<&Taken> = ramp.iter().filter(is_within).collect();
        #[allow(clippy::cast_precision_loss)] // some thousands
        let of = |reading: fn(&Taken, Axis) -> Counts| {
            within.iter().map(|taken| reading(taken, axis).0).sum::<f64>() / within.len() as f64
        };
        (within.len() >= FEWEST).then(|| (of(Taken::temperature), of(Taken::zro)))
    };
    (0..PARTS).filter_map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::tests::ramp_of;
    use zerorate_core::compensate::Mode;

    /// The control reads 31 counts more on the way back.
    #[test]
    fn an_axis_that_was_only_heated_is_told_by_what_it_read_as_the_control() {
        let run = |axis, taps: &[u16]| TestRun {
            mode: Mode::Hybrid,
            axis,
            heating: ramp_of(500, 8500, 9480, 511),
            cooling: taps.iter().flat_map(|tap| ramp_of(500, 8500, 9480, *tap)).collect(),
        };
        let told = |back: &[u16], left: f64| {
            let (x, y) = (run(Axis::X, &[512]), run(Axis::Y, back));
            untested(&[(&x, 3.0), (&y, left)]).collect::<Vec<_>>()
        };
        let [y] = &told(&[], 3.6)[..] else { panic!("{:?}", told(&[], 3.6)) };
        assert!(y.starts_with("axis Y: its tests only heat") && y.contains("31.0 counts") && y.contains("3.6"), "{y}");
        assert!(told(&[], 31.5).is_empty(), "less than what is told anyway");
        assert!(told(&[512], 3.6).is_empty(), "both were cooled");
    }

    /// Of a drift alone nothing is otherwise, though the way back is fast where the way up was slow: 98 counts over the ramp, and
    /// whole counts are read.
    #[test]
    fn a_drift_that_is_gone_through_at_other_speeds_is_no_difference() {
        let slow_at_first = [ramp_of(900, 8500, 8600, 511), ramp_of(100, 8600, 9480, 511)].concat();
        let slow_at_last = [ramp_of(100, 8500, 9400, 511), ramp_of(900, 9400, 9480, 511)].concat();
        let found = apart(&slow_at_first, &slow_at_last, Axis::Y).unwrap();
        assert!(found < 1.0, "{found}");
        let lower = ramp_of(1000, 8500, 9480, 512);
        assert!((apart(&slow_at_first, &lower, Axis::Y).unwrap() - 31.0).abs() < 1.0);
    }
}
