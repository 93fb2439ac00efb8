//! What goes wrong on a bench is said in a sentence that names the culprit and what to do.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use zerorate_bench::calibrate::calibrate;
use zerorate_bench::calibrated::Unit;
use zerorate_bench::checkpoint::Keep;
use zerorate_bench::error::BenchError;
use zerorate_bench::instruments::{InstrumentError, Supply};
use zerorate_bench::measure::measure;
use zerorate_bench::plan::{Part, Plan};
use zerorate_bench::plants::PlantKind;
use zerorate_bench::run::{Progress, Recorder, Session, Silent};
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_cal::recording::Recording;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Axis, Volts};
use zerorate_sim::{Plant, PlantParameters};

fn fails(plant: Plant, setup: &SetUp) -> BenchError {
    let mut bench = simulated::bench(plant, setup, &UnitSerial::new());
    let mut progress = Silent;
    let mut session = Session::new(&mut bench, setup, &mut progress);
    measure(&mut session, "", Recorder::discarding(), Recorder::discarding()).unwrap_err()
}

#[test]
fn an_experiment_that_leaves_the_converter_is_named_with_the_supply() {
    let mut setup = SetUp::paper();
    setup.trim.span_counts = 8000.0;
    setup.board.input_volts_per_count *= 1.2;
    let error = fails(PlantKind::Paper.build(1), &setup);
    assert!(matches!(error, BenchError::Saturated { .. }), "{error}");
    assert!(error.to_string().contains("trim.span_counts smaller"), "{error}");
}

/// The paper's board with another voltage across the potentiometer, its centre adjusted with it.
fn with_potentiometer_supply(volts: f64) -> Plant {
    let mut parameters = PlantParameters::paper();
    let missing = 0.5 * (parameters.potentiometer.supply_v - volts);
    parameters.potentiometer.supply_v = volts;
    for axis in &mut parameters.axes {
        axis.circuit.centre_v += axis.circuit.gain * missing;
    }
    Plant::new(parameters, 1)
}

#[test]
fn a_potentiometer_without_its_supply_is_named() {
    let error = fails(with_potentiometer_supply(0.01), &SetUp::paper());
    assert!(matches!(error, BenchError::WiperDead { .. }), "{error}");
}

#[test]
fn a_centre_out_of_reach_is_named_with_the_supply_and_the_tap() {
    // A part with a tenth of the supply: 3 counts a tap, and 511 taps do not make 4000 counts.
    let mut setup = SetUp::paper();
    setup.trim.span_counts = 4000.0;
    let error = fails(with_potentiometer_supply(0.5), &setup);
    assert!(matches!(error, BenchError::CentreOutOfReach { .. }), "{error}");
    assert!(error.to_string().contains("the search ended at tap"), "{error}");
}

/// A supply that is told its voltages and never wired to the inputs: the gyros stay there.
struct NotWired(Box<dyn Supply>);

impl Supply for NotWired {
    fn feed(&mut self, _: Volts) -> Result<(), InstrumentError> {
        Ok(())
    }

    fn connect_gyros(&mut self) -> Result<(), InstrumentError> {
        self.0.connect_gyros()
    }

    fn gyro_output(&mut self, axis: Axis) -> Result<Volts, InstrumentError> {
        self.0.gyro_output(axis)
    }
}

/// Counts the parts that begin.
#[derive(Default)]
struct Parts(Vec<Part>);

impl Progress for Parts {
    fn part(&mut self, plan: &Plan, place: usize) {
        self.0.push(plan.parts[place].0);
    }

    fn phase(&mut self, _: &str, _: u32) {}

    fn step(&mut self, _: f64) {}
}

#[test]
fn a_trim_experiment_that_came_to_nothing_is_run_again_and_the_ramp_before_it_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("calibration");
    let mut setup = SetUp::paper();
    setup.chamber.soaks_c = Vec::new();
    let run = |keep, wired: bool| {
        let unit = Unit::new("ZR-1", None).unwrap();
        let mut bench = simulated::bench(PlantKind::Paper.build(1), &setup, &unit.serial);
        if !wired {
            bench.supply = Box::new(NotWired(bench.supply));
        }
        let mut parts = Parts::default();
        (calibrate(&mut bench, &setup, unit, &out, &mut parts, keep), parts.0)
    };
    for keep in [Keep::Anew, Keep::Resume] {
        let (failed, parts) = run(keep, false);
        let told = failed.unwrap_err().to_string();
        assert!(told.contains("check that what is fed changes the reading"), "{told}");
        assert_eq!(parts.contains(&Part::FullTemperature), keep == Keep::Anew, "{parts:?}");
        assert_eq!(parts.last(), Some(&Part::TrimExperiment), "{parts:?}");
    }
    let (summary, parts) = run(Keep::Resume, true);
    let summary = summary.unwrap();
    assert_eq!((summary.serial.as_str(), parts[0]), ("ZR-1", Part::TrimExperiment));
    let without_soaks = summary.recordings.iter().all(|recording| recording.file != "soaks.parquet");
    assert!(without_soaks && !out.join("soaks.parquet").exists(), "soaks that were not made have no recording");
    for attempt in ["trim-sweep.cut.arrows", "trim-sweep.cut-1.arrows"] {
        let kept = Recording::read(&(&out.join("in-progress").join(attempt)).into()).unwrap();
        assert!(kept.groups() > 21 * 2, "{attempt}: what failed is kept");
    }
}

#[test]
fn a_chamber_that_is_sent_beyond_its_limits_refuses() {
    let mut setup = SetUp::paper();
    setup.chamber.hot_c = 170.0;
    let error = fails(PlantKind::Paper.build(1), &setup).to_string();
    assert!(error.contains("170"), "{error}");
}

#[test]
fn a_ramp_too_narrow_to_fit_is_rejected_with_its_span() {
    let mut setup = SetUp::paper();
    setup.chamber.hot_c = -35.0;
    let error = fails(PlantKind::Paper.build(1), &setup).to_string();
    assert!(error.contains("spans") && error.contains("record a wider range"), "{error}");
    assert!(!error.contains("allow"), "what this command has not: {error}");
}

#[test]
fn an_output_folder_that_cannot_be_written_is_named_before_anything_is_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("results");
    std::fs::write(&file, "").unwrap();
    let setup = SetUp::paper();
    let unit = Unit::new("ZR-1", None).unwrap();
    let mut bench = simulated::bench(PlantKind::Paper.build(1), &setup, &unit.serial);
    let error = calibrate(&mut bench, &setup, unit, &file, &mut Silent, Keep::Nothing).unwrap_err().to_string();
    assert!(error.contains("results") && error.contains("Earlier results are untouched"), "{error}");
}

#[test]
fn a_serial_too_long_for_a_record_is_refused() {
    let error = Unit::new("a serial of far more than thirty-two bytes", None).unwrap_err().to_string();
    assert!(error.contains("32 bytes"), "{error}");
}
