use super::*;

use proptest::prelude::*;
use std::vec;

/// Eq. (1), X, over the temperatures that docs/paper.md takes.
fn paper_x() -> Polynomial {
    let scale = Scale::spanning(8500.0, 11_900.0).unwrap();
    Polynomial::from_raw_coefficients(scale, &[13_435.7, -0.894_782, 0.375_298e-4]).unwrap()
}

#[test]
fn the_scaled_form_is_the_printed_equation() {
    let x = paper_x();
    for temperature in [8500.0, 10_200.0, 11_900.0] {
        let printed = 0.375_298e-4 * temperature * temperature - 0.894_782 * temperature + 13_435.7;
        assert!((x.evaluate(temperature) - printed).abs() < 1e-9);
    }
    let raw = x.raw_coefficients();
    assert!(
        (raw[0] - 13_435.7).abs() < 1e-8 && (raw[1] + 0.894_782).abs() < 1e-12 && (raw[2] - 0.375_298e-4).abs() < 1e-16
    );
}

/// docs/paper.md, "Equation (1) as printed, and its erratum".
#[test]
fn the_printed_y_equation_cannot_be_right() {
    let at = |sign: f64, t: f64| 0.276_524e-4 * t * t + sign * 0.676_531 * t + 12_516.1;
    // As printed: more than a 14-bit converter can show, and rising, against the text.
    assert!(at(1.0, 10_200.0) > 16_383.0);
    assert!((at(1.0, 10_200.0) - 22_294.0).abs() < 1.0);
    assert!(at(1.0, 12_000.0) > at(1.0, 8000.0));
    // With the linear term's sign turned: near the centre, falling 494 counts from 8000 to 12 000, 382 over the range.
    assert!((at(-1.0, 10_200.0) - 8492.0).abs() < 1.0);
    assert!((at(-1.0, 8000.0) - at(-1.0, 12_000.0) - 494.0).abs() < 1.0);
    assert!((at(-1.0, 8500.0) - at(-1.0, 11_900.0) - 382.0).abs() < 1.0);
}

#[test]
fn the_papers_x_turns_round_just_past_the_hot_end() {
    let scale = Scale::spanning(8500.0, 13_000.0).unwrap();
    let raw = [13_435.7, -0.894_782, 0.375_298e-4];
    let shape = Shape::Polynomial(Polynomial::from_raw_coefficients(scale, &raw).unwrap());
    let wide = Drift { shape: shape.clone(), valid: ValidRange::new(8500.0, 13_000.0).unwrap() };
    let narrow = Drift { shape, valid: ValidRange::new(8500.0, 11_900.0).unwrap() };
    assert!((wide.turning_points()[0] - 11_921.0).abs() < 0.5);
    assert!(narrow.turning_points().is_empty());
    assert!((narrow.peak_to_peak() - 439.0).abs() < 1.0);
}

#[test]
fn outside_its_range_a_model_is_held_and_says_so() {
    let drift = Drift { shape: Shape::Polynomial(paper_x()), valid: ValidRange::new(8500.0, 11_900.0).unwrap() };
    assert_eq!(drift.evaluate(8000.0), (drift.evaluate(8500.0).0, Coverage::Below));
    assert_eq!(drift.evaluate(12_500.0), (drift.evaluate(11_900.0).0, Coverage::Above));
    let (zro, coverage) = drift.evaluate(f64::NAN);
    assert!(zro.is_nan());
    assert_eq!(coverage, Coverage::Invalid);
}

#[test]
fn a_table_goes_through_its_knots_and_straight_between() {
    let table = Table::new(Scale::spanning(0.0, 3.0).unwrap(), &[1.0, 5.0, 5.0, -1.0]).unwrap();
    for (temperature, reading) in [(0.0, 1.0), (0.5, 3.0), (1.0, 5.0), (1.5, 5.0), (2.5, 2.0), (3.0, -1.0)] {
        assert!((table.evaluate(temperature) - reading).abs() < 1e-12, "at {temperature}");
    }
    assert!(table.evaluate(f64::NAN).is_nan());
    let drift = Drift { shape: Shape::Table(table), valid: ValidRange::new(0.0, 3.0).unwrap() };
    assert_eq!(drift.turning_points().len(), 1);
    assert!((drift.turning_points()[0] - 2.0).abs() < 1e-12);
}

#[test]
fn what_is_illegal_cannot_be_built() {
    let scale = Scale::spanning(-40.0, 60.0).unwrap();
    assert!(Scale::spanning(1.0, 1.0).is_none() && Scale::spanning(f64::NAN, 1.0).is_none());
    assert!(Polynomial::new(scale, &[1.0]).is_none() && Polynomial::new(scale, &[1.0; 7]).is_none());
    assert!(Polynomial::new(scale, &[1.0, f64::INFINITY]).is_none());
    assert!(Table::new(scale, &[1.0]).is_none() && Table::new(scale, &[1.0; 34]).is_none());
}

proptest! {
    #[test]
    fn between_turning_points_a_polynomial_is_monotone(
        coefficients in prop::collection::vec(-100.0..100.0_f64, 2..=6),
    ) {
        let scale = Scale::spanning(-40.0, 60.0).unwrap();
        let polynomial = Polynomial::new(scale, &coefficients).unwrap();
        let mut ends: std::vec::Vec<f64> = vec![-40.0];
        ends.extend(polynomial.turning_points(-40.0, 60.0));
        ends.push(60.0);
        for piece in ends.windows(2) {
            let readings: std::vec::Vec<f64> =
                (0..=200).map(|i| polynomial.evaluate(piece[0] + (piece[1] - piece[0]) * f64::from(i) / 200.0)).collect();
            let rising = readings.windows(2).all(|w| w[1] >= w[0] - 1e-9);
            let falling = readings.windows(2).all(|w| w[1] <= w[0] + 1e-9);
            prop_assert!(rising || falling);
        }
    }

    #[test]
    fn raw_and_scaled_forms_agree(coefficients in prop::collection::vec(-100.0..100.0_f64, 2..=6)) {
        let scale = Scale::spanning(8500.0, 11_900.0).unwrap();
        let polynomial = Polynomial::new(scale, &coefficients).unwrap();
        let raw = polynomial.raw_coefficients();
        for temperature in [8500.0, 9000.0, 10_200.0, 11_900.0] {
            let by_raw = raw.iter().rev().fold(0.0, |sum, c| sum * temperature + c);
            // The raw form cancels: at order 5 its terms are about (centre / half span)^5 = 8000 times the sum.
            prop_assert!((by_raw - polynomial.evaluate(temperature)).abs() < 1e-6);
        }
    }
}
