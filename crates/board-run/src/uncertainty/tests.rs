use zerorate_core::compensate::Mode;
use zerorate_core::drift::ValidRange;
use zerorate_core::units::Axis;

use super::left::{Left, Run};
use super::statistics::{Bins, noise, soaks};
use super::{Budget, Contribution, Evaluation, Part, Source};
use crate::summary::SoakPoint;

/// A thousand groups over a range of temperatures.
fn ramp(counts: impl Fn(u32) -> f64) -> Vec<Left> {
    let left = |group| Left { group, temperature: f64::from(group), counts: counts(group), tap: 511 };
    (0..1000).map(left).collect()
}

fn bins(noise: f64) -> Bins {
    Bins::over(ValidRange::new(0.0, 1000.0).unwrap(), noise)
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
}

#[test]
fn noise_is_told_apart_from_a_slope_and_from_taps() {
    // Of +1, -1, +1 ... each second difference is 4.
    let alternating = |group: u32| if group.is_multiple_of(2) { 1.0 } else { -1.0 };
    let sloping = ramp(|group| alternating(group) + 0.3 * f64::from(group));
    close(noise([&sloping[..]].into_iter()).unwrap(), 4.0 / 6.0_f64.sqrt());
    let mut stepping = sloping.clone();
    for left in &mut stepping[500..] {
        left.counts += 31.0;
        left.tap += 1;
    }
    // The two windows across the step are left out, whose second differences are the others'.
    close(noise([&stepping[..]].into_iter()).unwrap(), 4.0 / 6.0_f64.sqrt());
    assert_eq!(noise([&sloping[..2]].into_iter()), None);
}

#[test]
fn repeatability_is_the_rms_about_zero_of_what_other_switch_ons_are_off() {
    let ramps = [ramp(|_| 3.0), ramp(|_| -1.0)];
    let of = |noise| bins(noise).repeatability(ramps.iter().map(Vec::as_slice)).unwrap();
    close(of(0.0).counts, 5.0_f64.sqrt());
    assert_eq!(of(0.0).ramps, 2);
    // Fifty groups to a part: noise of 5 counts makes half a count squared of each mean.
    close(of(5.0).counts, 4.5_f64.sqrt());
    close(of(50.0).counts, 0.0);
    assert!(bins(0.0).repeatability([&ramps[0][..7]].into_iter()).is_none());
}

#[test]
fn half_of_the_mean_square_between_cooling_and_heating_counts() {
    let both = Run { heating: ramp(|_| 1.0), cooling: ramp(|_| 5.0) };
    let one_way = Run { heating: ramp(|_| 100.0), cooling: Vec::new() };
    let direction = bins(0.0).direction(&[both, one_way.clone()]).unwrap();
    close(direction.counts, 8.0_f64.sqrt());
    assert_eq!(direction.ramps, 1);
    assert!(bins(0.0).direction(&[one_way]).is_none());
}

#[test]
fn soaks_on_the_ramp_tell_what_is_beyond_the_repeatability() {
    let soak = |off: f64, outside_ramp| SoakPoint {
        chamber_c: 0.0,
        temperature_counts: 9000.0,
        zro_counts: 8200.0 + off,
        ramp_counts: 8200.0,
        outside_ramp,
    };
    let points = [soak(5.0, false), soak(-5.0, false), soak(90.0, true)];
    close(soaks(&points, 3.0).unwrap(), 4.0);
    close(soaks(&points, 6.0).unwrap(), 0.0);
    assert_eq!(soaks(&points[2..], 0.0), None);
}

/// Student's table: of 4 degrees of freedom 88.4 % lie within 2, of 10 92.7 %, of infinitely many 95.4 %.
#[test]
fn u_of_few_switch_ons_holds_less_often_by_students_table() {
    let budget = |rows: &[(f64, Option<usize>)]| {
        let row = |&(counts, few): &(f64, Option<usize>)| Contribution {
            source: Source::Noise,
            evaluation: Evaluation::A,
            part: Part::Known(counts),
            few,
            told: String::new(),
        };
        Budget { axis: Axis::X, mode: Mode::Hybrid, contributions: rows.iter().map(row).collect() }
    };
    for (rows, freedom, held) in [
        (&[(3.0, Some(4))][..], 4.0, 0.8839),
        (&[(3.0, Some(10))], 10.0, 0.9266),
        // (9 + 16)^2 / (81 / 4 + 256 / 2) = 4.2.
        (&[(3.0, Some(4)), (4.0, Some(2))], 625.0 / 148.25, 0.8839),
        (&[(3.0, None)], f64::INFINITY, 0.9545),
    ] {
        let budget = budget(rows);
        let found = budget.degrees_of_freedom();
        assert!(found.total_cmp(&freedom).is_eq() || (found - freedom).abs() < 1e-9, "{found} for {freedom}");
        assert!((budget.held() - held).abs() < 1e-4, "{}", budget.held());
    }
    close(budget(&[(3.0, None), (4.0, Some(2))]).expanded_counts(), 10.0);
}
