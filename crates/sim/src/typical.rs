//! A board drawn from a population of real drift curves.

use zerorate_core::units::{Axis, Taps};

use crate::channel::AxisParameters;
use crate::circuit::CircuitParameters;
use crate::gyro::{GyroParameters, ROOM_C};
use crate::parameters::{CENTRE_COUNTS, COUNT_V, COUNTS_PER_TAP, PlantParameters};
use crate::population::{CURVES, Curve, REFERENCE_C, median_peak_to_peak_dps};
use crate::potentiometer::PotentiometerParameters;
use crate::random::{Source, Stream};
use crate::sensor::SensorParameters;
use crate::thermal::ThermalParameters;

/// What the population's median peak to peak becomes on the analogue board, in counts.
///
/// The curves are of digital units that have been trimmed in the factory, 0.4 deg/s over their range. The paper's parts
/// drift by 10 deg/s over theirs (440 counts of 1/38 deg/s). So the population gives the shapes and how units differ
/// from each other; the size is the analogue part's, with a median somewhat under the paper's two.
const MEDIAN_COUNTS: f64 = 250.0;

/// The largest peak to peak in counts. The population's worst units, fitted over a few cold degrees, are twenty times
/// its median; a board whose gyro left the converter's range would have been sorted out.
const LARGEST_COUNTS: f64 = 2000.0;

/// A unit's reading at 25 C is within this of the centre, in counts.
const ROOM_SPREAD_COUNTS: f64 = 300.0;

/// The temperatures onto which each curve's own range is laid, in degrees C: the test's.
const RANGE_C: [f64; 2] = [-40.0, 60.0];

impl PlantParameters {
    /// A board drawn from the population by a seed. Give the same seed to [`crate::Plant::new`] for the whole unit.
    #[must_use]
    pub fn typical(seed: u64) -> Self {
        let mut board = Stream::of_board(seed, Source::UnitBoard);
        let mut parameters = Self::of_axes(Axis::BOTH.map(|axis| typical_axis(seed, axis)));
        parameters.board_time_constant_s = board.uniform(100.0, 250.0);
        parameters.potentiometer.ratiometric_tempco_per_k = 5e-6 * board.normal();
        parameters.potentiometer.dnl_lsb = board.uniform(0.05, 0.10);
        parameters.converter.reference_tempco_per_k = board.uniform(-2e-6, 2e-6);
        parameters
    }
}

fn typical_axis(seed: u64, axis: Axis) -> AxisParameters {
    let stream = |source| Stream::of_axis(seed, source, axis);
    let mut draw = stream(Source::UnitCircuit);
    let mut circuit = CircuitParameters::with_gain(CircuitParameters::gain_of(COUNTS_PER_TAP[axis.index()]));
    circuit.gain *= 1.0 + 0.01 * draw.uniform(-1.0, 1.0);
    circuit.gain_tempco_per_k *= draw.normal();
    circuit.offset_tempco_v_per_k = 5e-6 * draw.normal();

    let mut draw = stream(Source::UnitCurve);
    let curve = CURVES[draw.pick(CURVES.len())];
    let room_counts = CENTRE_COUNTS + draw.uniform(-ROOM_SPREAD_COUNTS, ROOM_SPREAD_COUNTS);
    let mut gyro = GyroParameters::with_null(null_v(&curve, room_counts, &circuit));

    let mut draw = stream(Source::UnitGyro);
    gyro.scale_v_per_dps *= 1.0 + 0.02 * draw.uniform(-1.0, 1.0);
    gyro.scale_tempco_per_k *= draw.uniform(-1.0, 1.0);
    gyro.white_dps_per_root_hz *= draw.uniform(0.8, 1.25);
    gyro.flicker_dps *= draw.uniform(0.7, 1.5);
    gyro.gradient_dps_per_k = 0.05 * draw.normal();

    let mut draw = stream(Source::UnitThermal);
    let thermal = ThermalParameters {
        package_time_constant_s: draw.uniform(100.0, 250.0),
        die_time_constant_s: draw.uniform(2.0, 15.0),
        self_heating_k: draw.uniform(0.5, 2.0),
    };

    let mut draw = stream(Source::UnitSensor);
    let mut sensor = SensorParameters::default();
    sensor.slope_v_per_k *= 1.0 + 0.01 * draw.normal();
    sensor.room_v += 20.0 * COUNT_V * draw.normal();

    AxisParameters { gyro, thermal, sensor, circuit }
}

/// The null voltage over the die's temperature less 25 C: the curve, its own range laid on the test's, scaled to the
/// analogue part, with the reading at 25 C as given.
fn null_v(curve: &Curve, room_counts: f64, circuit: &CircuitParameters) -> [f64; 4] {
    let gyro_v_per_count = COUNT_V / circuit.gain;
    let peak_to_peak_dps = curve.peak_to_peak_dps();
    let counts = (MEDIAN_COUNTS * peak_to_peak_dps / median_peak_to_peak_dps()).min(LARGEST_COUNTS);
    let v_per_dps = counts * gyro_v_per_count / peak_to_peak_dps;

    // At x = die - 25 C the curve is taken at `start + slope x` from its reference.
    let slope = (curve.hottest_c - curve.coldest_c) / (RANGE_C[1] - RANGE_C[0]);
    let start_k = curve.coldest_c + slope * (ROOM_C - RANGE_C[0]) - REFERENCE_C;
    let [c1, c2, c3] = curve.coefficients;

    let supply_v = PotentiometerParameters::default().supply_v;
    let wiper_v = PlantParameters::ideal_wiper_v(supply_v, Taps::MIDDLE);
    [
        wiper_v + (circuit.centre_v - COUNT_V * room_counts) / circuit.gain,
        v_per_dps * slope * (c1 + start_k * (2.0 * c2 + start_k * 3.0 * c3)),
        v_per_dps * slope * slope * (c2 + 3.0 * start_k * c3),
        v_per_dps * slope * slope * slope * c3,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The settled reading at N0 of an axis, the board's own drift left out, in counts.
    fn reading(axis: &AxisParameters, die_c: f64) -> f64 {
        let x = die_c - ROOM_C;
        let null_v = axis.gyro.null_v.iter().rev().fold(0.0, |sum, c| sum * x + c);
        axis.circuit.output_v(PlantParameters::ideal_wiper_v(5.0, Taps::MIDDLE), null_v, ROOM_C) / COUNT_V
    }

    fn range(axis: &AxisParameters) -> (f64, f64) {
        let readings = (0..=100).map(|step| reading(axis, -40.0 + f64::from(step)));
        readings.fold((f64::MAX, f64::MIN), |(low, high), r| (low.min(r), high.max(r)))
    }

    #[test]
    fn drawn_units_have_the_population_s_spread_and_stay_in_the_converter() {
        let mut drifts = Vec::new();
        for seed in 0..400 {
            for axis in &PlantParameters::typical(seed).axes {
                let (low, high) = range(axis);
                assert!(low > 3000.0 && high < 13_400.0, "seed {seed}: {low} to {high}");
                assert!((reading(axis, 25.0) - 8200.0).abs() <= 300.0);
                drifts.push(high - low);
            }
        }
        drifts.sort_by(f64::total_cmp);
        let percentile = |percent: usize| drifts[percent * drifts.len() / 100];
        assert!((200.0..300.0).contains(&percentile(50)), "{}", percentile(50));
        assert!(percentile(10) < 60.0 && percentile(90) > 500.0, "{} {}", percentile(10), percentile(90));
        assert!(drifts[drifts.len() - 1] < 2001.0);
    }

    #[test]
    fn the_laid_out_curve_is_the_population_s() {
        let circuit = CircuitParameters::with_gain(1.6);
        for curve in &CURVES {
            let null_v = null_v(curve, 8200.0, &circuit);
            let at = |die_c: f64| null_v.iter().rev().fold(0.0, |sum, c| sum * (die_c - ROOM_C) + c);
            let laid = |die_c: f64| curve.coldest_c + (curve.hottest_c - curve.coldest_c) * (die_c + 40.0) / 100.0;
            let bias = |die_c: f64| curve.bias_dps(laid(die_c));
            // Both are the same function up to one scale and an offset.
            let scale = (at(60.0) - at(-40.0)) / (bias(60.0) - bias(-40.0));
            for die_c in [-20.0, 0.0, 25.0, 45.0] {
                let expected = at(-40.0) + scale * (bias(die_c) - bias(-40.0));
                assert!((at(die_c) - expected).abs() < 1e-9, "{curve:?}");
            }
        }
    }

    #[test]
    fn a_unit_repeats_by_its_seed() {
        assert_eq!(PlantParameters::typical(7), PlantParameters::typical(7));
        assert_ne!(PlantParameters::typical(7), PlantParameters::typical(8));
    }
}
