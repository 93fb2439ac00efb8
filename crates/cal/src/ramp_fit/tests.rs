use super::*;
use crate::recording::{Phase, RecordingInfo};
use zerorate_core::compensate::Mode;
use zerorate_core::group::GroupSums;

fn group_of(group: u32, temperature: f64, reading: f64) -> RampGroup {
    RampGroup { group, time_s: f64::from(group) * 1.5, temperature, reading, samples: 500, status_bits: 0, tap: 511 }
}

/// A ramp of 2400 groups with a quadratic drift and a noise of +-1 count.
fn ramp() -> RampMeans {
    let mut means = RampMeans::default();
    for group in 0..2400_u32 {
        let t = 8500.0 + 3400.0 * f64::from(group) / 2399.0;
        let noise = f64::from((group * 7919) % 1000) / 500.0 - 1.0;
        let reading = 13_435.7 - 0.894_782 * t + 0.375_298e-4 * t * t + noise;
        means.push(&group_of(20 + group, t, reading));
    }
    means
}

/// Twenty groups far from the others.
fn with_outliers(mut means: RampMeans) -> RampMeans {
    (5..2400).step_by(120).for_each(|group| means.readings[group] += 400.0);
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
fn values_that_stand_for_a_fold_are_stuck() {
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
fn a_few_outlying_groups_are_outliers_and_the_fit_can_be_looked_at() {
    let outlying = with_outliers(ramp());
    assert_eq!(kinds(&outlying, None), (vec![ReasonKind::Outliers], true));
}

#[test]
fn a_group_at_the_converters_end_is_told_and_one_without_samples_left_out() {
    let mut means = ramp();
    means.push(&RampGroup { status_bits: status::SATURATED, ..group_of(2420, 12_000.0, 16_383.0) });
    means.push(&RampGroup { samples: 0, ..group_of(2421, f64::NAN, f64::NAN) });
    assert_eq!(means.groups.len(), 2401);
    assert_eq!(kinds(&means, None), (vec![ReasonKind::Saturated], false));
}

/// A ramp up and down again whose reading follows a die some seconds behind the sensor.
fn up_and_down(die_behind_s: f64) -> RampMeans {
    let mut means = RampMeans::default();
    let mut die = 8500.0;
    for group in 0..4800_u32 {
        let place = f64::from(group) / 2400.0;
        // An hour to come near each end, as a chamber does.
        let t = if place < 1.0 { 8500.0 } else { 11_900.0 }
            + if place < 1.0 { 3400.0 } else { -3400.0 } * (1.0 - (-4.0 * place.fract()).exp());
        die += (t - die) * (1.0 - (-1.5 / die_behind_s).exp());
        let noise = f64::from((group * 7919) % 1000) / 500.0 - 1.0;
        means.push(&group_of(group, t, 8200.0 + 0.1 * (die - 10_200.0) + noise));
    }
    means
}

#[test]
fn auto_sees_hysteresis_in_both_directions_of_a_ramp_and_a_model_asked_for_does_not() {
    let means = up_and_down(12.0);
    let fit = |model| {
        let options = FitOptions { model, ..FitOptions::default() };
        let mut judgement = Judgement::default();
        let fit = fit_axis("x", &means, None, &options, &mut judgement).unwrap();
        assert_eq!(judgement.reasons, []);
        fit
    };
    let (auto, cubic) = (fit(Model::Auto), fit(Model::Poly(3)));
    let remembers = |axis: &AxisFit| axis.calibration.fit.model.history.is_some();
    assert!(remembers(&auto) && !remembers(&cubic), "{}", auto.calibration.fit.chosen_model());
    // The noise alone is 0.577 rms.
    let held_out = |axis: &AxisFit| axis.calibration.fit.statistics.held_out.unwrap().rms;
    assert!(held_out(&auto) < 0.65 && held_out(&cubic) > 1.5, "{} {}", held_out(&auto), held_out(&cubic));
    assert!(auto.calibration.fit.statistics.samples_used == 4800 * 500 && auto.trace.len() == 4800);
}

#[test]
fn outlying_groups_do_not_hide_behind_the_misfit_of_a_poor_model() {
    let mut means = ramp();
    // An S of 400 counts that no parabola follows.
    for (reading, t) in means.readings.iter_mut().zip(&means.temperatures) {
        *reading += 200.0 * ((t - 10_200.0) / 1700.0 * 4.0).sin();
    }
    assert_eq!(kinds(&means, None), (vec![], true));
    let means = with_outliers(means);
    assert_eq!(kinds(&means, None), (vec![ReasonKind::Outliers], true));
}

#[test]
fn a_drift_that_no_curve_follows_is_not_taken_for_wild_groups() {
    let mut means = ramp();
    // The gyro settles for some minutes after the chamber was switched: a bump in the first hundred groups, ten times
    // the noise high, and with it a kurtosis of what the curve leaves far above noise's.
    for (group, reading) in means.readings.iter_mut().enumerate() {
        let behind = f64::from(u32::try_from(group).unwrap()) / 30.0;
        *reading += 16.0 * behind * (-behind).exp();
    }
    assert_eq!(kinds(&means, None), (vec![], true));
    means.readings[30] += 8.0;
    assert_eq!(kinds(&means, None), (vec![ReasonKind::Outliers], true), "one wild group on the bump's top");
}

#[test]
fn groups_with_damaged_numbers_are_no_ramp() {
    let mut means = ramp();
    means.groups[2399] = u32::MAX;
    assert_eq!(kinds(&means, None).0, [ReasonKind::LostGroups]);
}

#[test]
fn a_few_outlying_groups_move_autos_curve_by_little_and_reject_the_unit_all_the_same() {
    let outlying = with_outliers(ramp());
    let mut judgement = Judgement::default();
    let fit = fit_axis("x", &outlying, None, &FitOptions::default(), &mut judgement).unwrap();
    assert_eq!(judgement.reasons.iter().map(|reason| reason.kind).collect::<Vec<_>>(), [ReasonKind::Outliers]);
    let clean = fit_axis("x", &ramp(), None, &FitOptions::default(), &mut Judgement::default()).unwrap();
    let off = |t: f64| (fit.calibration.drift().evaluate(t).0 - clean.calibration.drift().evaluate(t).0).abs();
    assert!((0..=34).all(|k| off(8500.0 + 100.0 * f64::from(k)) < 0.3));
}

#[test]
fn readings_of_a_wiper_that_moved_are_no_drift() {
    let mut means = ramp();
    means.push(&RampGroup { tap: 512, ..group_of(2420, 11_901.0, 8200.0) });
    assert_eq!(kinds(&means, None), (vec![ReasonKind::WiperMoved], false));
}

#[test]
fn every_group_lies_in_one_of_eight_equal_folds() {
    let span = (20, 2419);
    let folds: Vec<usize> = (20..2420).map(|group| fold_of(group, span)).collect();
    assert!((0..8).all(|fold| folds.iter().filter(|own| **own == fold).count() == 300));
    assert!(folds.is_sorted());
}

/// The recording of a heating ramp of so many groups where the set-up plans 2400, and of the way back if there is one; the
/// chamber's air is told where the bench drives it.
fn recording(groups: u32, back: bool, chamber_c: f64) -> Recording {
    let set_up = format!("[chamber]\nramp_groups = 2400\ncooling_ramp = {back}\n");
    let info = RecordingInfo { procedure: "full-temperature".into(), set_up, ..RecordingInfo::default() };
    let mut rows = Vec::new();
    for group in 0..groups * if back { 2 } else { 1 } {
        let heating = group < groups;
        let place = if heating { group } else { 2 * groups - 1 - group };
        let (temperature, zro) = (8500 + 3400 * place / groups, 8000 + place / 8 + group * 7919 % 3);
        let mut sums = GroupSums::default();
        sums.push(u16::try_from(temperature).unwrap(), u16::try_from(zro).unwrap());
        rows.extend(Axis::BOTH.map(|axis| GroupRow {
            group,
            t_s: f64::from(group) * 1.5,
            phase: if heating { Phase::Heating } else { Phase::Cooling },
            axis,
            sums,
            corrected_counts: f64::from(zro),
            tap: 511,
            mode: Mode::Off,
            chamber_set_c: 60.0,
            chamber_c,
            status_bits: 0,
        }));
    }
    Recording { info, rows, cut: false }
}

fn reasons_of(recording: &Recording) -> Vec<Reason> {
    let options = FitOptions { model: Model::Poly(2), ..FitOptions::default() };
    let source = Source::bytes("full-temperature.parquet", Vec::new());
    fit_recording(recording, &source, &options).judgement.reasons
}

fn kinds_of(recording: &Recording) -> Vec<ReasonKind> {
    reasons_of(recording).iter().map(|reason| reason.kind).collect()
}

fn texts_of(recording: &Recording) -> Vec<String> {
    reasons_of(recording).into_iter().map(|reason| reason.text).collect()
}

/// What befell one axis is told of that one, whichever words tell it; of both, once, of both.
#[test]
fn every_reason_of_a_recording_names_its_axis_or_both() {
    let without = |lost: &dyn Fn(&GroupRow) -> bool| {
        let mut recording = recording(2400, true, 25.0);
        recording.rows.retain(|row| !lost(row));
        texts_of(&recording)
    };
    let ends = |from: u32| format!("the recording ends after {from} of its ramp's 4800 groups: the run was cut");
    assert_eq!(without(&|row| row.axis == Axis::Y && row.group >= 4000), [format!("y: {}", ends(4000))]);
    assert_eq!(without(&|row| row.group >= 4000), [format!("x, y: {}", ends(4000))]);
    let each = without(&|row| row.group >= if row.axis == Axis::X { 4100 } else { 4000 });
    assert_eq!(each, [format!("x: {}", ends(4100)), format!("y: {}", ends(4000))]);
    let mut still = recording(2400, true, 25.0);
    for row in still.rows.iter_mut().filter(|row| row.axis == Axis::X) {
        (row.sums.temperature, row.sums.temperature_sq) = (9000, 9000 * 9000);
    }
    let told = texts_of(&still);
    assert!(told.len() == 1 && told[0].starts_with("x: the temperature stays at 9000.00 counts"), "{told:?}");
}

#[test]
fn a_ramp_by_a_chamber_that_cannot_be_asked_ends_where_that_arrives() {
    // 2189 of 2400 groups: the chamber was there before the plan's end.
    assert_eq!(kinds_of(&recording(2189, true, f64::NAN)), []);
    assert_eq!(kinds_of(&recording(2189, true, 25.0)), [ReasonKind::CutRun]);
    let unfinished = Recording { cut: true, ..recording(2189, true, f64::NAN) };
    assert_eq!(kinds_of(&unfinished), [ReasonKind::CutRun]);
}

/// However its rows lie in the file it is the same ramp; what stands twice, and what is missing, is told as that.
#[test]
fn groups_in_any_order_are_one_ramp_and_those_that_repeat_or_miss_are_told() {
    let whole = recording(2400, true, 25.0);
    let mut backwards = whole.clone();
    backwards.rows.reverse();
    assert_eq!(kinds_of(&backwards), []);
    assert_eq!(RampMeans::of(&backwards, Axis::X), RampMeans::of(&whole, Axis::X));
    let mut twice = whole.clone();
    twice.rows.extend_from_slice(&whole.rows[..2]);
    assert_eq!(kinds_of(&twice), [ReasonKind::LostGroups]);
    assert!(texts_of(&twice)[0].starts_with("x, y: 1 of 4801 groups have a number that another has"));
    let mut holed = whole;
    holed.rows.drain(1000..1200);
    let told = texts_of(&holed);
    assert!(told[0].contains("4700 of its ramps' 4800 groups are there: the others were lost"), "{told:?}");
}

#[test]
fn a_recording_that_only_heats_says_so_as_a_log_does() {
    assert_eq!(kinds_of(&recording(2400, false, 25.0)), [ReasonKind::OneDirection]);
    assert_eq!(kinds_of(&recording(2400, true, 25.0)), []);
}
