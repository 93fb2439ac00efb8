use zerorate_core::drift::{Polynomial, Scale, Shape, ValidRange};
use zerorate_core::trim::TrimLine;
use zerorate_core::units::{Counts, Taps};

use super::*;

/// Eq. (1), X, with every coefficient but the constant times a factor about 10 200 counts.
fn drift(factor: f64) -> Drift {
    let scale = Scale::spanning(8500.0, 11_900.0).unwrap();
    let paper = Polynomial::from_raw_coefficients(scale, &[13_435.7, -0.894_782, 0.375_298e-4]).unwrap();
    let [c0, c1, c2] = paper.coefficients() else { panic!() };
    let shape = Shape::Polynomial(Polynomial::new(scale, &[*c0, c1 * factor, c2 * factor]).unwrap());
    Drift { shape, valid: ValidRange::new(8500.0, 11_900.0).unwrap() }
}

fn trim() -> Trim {
    Trim { line: TrimLine::new(-0.031_990_6, -0.274_587, Counts(8203.3), Taps::MIDDLE).unwrap(), measured: None }
}

const SCALE: TemperatureScale = TemperatureScale::QUARTER_COUNTS;

fn composed(factor: f64, mode: Mode) -> Composed {
    compose_axis(drift(factor), trim(), 0.15, LowPass::first_order(40.0, 0.003, 0.0001), mode, SCALE).unwrap()
}

/// Eq. (7): with the paper's numbers N is a quadratic in T. At 10 200 counts V = 8213.524 and
/// N = 511 - 0.0319906 * 10.224 - 0.274587 = 510.398.
#[test]
fn the_composed_law_is_the_papers() {
    let model = composed(1.0, Mode::Hybrid).model;
    let law = model.static_law(SCALE);
    let code = SCALE.code(10_200.0).unwrap();
    assert!((law.position(code) - 510.398_3).abs() < 1e-3);
    let edges = model.edges.as_ref().unwrap();
    assert_eq!(edges.intervals()[edges.find(code)].tap.get(), 510);
    // About 440 counts of drift at 31.26 a tap: 14 crossings, 15 intervals.
    assert_eq!(edges.intervals().len(), 15);
}

#[test]
fn a_unit_of_two_axes_is_a_record_that_a_device_reads_back() {
    let axis = composed(1.0, Mode::Trim);
    assert_eq!(axis.digital_only, None);
    let record = compose("ZR-0001", SCALE, BoardNumbers::PAPER, &[axis.model.clone(), axis.model]).unwrap();
    let mut buffer = [0; MAX_RECORD_BYTES];
    assert_eq!(DeviceRecord::decode(record.encode(&mut buffer).unwrap()).unwrap(), record);
}

#[test]
fn a_drift_too_large_for_the_wiper_is_left_to_the_digital_mode() {
    for (factor, mode) in [(8.0, Mode::Hybrid), (8.0, Mode::Trim)] {
        let composed = composed(factor, mode);
        let why = composed.digital_only.unwrap();
        assert!(matches!(why.reason, EdgeError::TooManyIntervals { .. }));
        assert_eq!((composed.model.start_up_mode, composed.model.edges), (Mode::Digital, None));
        assert!(why.to_string().ends_with(&format!("in mode digital instead of {}", mode.name())), "{why}");
    }
    let far = Trim { line: TrimLine::new(-0.6, 0.0, Counts(7100.0), Taps::MIDDLE).unwrap(), measured: None };
    let composed = compose_axis(drift(1.0), far, 0.0, LowPass::NONE, Mode::Off, SCALE).unwrap();
    let why = composed.digital_only.unwrap();
    assert!(matches!(why.reason, EdgeError::OutOfTaps { .. }) && why.instead_of.is_none());
    assert_eq!(composed.model.start_up_mode, Mode::Off);
}

#[test]
fn numbers_beyond_the_devices_integers_are_an_error() {
    let refused = compose_axis(drift(1000.0), trim(), 0.1, LowPass::NONE, Mode::Digital, SCALE);
    assert_eq!(refused, Err(ComposeError::Unrepresentable(Unrepresentable::TooLarge)));
}

#[test]
fn parameters_that_make_no_sense_are_refused() {
    for dead_band in [-0.1, 0.6, f64::NAN] {
        let refused = compose_axis(drift(1.0), trim(), dead_band, LowPass::NONE, Mode::Trim, SCALE);
        assert!(refused.unwrap_err().to_string().contains("dead band"));
    }
    let open = LowPass { missing_at_first: 0.5, missing_per_sample: 1.0 };
    let refused = compose_axis(drift(1.0), trim(), 0.1, open, Mode::Trim, SCALE);
    assert!(matches!(refused, Err(ComposeError::LowPass { .. })));
    let flat = TemperatureScale { zero: 0.0, step: 0.0 };
    let refused = compose_axis(drift(1.0), trim(), 0.1, LowPass::NONE, Mode::Trim, flat);
    assert!(matches!(refused, Err(ComposeError::TemperatureScale { .. })));
    let axis = composed(1.0, Mode::Trim).model;
    let long = "x".repeat(33);
    assert_eq!(
        compose(&long, SCALE, BoardNumbers::PAPER, &[axis.clone(), axis]),
        Err(ComposeError::SerialTooLong { serial: long })
    );
}

#[test]
fn an_axis_changed_after_it_was_composed_is_named() {
    let good = composed(1.0, Mode::Trim).model;
    let mut changed = good.clone();
    changed.dead_band = 0.05;
    let refused = compose("ZR-0001", SCALE, BoardNumbers::PAPER, &[good, changed]).unwrap_err();
    assert!(refused.to_string().starts_with("axis y: "), "{refused}");
}

#[test]
fn a_dead_band_within_the_noise_is_warned_of() {
    // The paper's X is steepest at its cold end: 0.894782 - 2 * 0.375298e-4 * 8500 = 0.256775 counts a count.
    let slope = steepest_slope_taps(&drift(1.0), &trim().line);
    assert!((slope - 0.256_775 * 0.031_990_6).abs() < 1e-5, "{slope}");
    let warning = chatter_warning(10.0, slope, 0.15).unwrap();
    assert!((warning.quiet_dead_band() - 0.4107).abs() < 1e-3);
    assert!(warning.to_string().contains("0.411 taps or more"), "{warning}");
    // A group of 500 has the noise of a sample over 22.
    assert_eq!(chatter_warning(10.0 / 500_f64.sqrt(), slope, 0.15), None);
}

/// What the warning is about: a plain rounding law writes more often than it crosses taps, a quiet band does not.
#[test]
fn a_quiet_dead_band_writes_once_a_tap() {
    let writes = |dead_band: f64| {
        let composed = compose_axis(drift(1.0), trim(), dead_band, LowPass::NONE, Mode::Trim, SCALE).unwrap();
        let edges = composed.model.edges.unwrap();
        let code = |group: i32| {
            // Uniform over +-8.66 counts: 5 counts rms.
            let noise = (f64::from((group * 617) % 1000) / 500.0 - 1.0) * 8.66;
            SCALE.code(8500.0 + 3400.0 * f64::from(group) / 2400.0 + noise).unwrap()
        };
        let mut interval = edges.find(code(0));
        let mut writes = 0;
        for group in 1..=2400 {
            let next = edges.next(interval, code(group));
            writes += i32::from(edges.intervals()[next].tap != edges.intervals()[interval].tap);
            interval = next;
        }
        writes
    };
    let quiet = 5.0 * 5.0 * steepest_slope_taps(&drift(1.0), &trim().line);
    assert!(writes(0.0) > 20, "{}", writes(0.0));
    assert!((13..=14).contains(&writes(quiet)), "{}", writes(quiet));
}
