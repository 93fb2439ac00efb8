//! What crates/sim assumes of the circuit, in this one place.
//!
//! xtask may not use sim (ARCHITECTURE.md, Arrows), so these are copies; [`SAID`] has the lines that they are copies of.

use crate::workspace::Workspace;

/// X and Y: `COUNTS_PER_TAP` (paper, eq. 3 and 5: 1/0.0319906 and 1/0.0316093).
pub const COUNTS_PER_TAP: [f64; 2] = [31.26, 31.64];
/// `CENTRE_COUNTS` (paper, 2.3).
pub const CENTRE_COUNTS: f64 = 8200.0;
/// `COUNT_V`: 4.096 V over 2^14.
pub const COUNT_V: f64 = 250e-6;
/// The potentiometer's end to end voltage: `PotentiometerParameters::supply_v`.
pub const STRING_V: f64 = 5.0;
/// The middle tap N0 (paper, 2.1).
pub const MIDDLE_TAP: f64 = 511.0;
/// Volts per deg/s: `GyroParameters::scale_v_per_dps`.
pub const SCALE_V_PER_DPS: f64 = 6e-3;
/// `CircuitParameters::cutoff_hz`.
pub const CUTOFF_HZ: f64 = 40.0;
/// `CircuitParameters::low_rail_v` and `high_rail_v`.
pub const RAILS_V: [f64; 2] = [0.02, 4.98];
/// `CircuitParameters::gain_tempco_per_k` and `offset_tempco_v_per_k`.
pub const GAIN_DRIFT_PER_K: f64 = 10e-6;
pub const OFFSET_DRIFT_V_PER_K: f64 = 2e-6;
/// `SensorParameters`: 8.5 mV/K is 34 counts, and -40 C is 8500.
pub const COUNTS_PER_K: f64 = 34.0;
pub const COLD_COUNTS: f64 = 8500.0;

/// The gain that makes a tap so many counts: `CircuitParameters::gain_of`.
pub fn gain(axis: usize) -> f64 {
    COUNTS_PER_TAP[axis] * COUNT_V * 1023.0 / STRING_V
}

/// `CircuitParameters::output_v` at 25 C.
pub fn output_v(axis: usize, wiper_v: f64, rate_v: f64) -> f64 {
    let output_v = CENTRE_COUNTS * COUNT_V + gain(axis) * (wiper_v - rate_v);
    output_v.clamp(RAILS_V[0], RAILS_V[1])
}

/// Where sim says so.
const SAID: [(&str, &str); 10] = [
    ("parameters.rs", "COUNTS_PER_TAP: [f64; 2] = [31.26, 31.64]"),
    ("parameters.rs", "CENTRE_COUNTS: f64 = 8200.0"),
    ("parameters.rs", "COUNT_V: f64 = 250e-6"),
    ("circuit.rs", "low_rail_v: 0.02,"),
    ("circuit.rs", "high_rail_v: 4.98,"),
    ("circuit.rs", "cutoff_hz: 40.0,"),
    ("circuit.rs", "gain_tempco_per_k: 10e-6,"),
    ("circuit.rs", "offset_tempco_v_per_k: 2e-6,"),
    ("gyro.rs", "scale_v_per_dps: 6e-3,"),
    ("sensor.rs", "room_v: 2.6775, slope_v_per_k: 8.5e-3,"),
];

/// Lines of sim that are no longer as [`SAID`].
pub fn says_otherwise(workspace: &Workspace) -> Vec<String> {
    let is_said =
        |file: &str, line: &str| workspace.read(format!("crates/sim/src/{file}")).is_ok_and(|text| text.contains(line));
    let unsaid = SAID.iter().filter(|(file, line)| !is_said(file, line));
    unsaid
        .map(|(file, line)| {
            format!("crates/sim/src/{file} no longer says `{line}`: see crates/xtask/src/circuit/sim.rs")
        })
        .collect()
}
