//! What is told beside an export is of what is exported.

use zerorate_fit::drift_fit::{HeldOut, StaticCubic};
use zerorate_fit::residual::ResidualStatistics;

use super::calibrations::{calibration, three_axes};
use crate::{ExportOptions, Format, export};
use zerorate_cal::calibration::Calibration;

/// One axis of which a device has 1e-3 left without a model, and so much by the model and by the cubic beside it.
fn left(model: f64, cubic: f64) -> Calibration {
    let residual = |rms: f64| ResidualStatistics { rms, pp: 5.0 * rms, rms_standard_error: Some(1e-6) };
    let (name, mut axis) = three_axes().axes.into_iter().find(|(name, _)| name == "gyro0.z").unwrap();
    axis.fit.statistics.deployed = Some(residual(model));
    axis.fit.statistics.uncorrected = Some(residual(1e-3));
    axis.fit.statistics.in_sample = residual(1e-5);
    axis.fit.static_cubic = Some(StaticCubic {
        drift: axis.fit.model.drift.clone(),
        in_sample: residual(1e-5),
        held_out: None,
        deployed: Some(residual(cubic)),
    });
    calibration(vec![(name.as_str(), axis)])
}

fn notes(calibration: &Calibration, format: Format) -> String {
    let options = ExportOptions { device_id: Some(7), instance: None };
    export(calibration, format, &options).unwrap().notes.join("\n")
}

#[test]
fn that_something_does_not_help_is_said_of_what_is_exported() {
    let cubics = [Format::Px4, Format::ArduPilot, Format::MethodicConfigurator, Format::Json];
    let (by_model, by_cubic) = (left(2e-3, 0.5e-3), left(0.5e-3, 2e-3));
    for format in cubics {
        let (helps, harms) = (notes(&by_model, format), notes(&by_cubic, format));
        assert!(!helps.contains("do not use it"), "{format}: {helps}");
        let told = "a device that takes this cubic off has 2.000 mrad/s rms left of data that were not fitted, and 1.000 without it: do not use it";
        assert!(harms.contains(told), "{format}: {harms}");
    }
    for format in [Format::C, Format::Csv] {
        assert!(notes(&by_model, format).contains("takes table:16 off"), "{format}: {}", notes(&by_model, format));
        assert!(!notes(&by_cubic, format).contains("do not use it"), "{format}: {}", notes(&by_cubic, format));
    }
}

/// Of the whole log the cubic leaves 30 % less, of folds the model 10 %: the model is chosen, and the text says why.
#[test]
fn a_model_that_was_chosen_by_another_figure_than_is_told_says_so() {
    let folds = |model: f64, cubic: f64| HeldOut {
        folds: 8,
        in_recording: None,
        deployed_warm: Some(model),
        deployed_cold: None,
        cubic_in_recording: None,
        cubic_deployed: Some(cubic),
    };
    let with = |nested: HeldOut| {
        let mut own = left(0.5e-3, 0.35e-3);
        let candidate =
            r#"{"model":"table:16","in_sample_rms":1e-5,"held_out_rms":null,"held_out_excess_standard_error":null}"#;
        let statistics = &mut own.axes.get_mut("gyro0.z").unwrap().fit.statistics;
        statistics.nested = Some(nested);
        statistics.candidates = vec![serde_json::from_str(candidate).unwrap(); 2];
        notes(&own, Format::Px4)
    };
    let told = with(folds(0.9e-4, 1e-4));
    assert!(told.contains("30 % less than the chosen table:16"), "{told}");
    assert!(told.contains("of these it leaves 0.09000 mrad/s and the cubic 0.1000. Another run"), "{told}");
    // By the same figures nothing is to be explained.
    assert!(!with(folds(2e-4, 1e-4)).contains("was chosen all the same"));
}

#[test]
fn after_a_log_of_one_direction_what_a_cubic_costs_is_told_of_that_direction() {
    let one_way = |mut own: Calibration| {
        own.warnings = vec!["the temperature only rises: the log says nothing of hysteresis, and more".to_owned()];
        own
    };
    let words = "told of runs that go the way of this log";
    assert!(notes(&one_way(left(0.2e-3, 0.5e-3)), Format::Px4).contains(words));
    // A cubic that costs nothing, and a log of both directions.
    assert!(!notes(&one_way(left(0.5e-3, 0.2e-3)), Format::Px4).contains(words));
    assert!(!notes(&left(0.2e-3, 0.5e-3), Format::Px4).contains(words));
}
