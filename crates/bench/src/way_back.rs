//! The way back that no test went: what the control of another axis's test shows of it.

use zerorate_core::units::Axis;

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
/// none in common.
fn apart(heating: &[Taken], cooling: &[Taken], axis: Axis) -> Option<f64> {
    let [from, to] = extremes(heating.iter().map(|taken| taken.temperature(axis).0));
    let width = (to - from) / f64::from(PARTS);
    let mean = |ramp: &[Taken], part: u32| {
        let begins = from + width * f64::from(part);
        let within = ramp.iter().filter(|taken| (begins..begins + width).contains(&taken.temperature(axis).0));
        let readings: Vec<f64> = within.map(|taken| taken.zro(axis).0).collect();
        #[allow(clippy::cast_precision_loss)] // some thousands
        (readings.len() >= FEWEST).then(|| readings.iter().sum::<f64>() / readings.len() as f64)
    };
    let in_part = |part| Some((mean(cooling, part)? - mean(heating, part)?).abs());
    (0..PARTS).filter_map(in_part).reduce(f64::max)
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
}
