//! The whole of `calibrate`, shortened: through the verilated block and through the simulated port.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use std::path::Path;

use serde_json::Value;
use zerorate_bench::calibrate::calibrate;
use zerorate_bench::calibrated::Unit;
use zerorate_bench::checkpoint::Keep;
use zerorate_bench::instruments::Bench;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::run::Silent;
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_core::record::UnitSerial;
use zerorate_gateware_bench::GatewareAcquisition;
use zerorate_sim::Plant;

/// Few and short groups, for the block's clock is simulated edge by edge.
const SHORTENED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../shortened.toml");

const SEED: u64 = 1;

/// The run's summary but for its wall time, as it is written; all of its files stay in a folder of this name.
fn summary(name: &str, bench: fn(Plant, &SetUp, &UnitSerial) -> Bench) -> Value {
    let setup = SetUp::read(Path::new(SHORTENED)).unwrap();
    let unit = Unit::new("ZR-0001", Some((PlantKind::Paper, SEED))).unwrap();
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    println!("{name}: {}", out.join("report.html").display());
    let mut bench = bench(PlantKind::Paper.build(SEED), &setup, &unit.serial);
    calibrate(&mut bench, &setup, unit, &out, &mut Silent, Keep::Nothing).unwrap();
    let mut summary: Value = serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
    assert!(summary.as_object_mut().unwrap().remove("wall_s").is_some());
    summary
}

#[test]
fn the_summaries_of_port_and_gateware_are_the_same() {
    let by_port = summary("port", simulated::bench);
    assert_ne!(by_port["verdict"], "rejected", "it keeps to the paper's limits all the same");
    assert_eq!(by_port, summary("gateware", simulated::bench_on::<GatewareAcquisition>));
}
