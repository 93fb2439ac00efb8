use super::*;
use crate::choose::Model;

/// A ramp of 2400 groups with a quadratic drift and a noise of +-1 count.
fn ramp() -> RampMeans {
    let mut means = RampMeans::default();
    for group in 0..2400_u32 {
        let t = 8500.0 + 3400.0 * f64::from(group) / 2399.0;
        let noise = f64::from((group * 7919) % 1000) / 500.0 - 1.0;
        means.push(
            20 + group,
            f64::from(group) * 1.5,
            (t, 13_435.7 - 0.894_782 * t + 0.375_298e-4 * t * t + noise),
            500,
            0,
        );
    }
    means
}

fn kinds(means: &RampMeans, expected: Option<u64>) -> (Vec<ReasonKind>, bool) {
    let mut judgement = Judgement::default();
    let options = FitOptions { model: Model::Poly(2), ..FitOptions::default() };
    let fit = fit_axis("x", means, expected, &options, &mut judgement);
    (judgement.reasons.iter().map(|reason| reason.kind).collect(), fit.is_some())
}

#[test]
fn a_good_ramp_is_fitted_and_nothing_speaks_against_it() {
    assert_eq!(kinds(&ramp(), Some(2400)), (vec![], true));
}

#[test]
fn a_ramp_that_ends_early_is_a_cut_run() {
    assert_eq!(kinds(&ramp(), Some(2401)), (vec![ReasonKind::CutRun], false));
    assert_eq!(kinds(&ramp(), None), (vec![], true));
}

#[test]
fn values_that_stand_for_an_eighth_are_stuck() {
    let mut stuck = ramp();
    stuck.temperatures[1500..].fill(10_000.25);
    assert_eq!(kinds(&stuck, None), (vec![ReasonKind::StuckTemperature], false));
    stuck.temperatures.fill(10_000.25);
    assert_eq!(kinds(&stuck, None), (vec![ReasonKind::StuckTemperature], false));
    let mut stuck = ramp();
    stuck.readings[900..1600].fill(8211.5);
    assert_eq!(kinds(&stuck, None), (vec![ReasonKind::StuckReading], false));
}

#[test]
fn a_few_wild_groups_are_outliers_and_the_fit_can_be_looked_at() {
    let mut wild = ramp();
    for group in (5..2400).step_by(120) {
        wild.readings[group] += 400.0;
    }
    assert_eq!(kinds(&wild, None), (vec![ReasonKind::Outliers], true));
}

#[test]
fn a_group_at_the_converters_end_is_told_and_one_without_samples_left_out() {
    let mut means = ramp();
    means.push(2420, 3600.0, (12_000.0, 16_383.0), 500, SATURATED);
    means.push(2421, 3601.5, (f64::NAN, f64::NAN), 0, 0);
    assert_eq!(means.groups.len(), 2401);
    assert_eq!(kinds(&means, None), (vec![ReasonKind::Saturated], false));
}

#[test]
fn every_group_lies_in_one_of_eight_equal_stretches() {
    let span = (20, 2419);
    let stretches: Vec<usize> = (20..2420).map(|group| stretch_of(group, span)).collect();
    assert!((0..8).all(|stretch| stretches.iter().filter(|own| **own == stretch).count() == 300));
    assert!(stretches.is_sorted());
}
