//! The signal path of one axis: gyro or supply, zero-adjust circuit, low-pass, to the A/D's input.
//!
//! The path is evaluated at the scans. Between two of them the low-pass's input is constant (temperatures and slow noise
//! move on in steps of a tenth of a second, a wiper at the instant it is written), and for a constant input the low-pass
//! is solved exactly. White noise behind a first-order low-pass is an autoregressive sequence at the scans, which is
//! drawn as such, exactly, too. Of a scan of several passes the last one is the scan's instant, and what is white between two
//! scans is drawn on the way from one to the other (`oversampling.rs`).

use zerorate_core::units::Axis;

use crate::circuit::CircuitParameters;
use crate::gyro::{Gyro, GyroParameters};
use crate::oversampling::{Bridge, Pass, Underway};
use crate::random::{Source, Stream};
use crate::sensor::SensorParameters;
use crate::thermal::{ThermalParameters, ThermalPath};
use crate::vibration::Vibration;

/// What one axis is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisParameters {
    /// The gyro.
    pub gyro: GyroParameters,
    /// Its thermal path.
    pub thermal: ThermalParameters,
    /// Its temperature output.
    pub sensor: SensorParameters,
    /// Its zero-adjust circuit.
    pub circuit: CircuitParameters,
}

/// The same node with one cause after the other added: with the wiper at N0; with the actual wiper; turning; with slow
/// noise. The first three are what [`crate::Truth`] tells, the last one (and white noise) is what is sampled.
type Signals = [f64; 4];

/// What stands in the rate's place at the circuit's input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Input {
    Gyro,
    /// The fine supply: its voltage and its noise, both in volts.
    Supply(f64, f64),
}

/// The wiper's voltage at present and at N0, at the board's temperature, in volts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WiperVolts {
    pub(crate) actual_v: f64,
    pub(crate) middle_v: f64,
}

/// How the low-pass moves on in a step of time.
#[derive(Debug, Clone, Copy)]
struct Step {
    dt_s: f64,
    /// The part of a difference that is left.
    left: f64,
    /// The standard deviation of white noise drawn anew, for one of 1 in front.
    drawn: f64,
}

/// One axis's path.
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    pub(crate) axis: Axis,
    circuit: CircuitParameters,
    sensor: SensorParameters,
    pub(crate) gyro: Gyro,
    pub(crate) thermal: ThermalPath,
    inputs_v: Signals,
    filtered_v: Signals,
    white_v: Underway,
    /// Standard deviation of the white noise behind the low-pass.
    white_deviation_v: f64,
    /// Standard deviations of the noise added at the A/D, zero-rate and temperature channel.
    late_v: f64,
    sensor_noise_v: f64,
    sensor_v: f64,
    sensor_white_v: Underway,
    /// The vibration, and its amplitude at the amplifier's output.
    pub(crate) vibration: Option<Vibration>,
    vibration_v_per_dps: f64,
    step: Step,
    white: Stream,
    late: Stream,
    sensor_noise: Stream,
    between: Stream,
}

impl Channel {
    /// A path that has settled in air of the given temperature. `converter_noise_v` is the A/D's own.
    pub(crate) fn new(parameters: AxisParameters, air_c: f64, converter_noise_v: f64, seed: u64, axis: Axis) -> Self {
        let AxisParameters { gyro, thermal, sensor, circuit } = parameters;
        Self {
            axis,
            gyro: Gyro::new(gyro, seed, axis),
            thermal: ThermalPath::settled(thermal, air_c),
            inputs_v: [circuit.centre_v; 4],
            filtered_v: [circuit.centre_v; 4],
            white_v: Underway::default(),
            white_deviation_v: 0.0,
            late_v: libm::hypot(circuit.noise_v, converter_noise_v),
            sensor_noise_v: libm::hypot(sensor.noise_v, converter_noise_v),
            sensor_v: 0.0,
            sensor_white_v: Underway::default(),
            vibration: None,
            vibration_v_per_dps: 0.0,
            step: Step { dt_s: 0.0, left: 1.0, drawn: 0.0 },
            white: Stream::of_axis(seed, Source::GyroWhite, axis),
            late: Stream::of_axis(seed, Source::CircuitNoise, axis),
            sensor_noise: Stream::of_axis(seed, Source::SensorNoise, axis),
            between: Stream::of_axis(seed, Source::BetweenScans, axis),
            circuit,
            sensor,
        }
    }

    /// The noise-free output of the amplifier, before its low-pass, for a wiper voltage. In volts.
    pub(crate) fn steady_v(&self, wiper_v: f64, input: Input, board_c: f64) -> f64 {
        self.circuit.output_v(wiper_v, self.at_rest_v(input), board_c)
    }

    fn at_rest_v(&self, input: Input) -> f64 {
        match input {
            Input::Gyro => self.gyro.at_rest_v(self.thermal.package_c(), self.thermal.die_c()),
            Input::Supply(volts, _) => volts,
        }
    }

    /// What a voltmeter shows at the gyro's output, its white noise averaged out. In volts.
    pub(crate) fn gyro_output_v(&self) -> f64 {
        let die_c = self.thermal.die_c();
        self.at_rest_v(Input::Gyro) + self.gyro.rotation_v(die_c) + self.gyro.slow_noise_v(die_c)
    }

    /// Works out the low-pass's inputs anew, after something slow or the wiper has changed.
    pub(crate) fn refresh(&mut self, wiper: WiperVolts, input: Input, board_c: f64) {
        let die_c = self.thermal.die_c();
        let at_rest_v = self.at_rest_v(input);
        let (rotation_v, slow_v) = match input {
            Input::Gyro => (self.gyro.rotation_v(die_c), self.gyro.slow_noise_v(die_c)),
            Input::Supply(..) => (0.0, 0.0),
        };
        let output = |wiper_v, rate_v| self.circuit.output_v(wiper_v, rate_v, board_c);
        self.inputs_v = [
            output(wiper.middle_v, at_rest_v),
            output(wiper.actual_v, at_rest_v),
            output(wiper.actual_v, at_rest_v + rotation_v),
            output(wiper.actual_v, at_rest_v + rotation_v + slow_v),
        ];
        self.white_deviation_v = match input {
            Input::Gyro => {
                let density = self.gyro.white_v_per_root_hz() * self.circuit.gain;
                density * self.circuit.noise_bandwidth_hz().sqrt()
            }
            Input::Supply(_, noise_v) => noise_v,
        };
        self.vibration_v_per_dps = match input {
            Input::Gyro => -self.circuit.gain * self.gyro.scale_v_per_dps(die_c),
            Input::Supply(..) => 0.0,
        };
        self.sensor_v = self.sensor.volts(self.thermal.package_c());
    }

    /// Moves the low-pass on to an instant between scans.
    pub(crate) fn filter(&mut self, dt_s: f64) {
        let left = self.circuit.left_after(dt_s);
        self.move_on(left);
    }

    /// Draws the noise that a scan's last pass has, `scan_dt_s` after the last scan.
    #[inline]
    pub(crate) fn draw(&mut self, scan_dt_s: f64) {
        if (scan_dt_s - self.step.dt_s).abs() > 1e-12 {
            let left = self.circuit.left_after(scan_dt_s);
            self.step = Step { dt_s: scan_dt_s, left, drawn: (1.0 - left * left).sqrt() };
        }
        let drawn = self.white_deviation_v * self.step.drawn * self.white.normal();
        self.white_v.end = self.white_v.now * self.step.left + drawn;
        self.sensor_white_v.end = self.sensor_noise_v * self.sensor_noise.normal();
    }

    /// Moves the low-pass on to a pass at an instant, `dt_s` after it was last moved on; gives the temperature and the zero-rate
    /// channel's voltage.
    #[inline]
    pub(crate) fn pass(&mut self, dt_s: f64, at_s: f64, pass: Pass) -> [f64; 2] {
        let is_a_scan_on = (dt_s - self.step.dt_s).abs() < 1e-12;
        self.move_on(if is_a_scan_on { self.step.left } else { self.circuit.left_after(dt_s) });
        let [sensor_white_v, white_v, late] = if pass.is_last() {
            [self.sensor_white_v.arrive(), self.white_v.arrive(), self.late.normal()]
        } else {
            let bridge = self.bridge(pass);
            let mut drawn = |deviation_v| deviation_v * self.between.normal();
            [
                self.sensor_white_v.cross(bridge, drawn(self.sensor_noise_v)),
                self.white_v.cross(bridge, drawn(self.white_deviation_v)),
                drawn(1.0),
            ]
        };
        let mut zero_rate_v = self.filtered_v[3] + white_v + self.late_v * late;
        if let Some(vibration) = self.vibration {
            let seen = vibration.behind(self.circuit.cutoff_hz, at_s);
            zero_rate_v += self.vibration_v_per_dps * vibration.rate_dps * seen;
        }
        [self.sensor_v + sensor_white_v, zero_rate_v]
    }

    /// From the pass before this one to it; before the first is the last scan.
    fn bridge(&self, pass: Pass) -> Bridge {
        let (of, number) = (f64::from(pass.of), f64::from(pass.number));
        #[allow(clippy::cast_precision_loss)] // 2^53 ns are a hundred days.
        let apart_s = pass.period_ns as f64 * 1e-9 / of;
        let rest_s = apart_s * (of - number);
        let before_s = if pass.is_first() { self.step.dt_s - rest_s } else { apart_s };
        Bridge::between(self.circuit.left_after(before_s), self.circuit.left_after(rest_s))
    }

    #[inline]
    fn move_on(&mut self, left: f64) {
        for (filtered, input) in self.filtered_v.iter_mut().zip(self.inputs_v) {
            *filtered = input + (*filtered - input) * left;
        }
    }

    /// The noise-free signals behind the low-pass: at N0, with the actual wiper, and turning. In volts.
    #[inline]
    pub(crate) fn filtered_v(&self) -> [f64; 3] {
        [self.filtered_v[0], self.filtered_v[1], self.filtered_v[2]]
    }

    /// The temperature channel's noise-free voltage at a package temperature.
    pub(crate) fn sensor_v(&self, package_c: f64) -> f64 {
        self.sensor.volts(package_c)
    }

    /// Where the amplifier stands when its input is broken, in volts.
    pub(crate) fn high_rail_v(&self) -> f64 {
        self.circuit.high_rail_v
    }

    /// Lets the low-pass settle on its inputs.
    pub(crate) fn settle(&mut self) {
        self.filtered_v = self.inputs_v;
    }
}
