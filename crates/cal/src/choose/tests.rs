use super::*;

/// A triangle sweep over -40..60, so that each temperature is seen in several stretches.
fn stretches(model: Model, curve: impl Fn(f64) -> f64) -> Stretches {
    let rows = 8000;
    let mut stretches = Stretches::new(Scale::spanning(-40.0, 60.0).unwrap(), model, rows);
    for row in 0..rows {
        let phase = (row as f64 / 1300.0).fract();
        let temperature = -40.0 + 200.0 * (phase - 0.5).abs();
        let noise = ((row * 7919) % 1000) as f64 / 1000.0 - 0.5;
        let (stretch, _) = stretches.of_row(row);
        stretches.fit(stretch).push(temperature, &[curve(temperature) + noise]);
    }
    stretches
}

#[test]
fn model_names_are_read_and_written() {
    for name in ["poly:1", "poly:5", "table:32", "auto"] {
        assert_eq!(name.parse::<Model>().unwrap().to_string(), name);
    }
    for name in ["poly:0", "poly:6", "table:33", "poly", "poly:x", "spline:3", ""] {
        let error = name.parse::<Model>().unwrap_err().to_string();
        assert!(error.contains("poly:1 to poly:5, table:1 to table:32"), "{error}");
    }
}

#[test]
fn rows_fall_into_eight_equal_contiguous_stretches() {
    let stretches = Stretches::new(Scale::spanning(0.0, 1.0).unwrap(), Model::Auto, 8403);
    let mut counts = [0; STRETCHES];
    for row in 0..8403 {
        let (stretch, end) = stretches.of_row(row);
        counts[stretch] += 1;
        assert!(row < end && (end == u64::MAX || stretches.of_row(end).0 == stretch + 1));
    }
    assert!(counts.iter().all(|count| (1050..=1051).contains(count)), "{counts:?}");
}

#[test]
fn a_quadratic_drift_is_fitted_by_a_quadratic() {
    let choice = stretches(Model::Auto, |t| 30.0 - 0.9 * t + 0.01 * t * t).choose(Model::Auto).unwrap();
    assert_eq!(choice.model, Model::Poly(2));
    assert_eq!(choice.candidates.len(), 5);
    let [line, square, ..] = choice.candidates[..] else { panic!() };
    assert!(line.held_out_rms > 5.0 * square.held_out_rms);
    // Uniform noise over one count: 1 / sqrt(12).
    assert!((square.held_out_rms - 0.2887).abs() < 0.01);
    assert!(square.in_sample_rms <= square.held_out_rms);
}

#[test]
fn a_cubic_drift_is_fitted_by_a_cubic() {
    let choice = stretches(Model::Auto, |t| t * t * t * 2e-4).choose(Model::Auto).unwrap();
    assert_eq!(choice.model, Model::Poly(3));
}

#[test]
fn a_model_asked_for_is_taken_and_still_held_out() {
    let choice = stretches(Model::Table(16), |t| (t / 15.0).sin()).choose(Model::Table(16)).unwrap();
    assert_eq!(choice.model, Model::Table(16));
    assert_eq!(choice.without.iter().flatten().count(), STRETCHES);
    assert!(choice.candidates[0].held_out_rms < 0.31);
}

#[test]
fn what_no_row_settles_is_an_error() {
    let empty = Stretches::new(Scale::spanning(0.0, 1.0).unwrap(), Model::Auto, 0);
    assert_eq!(empty.choose(Model::Auto), Err(FitError::TooFewRows { rows: 0, coefficients: 2 }));
}
