use super::*;

/// A triangle sweep over -40..60, so that each temperature is seen in several folds.
fn folds(model: Model, curve: impl Fn(f64) -> f64) -> FoldFits {
    let rows = 8000;
    let mut folds = FoldFits::new(Scale::spanning(-40.0, 60.0).unwrap(), model, rows);
    for row in 0..rows {
        let phase = (row as f64 / 1300.0).fract();
        let temperature = -40.0 + 200.0 * (phase - 0.5).abs();
        let noise = ((row * 7919) % 1000) as f64 / 1000.0 - 0.5;
        folds.push_rows(row, &[temperature], &[curve(temperature) + noise]);
    }
    folds
}

#[test]
fn a_quadratic_drift_is_fitted_by_a_quadratic() {
    let choice = folds(Model::Auto, |t| 30.0 - 0.9 * t + 0.01 * t * t).choose(Model::Auto).unwrap();
    assert_eq!(choice.candidates.len(), 5);
    let (line, square) = (&choice.candidates[0], &choice.candidates[1]);
    let held_out = square.held_out_rms.unwrap();
    assert!(square.chosen && line.held_out_rms.unwrap() > 5.0 * held_out);
    // Uniform noise over one count: 1 / sqrt(12).
    assert!((held_out - 0.2887).abs() < 0.01);
    assert!(square.in_sample_rms <= held_out);
}

#[test]
fn a_cubic_drift_is_fitted_by_a_cubic() {
    let choice = folds(Model::Auto, |t| t * t * t * 2e-4).choose(Model::Auto).unwrap();
    assert!(choice.candidates[2].chosen);
}

#[test]
fn a_model_asked_for_is_taken_and_still_held_out() {
    let choice = folds(Model::Table(16), |t| (t / 15.0).sin()).choose(Model::Table(16)).unwrap();
    assert_eq!(choice.candidates[0].model, "table:16");
    assert_eq!(choice.without.iter().flatten().count(), FOLDS);
    assert!(choice.candidates[0].held_out_rms.unwrap() < 0.31);
}

#[test]
fn what_no_row_settles_is_an_error() {
    let empty = FoldFits::new(Scale::spanning(0.0, 1.0).unwrap(), Model::Auto, 0);
    assert_eq!(empty.choose(Model::Auto), Err(FitError::TooFewRows { rows: 0, coefficients: 2 }));
}
