//! The ramp's curve beside the soaks, which no fit has seen.

use std::collections::BTreeMap;

use zerorate_board_run::summary::{AxisSoaks, Check, SoakPoint, Soaks};
use zerorate_core::drift::Drift;
use zerorate_core::units::{Axis, Celsius, Counts};

use crate::evaluate::extremes;
use crate::measure::Measured;
use crate::procedure::soaks::Soak;
use crate::setup::{Limits, SetUp};
use crate::soaking::AT_SET_POINT;

/// The comparison; `None` where no soak was made. The ramp saves the time of the soaks that it is compared with.
#[must_use]
pub fn compared(soaks: &[Soak], setup: &SetUp, measured: &Measured) -> Option<Soaks> {
    let axes: BTreeMap<String, AxisSoaks> =
        Axis::BOTH.map(|axis| (axis.name().to_owned(), of_axis(soaks, setup, measured, axis))).into();
    let is_compared = |place: usize| axes.values().all(|axis| !axis.points[place].outside_ramp);
    let hours = |soak: &Soak| soak.chamber_time.0 / 3600.0;
    let compared_hours: f64 =
        soaks.iter().enumerate().filter(|(place, _)| is_compared(*place)).map(|(_, soak)| hours(soak)).sum();
    let ramp_hours = measured.ramp_time.0 / 3600.0;
    (!soaks.is_empty()).then(|| Soaks {
        ramp_hours,
        soak_hours: soaks.iter().map(hours).sum(),
        hours_saved: compared_hours - ramp_hours,
        axes,
    })
}

fn of_axis(soaks: &[Soak], setup: &SetUp, measured: &Measured, axis: Axis) -> AxisSoaks {
    let drift = measured.axes[axis.index()].drift.calibration.drift();
    let [coldest, hottest] = extremes(measured.ramp.iter().map(|taken| taken.temperature(axis).0));
    // A soak at an end of the ramp is as near to it as a chamber is held.
    let margin = AT_SET_POINT.0 * setup.board.counts_per_celsius;
    let points: Vec<SoakPoint> = soaks
        .iter()
        .map(|soak| point(soak.set_point, soak.means[axis.index()], drift, [coldest - margin, hottest + margin]))
        .collect();
    let inside = points.iter().filter(|soak| !soak.outside_ramp);
    let max_difference_counts = inside.map(|soak| (soak.zro_counts - soak.ramp_counts).abs()).reduce(f64::max);
    AxisSoaks { max_difference_counts, points }
}

/// A soak's mean temperature and reading beside the curve; `ramp` are the temperatures over which the two are compared.
fn point(set_point: Celsius, (temperature, zro): (Counts, Counts), drift: &Drift, ramp: [f64; 2]) -> SoakPoint {
    SoakPoint {
        chamber_c: set_point.0,
        temperature_counts: temperature.0,
        zro_counts: zro.0,
        // Not held at the ramp's end, by which a steep drift would differ from a soak a little outside of it.
        ramp_counts: drift.shape.evaluate(temperature.0),
        outside_ramp: !(ramp[0]..=ramp[1]).contains(&temperature.0),
    }
}

/// Holds the differences against the limit, and how many there are against half of the soaks: fewer say too little.
#[must_use]
pub fn check(soaks: &Soaks, limits: &Limits) -> Vec<Check> {
    let limit = limits.soak_difference_counts;
    let of_axis = |(axis, soaks): (&String, &AxisSoaks)| {
        let (made, compared) = (soaks.points.len(), soaks.compared());
        let largest = soaks.max_difference_counts.map(|largest| format!("{largest:.1} counts, "));
        Check {
            what: format!("{}, soaks: largest distance from the ramp's curve", axis.to_uppercase()),
            limit: format!("at most {limit:.1} counts, half of the soaks or more compared"),
            measured: format!("{}{compared} of {made} soaks compared", largest.unwrap_or_default()),
            passed: 2 * compared >= made && soaks.max_difference_counts.is_some_and(|largest| largest <= limit),
        }
    };
    soaks.axes.iter().map(of_axis).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zerorate_core::drift::{Polynomial, Scale, Shape, ValidRange};

    /// Soaks of X of which so many lie on the ramp, one count from its curve.
    fn soaks(on_the_ramp: usize, outside: usize) -> Soaks {
        let point = |outside_ramp| SoakPoint {
            chamber_c: 20.0,
            temperature_counts: 10_500.0,
            zro_counts: 8201.0,
            ramp_counts: 8200.0,
            outside_ramp,
        };
        let points = [vec![point(false); on_the_ramp], vec![point(true); outside]].concat();
        let axis = AxisSoaks { max_difference_counts: (on_the_ramp > 0).then_some(1.0), points };
        Soaks { ramp_hours: 2.0, soak_hours: 4.0, hours_saved: 2.0, axes: [("x".to_owned(), axis)].into() }
    }

    #[test]
    fn a_soak_a_little_below_the_ramp_is_held_against_the_curve_there_and_not_against_its_end() {
        // 8200 + 0.2 (T - 8600), from 8530 counts on; a soak that is cooler by 12 counts reads 2.4 counts less.
        let scale = Scale::spanning(8530.0, 8670.0).unwrap();
        let shape = Shape::Polynomial(Polynomial::new(scale, &[8200.0, 14.0]).unwrap());
        let drift = Drift { shape, valid: ValidRange::new(8530.0, 8670.0).unwrap() };
        let soak = |temperature: f64| {
            let zro = 8200.0 + 0.2 * (temperature - 8600.0);
            point(Celsius(-40.0), (Counts(temperature), Counts(zro)), &drift, [8530.0 - 17.0, 8670.0 + 17.0])
        };
        for (temperature, outside) in [(8518.0, false), (8530.0, false), (8685.0, false), (8500.0, true)] {
            let soak = soak(temperature);
            assert!((soak.zro_counts - soak.ramp_counts).abs() < 1e-9, "{soak:?}");
            assert_eq!(soak.outside_ramp, outside, "{soak:?}");
        }
    }

    #[test]
    fn a_check_of_fewer_than_half_of_the_soaks_does_not_pass_and_says_how_many_they_were() {
        for (on_the_ramp, outside, passes, measured) in [
            (11, 0, true, "1.0 counts, 11 of 11 soaks compared"),
            (1, 1, true, "1.0 counts, 1 of 2 soaks compared"),
            (2, 9, false, "1.0 counts, 2 of 11 soaks compared"),
            (0, 1, false, "0 of 1 soaks compared"),
        ] {
            let checks = check(&soaks(on_the_ramp, outside), &Limits::default());
            assert_eq!((checks[0].passed, checks[0].measured.as_str()), (passes, measured));
        }
    }
}
