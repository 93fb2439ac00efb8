//! A population of real drift curves: 48 axes of 16 inertial units, fitted in the field by their owners.
//!
//! The numbers are from the parameter files of ArduPilot/MethodicConfigurator at 436a9dd (GPL-3.0-or-later), which their
//! owners made with ArduPilot's temperature calibration. They are of digital units with their own scale; `typical.rs`
//! says how they become an analogue part.

/// The bias of one axis: `c1 x + c2 x^2 + c3 x^3` in deg/s, `x` the temperature less 35 C.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Curve {
    /// The coldest temperature of the fit in degrees C.
    pub(crate) coldest_c: f64,
    /// The hottest temperature of the fit in degrees C.
    pub(crate) hottest_c: f64,
    /// c1, c2, c3 in deg/s per kelvin to the powers 1 to 3.
    pub(crate) coefficients: [f64; 3],
}

/// The temperature at which the curves are zero, in degrees C.
pub(crate) const REFERENCE_C: f64 = 35.0;

impl Curve {
    /// The bias in deg/s at a temperature.
    pub(crate) fn bias_dps(&self, temperature_c: f64) -> f64 {
        let x = temperature_c - REFERENCE_C;
        let [c1, c2, c3] = self.coefficients;
        x * (c1 + x * (c2 + x * c3))
    }

    /// The distance in deg/s between the curve's extremes over its own range.
    pub(crate) fn peak_to_peak_dps(&self) -> f64 {
        let at = |step: u32| self.coldest_c + (self.hottest_c - self.coldest_c) * f64::from(step) / 200.0;
        let bias = (0..=200).map(|step| self.bias_dps(at(step)));
        let (low, high) = bias.fold((f64::MAX, f64::MIN), |(low, high), b| (low.min(b), high.max(b)));
        high - low
    }
}

/// The middle of the curves' peaks to peak, in deg/s.
pub(crate) fn median_peak_to_peak_dps() -> f64 {
    let mut all = CURVES.map(|curve| curve.peak_to_peak_dps());
    all.sort_by(f64::total_cmp);
    (all[CURVES.len() / 2 - 1] + all[CURVES.len() / 2]) / 2.0
}

/// Shortens the table's lines.
const fn curve(coldest_c: f64, hottest_c: f64, coefficients: [f64; 3]) -> Curve {
    Curve { coldest_c, hottest_c, coefficients }
}

/// Units 1 to 16, axes X, Y, Z each.
#[rustfmt::skip]
pub(crate) const CURVES: [Curve; 48] = [
    curve(-13.2, 45.6, [0.000770572, 0.000167369, 2.5327e-06]),
    curve(-13.2, 45.6, [-0.00795747, -3.42135e-05, -2.9866e-06]),
    curve(-13.2, 45.6, [0.00208373, 0.000433211, 4.20265e-06]),
    curve(-5.9, 49.7, [-0.0244589, 7.77618e-07, -3.55291e-07]),
    curve(-5.9, 49.7, [0.00998603, -7.03604e-05, -6.73323e-06]),
    curve(-5.9, 49.7, [0.00604845, 1.7902e-05, 2.8209e-06]),
    curve(12.0, 60.0, [0.00351676, -4.15967e-05, -5.11193e-07]),
    curve(12.0, 60.0, [-0.00138431, 3.07582e-05, 9.12206e-07]),
    curve(12.0, 60.0, [0.00154073, -9.2665e-06, -1.73532e-06]),
    curve(17.49131, 70.26159, [-0.0137352, -0.000138375, 3.5901e-06]),
    curve(17.49131, 70.26159, [-0.0173171, 6.2407e-05, -1.93975e-06]),
    curve(17.49131, 70.26159, [-0.00593042, 3.96425e-05, -6.63313e-07]),
    curve(-19.9, 0.0, [-0.0548821, -0.00134235, -7.63369e-06]),
    curve(-19.9, 0.0, [0.0490201, 0.00106972, 8.08839e-06]),
    curve(-19.9, 0.0, [0.132043, 0.00333276, 2.71765e-05]),
    curve(-12.6, 0.0, [-0.265217, -0.00427058, -1.62134e-05]),
    curve(-12.6, 0.0, [-0.593898, -0.0133009, -9.85452e-05]),
    curve(-12.6, 0.0, [0.644136, 0.0156129, 0.000129369]),
    curve(-14.6, 56.0, [-0.0018698, -3.50323e-05, -5.57373e-07]),
    curve(-14.6, 56.0, [0.0045639, -0.00011694, 1.11681e-06]),
    curve(-14.6, 56.0, [-0.00865878, 7.09511e-05, 8.0787e-08]),
    curve(-5.4, 39.2, [-0.0290824, -0.00134566, -1.48747e-05]),
    curve(-5.4, 39.2, [-0.0373959, -0.00140006, -1.89808e-05]),
    curve(-5.4, 39.2, [-0.00545491, -0.000480777, -5.48258e-06]),
    curve(-12.6, 65.1, [-0.00176596, 5.29131e-05, 4.16409e-06]),
    curve(-12.6, 65.1, [0.00195769, 4.54874e-05, 7.28e-07]),
    curve(-12.6, 65.1, [-0.00226702, -4.3349e-05, -5.61556e-07]),
    curve(-8.3, 52.2, [-0.0113941, 5.41862e-05, 7.00326e-07]),
    curve(-8.3, 52.2, [0.00464427, -6.93163e-05, -7.16369e-07]),
    curve(-8.3, 52.2, [0.0108655, 1.56337e-05, 1.13681e-06]),
    curve(-16.3, 66.7, [0.00240017, -4.06399e-06, -1.78763e-06]),
    curve(-16.3, 66.7, [0.004058, 3.71081e-05, 8.82756e-07]),
    curve(-16.3, 66.7, [-0.0067231, -4.07264e-05, -1.1941e-06]),
    curve(-2.2, 65.3, [-0.0218756, 6.04661e-05, 6.06567e-06]),
    curve(-2.2, 65.3, [-0.0133348, 0.000162773, 1.05636e-06]),
    curve(-2.2, 65.3, [-0.000529595, 8.01121e-05, 4.12043e-06]),
    curve(-5.7, 49.8, [-0.0153109, 9.96676e-05, 2.3827e-06]),
    curve(-5.7, 49.8, [0.0121796, 2.13496e-05, -2.09118e-06]),
    curve(-5.7, 49.8, [0.0148041, 0.000161765, 4.10364e-06]),
    curve(-0.1, 51.4, [0.0227428, 0.000197807, 3.48817e-06]),
    curve(-0.1, 51.4, [0.00223956, -9.11696e-06, -3.68504e-06]),
    curve(-0.1, 51.4, [-0.00396587, 2.70083e-05, 2.23419e-06]),
    curve(-30.1, 63.7, [-0.0105574, -9.22826e-05, -1.17817e-06]),
    curve(-30.1, 63.7, [-0.00728302, 0.000223565, 2.29412e-06]),
    curve(-30.1, 63.7, [-0.00352261, -3.33903e-05, -8.84418e-07]),
    curve(-14.7, 64.6, [-0.0275218, 0.00425083, 0.000101786]),
    curve(-14.7, 64.6, [0.000516194, -0.00201477, -5.83194e-05]),
    curve(-14.7, 64.6, [-0.00325717, -0.00015292, 8.51702e-07]),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_population_has_the_quantiles_that_its_source_gives() {
        let mut all = CURVES.map(|curve| curve.peak_to_peak_dps());
        all.sort_by(f64::total_cmp);
        assert!((all[4] - 0.06).abs() < 0.02, "10 %: {}", all[4]);
        assert!((median_peak_to_peak_dps() - 0.42).abs() < 0.03, "50 %: {}", median_peak_to_peak_dps());
        assert!((all[43] - 1.03).abs() < 0.3, "90 %: {}", all[43]);
    }
}
