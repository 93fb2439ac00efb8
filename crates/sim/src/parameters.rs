//! Everything that a plant is made of: the paper's board, or one drawn from a population (`typical.rs`).

use zerorate_core::units::{Axis, Taps};

use crate::chamber::ChamberParameters;
use crate::channel::AxisParameters;
use crate::circuit::CircuitParameters;
use crate::converter::ConverterParameters;
use crate::gyro::GyroParameters;
use crate::potentiometer::PotentiometerParameters;
use crate::sensor::SensorParameters;
use crate::supply::SupplyParameters;
use crate::thermal::ThermalParameters;

/// Everything that a plant is made of. What differs from part to part beyond these (steps of the potentiometer, the
/// converter's curve, the supply's offset) and all noise are drawn from the seed given to [`crate::Plant::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct PlantParameters {
    /// X and Y.
    pub axes: [AxisParameters; 2],
    /// The chamber.
    pub chamber: ChamberParameters,
    /// The potentiometer.
    pub potentiometer: PotentiometerParameters,
    /// The A/D converter.
    pub converter: ConverterParameters,
    /// The fine supply.
    pub supply: SupplyParameters,
    /// The board's time constant behind the chamber's air, in seconds: circuit, potentiometer and reference are on it.
    /// Default 150, as the gyro's package.
    pub board_time_constant_s: f64,
    /// From a set's last scan to the effect of a wiper written because of it, in microseconds, at least: it moves no sooner than
    /// its frame has ended, but a processor takes time beside its buses, and on the bench it takes none. Default 170, as the image
    /// for the STM32F405 writes its second wiper (chip/README.md); 119 of it are bytes on the buses.
    pub wiper_latency_us: u32,
    /// From scan to scan in microseconds when the processor drives the A/D. Default 3000 (paper, 2.1: 40 groups of 500 a
    /// minute). The acquisition port has a register for it.
    pub direct_scan_period_us: u32,
}

/// The nominal count in volts: 4.096 V over 2^14.
pub(crate) const COUNT_V: f64 = 250e-6;

/// What the circuits are centred on, in counts (paper, 2.3).
pub(crate) const CENTRE_COUNTS: f64 = 8200.0;

/// The paper's temperature reading: counts at 25 C, and counts per kelvin (docs/paper.md; see [`SensorParameters`]).
const ROOM_COUNTS: f64 = 10_710.0;
const COUNTS_PER_K: f64 = 34.0;

/// One tap in counts, X and Y (paper, eq. 3 and 5: 1/0.0319906 and 1/0.0316093).
pub(crate) const COUNTS_PER_TAP: [f64; 2] = [31.26, 31.64];

/// Equation (1): the coefficients of T^0, T^1, T^2, T and the reading in counts. Y's linear coefficient is printed as
/// +0.676531, which no 14-bit converter could show (docs/paper.md, "its erratum"); the sign is turned here.
const EQUATION_1: [[f64; 3]; 2] = [[13_435.7, -0.894_782, 0.375_298e-4], [12_516.1, -0.676_531, 0.276_524e-4]];

impl PlantParameters {
    /// The paper's board: at N0 and settled, its noise-free readings are equation (1) of the temperature reading.
    #[must_use]
    pub fn paper() -> Self {
        Self::of_axes(Axis::BOTH.map(paper_axis))
    }

    /// A board with the given axes and everything else at its default.
    #[must_use]
    pub fn of_axes(axes: [AxisParameters; 2]) -> Self {
        Self {
            axes,
            chamber: ChamberParameters::default(),
            potentiometer: PotentiometerParameters::default(),
            converter: ConverterParameters::default(),
            supply: SupplyParameters::default(),
            board_time_constant_s: 150.0,
            wiper_latency_us: 170,
            direct_scan_period_us: 3000,
        }
    }

    /// Volts at a nominal wiper at a tap: the ideal divider.
    pub(crate) fn ideal_wiper_v(supply_v: f64, tap: Taps) -> f64 {
        supply_v * f64::from(tap.get()) / 1023.0
    }
}

fn paper_axis(axis: Axis) -> AxisParameters {
    let circuit = CircuitParameters::with_gain(CircuitParameters::gain_of(COUNTS_PER_TAP[axis.index()]));
    AxisParameters {
        gyro: GyroParameters::with_null(paper_null_v(EQUATION_1[axis.index()], &circuit)),
        thermal: ThermalParameters::default(),
        sensor: SensorParameters::default(),
        circuit,
    }
}

/// The null voltage over x, the die's temperature less 25 C, that gives the reading `c0 + c1 T + c2 T^2` at
/// `T = 10 710 + 34 x` counts.
///
/// The reading times 250 uV is `centre + gain (wiper - null)`; solved for the null. The paper measured its equation
/// through the whole board, so what the board itself drifts by (the divider's ratio, the amplifier's offset, the
/// reference, the last one at the centre) is in it already, and is taken out of the gyro's part.
fn paper_null_v([c0, c1, c2]: [f64; 3], circuit: &CircuitParameters) -> [f64; 4] {
    let potentiometer = PotentiometerParameters::default();
    let reference_tempco_per_k = ConverterParameters::default().reference_tempco_per_k;
    let wiper_v = PlantParameters::ideal_wiper_v(potentiometer.supply_v, Taps::MIDDLE);
    let reading = [
        c0 + ROOM_COUNTS * (c1 + ROOM_COUNTS * c2),
        COUNTS_PER_K * (c1 + 2.0 * c2 * ROOM_COUNTS),
        COUNTS_PER_K * COUNTS_PER_K * c2,
    ];
    let behind_v_per_k = circuit.offset_tempco_v_per_k - reference_tempco_per_k * CENTRE_COUNTS * COUNT_V;
    let board_v_per_k = wiper_v * potentiometer.ratiometric_tempco_per_k + behind_v_per_k / circuit.gain;
    [
        wiper_v + (circuit.centre_v - COUNT_V * reading[0]) / circuit.gain,
        board_v_per_k - COUNT_V * reading[1] / circuit.gain,
        -COUNT_V * reading[2] / circuit.gain,
        0.0,
    ]
}
