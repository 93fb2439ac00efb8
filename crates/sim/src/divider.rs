//! The potentiometer as a voltage divider: tap in, volts out.

use zerorate_core::units::{Axis, Taps};

use crate::gyro::ROOM_C;
use crate::potentiometer::PotentiometerParameters;
use crate::random::{Source, Stream};

/// Steps between the ends of a 1024-tap potentiometer.
const STEPS: usize = 1023;

/// One of the part's two resistor strings.
#[derive(Debug, Clone)]
pub(crate) struct Divider {
    /// The wiper's voltage at each tap, at 25 C.
    volts: Vec<f64>,
    ratiometric_tempco_per_k: f64,
}

impl Divider {
    /// A string whose steps differ at random. The sum of their errors is a random walk; taking the straight line between
    /// its ends out of it leaves the end-point INL of the data sheet, zero at both ends.
    pub(crate) fn new(parameters: &PotentiometerParameters, seed: u64, axis: Axis) -> Self {
        let mut stream = Stream::of_axis(seed, Source::WiperSteps, axis);
        let mut walk = vec![0.0];
        for _ in 0..STEPS {
            walk.push(walk[walk.len() - 1] + parameters.dnl_lsb * stream.normal());
        }
        let slope = walk[STEPS] / STEPS as f64;
        let step_v = parameters.supply_v / STEPS as f64;
        let volts =
            walk.iter().enumerate().map(|(tap, sum)| (tap as f64 + sum - slope * tap as f64) * step_v).collect();
        Self { volts, ratiometric_tempco_per_k: parameters.ratiometric_tempco_per_k }
    }

    /// The wiper's voltage at a tap. It settles in about 5 us (data sheet), a thousandth of the low-pass behind it, and
    /// is taken to be there at once.
    pub(crate) fn volts(&self, tap: Taps, board_c: f64) -> f64 {
        self.volts[usize::from(tap.get())] * (1.0 + self.ratiometric_tempco_per_k * (board_c - ROOM_C))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors_lsb(seed: u64) -> Vec<f64> {
        let parameters = PotentiometerParameters::default();
        let divider = Divider::new(&parameters, seed, Axis::X);
        (0..1024)
            .map(|tap| divider.volts(Taps::new(tap).unwrap(), ROOM_C) * 1023.0 / parameters.supply_v - f64::from(tap))
            .collect()
    }

    #[test]
    fn the_ends_are_the_supply_s_and_the_steps_between_have_the_part_s_dnl() {
        let errors = errors_lsb(1);
        assert!(errors[0].abs() < 1e-9 && errors[1023].abs() < 1e-9);
        let squares: f64 = errors.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
        let dnl_lsb = (squares / 1023.0).sqrt();
        assert!((dnl_lsb - 0.06).abs() < 0.006, "{dnl_lsb}");
    }

    #[test]
    fn the_inl_stays_about_the_data_sheet_s_2_lsb() {
        let worst = (0..100).map(|seed| errors_lsb(seed).iter().fold(0.0_f64, |worst, e| worst.max(e.abs())));
        let mut worst: Vec<f64> = worst.collect();
        worst.sort_by(f64::total_cmp);
        assert!(worst[50] < 2.0 && worst[99] < 4.0, "{} {}", worst[50], worst[99]);
    }

    #[test]
    fn the_ratio_moves_by_its_tempco() {
        let divider = Divider::new(&PotentiometerParameters::default(), 1, Axis::Y);
        let ratio = divider.volts(Taps::MIDDLE, 125.0) / divider.volts(Taps::MIDDLE, 25.0);
        assert!((ratio - 1.0005).abs() < 1e-9, "{ratio}");
    }
}
