//! The paper's numbers, to stand beside a run's: Chinese Journal of Sensors and Actuators 25(12), 2012,
//! doi 10.3969/j.issn.1004-1699.2012.12.019.

use zerorate_core::units::Axis;

/// What the paper gives for one axis.
pub(super) struct PaperAxis {
    /// Equation (1), lowest power first, counts over counts; Y with the sign of its linear term turned.
    pub drift: [f64; 3],
    /// The linear coefficient as printed, where it is in error.
    pub printed_linear: Option<f64>,
    /// Whether the paper compensated this axis; the other was its control.
    pub compensated: bool,
    /// a of equation (2), taps a count.
    pub slope_taps_per_count: f64,
    /// b of equation (2), taps.
    pub intercept_taps: f64,
    /// V0 of equation (4).
    pub centre_counts: f64,
}

/// The X axis.
const X: PaperAxis = PaperAxis {
    drift: [13_435.7, -0.894_782, 0.375_298e-4],
    printed_linear: None,
    compensated: true,
    slope_taps_per_count: -0.031_990_6,
    intercept_taps: -0.274_587,
    centre_counts: 8203.3,
};

/// The Y axis. As printed, its reading would rise to 22 294 counts at a temperature of 10 200, beyond the converter's
/// 16 383, and against the text; with the sign turned it is 8492 and falls as X does.
const Y: PaperAxis = PaperAxis {
    drift: [12_516.1, -0.676_531, 0.276_524e-4],
    printed_linear: Some(0.676_531),
    compensated: false,
    slope_taps_per_count: -0.031_609_3,
    intercept_taps: -0.332_050,
    centre_counts: 8202.4,
};

impl PaperAxis {
    /// What the paper gives for an axis.
    pub(super) fn of(axis: Axis) -> &'static Self {
        match axis {
            Axis::X => &X,
            Axis::Y => &Y,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at([c0, c1, c2]: [f64; 3], temperature: f64) -> f64 {
        c0 + temperature * (c1 + temperature * c2)
    }

    #[test]
    fn y_as_printed_leaves_the_converters_range_and_with_the_sign_turned_it_does_not() {
        let [c0, c1, c2] = Y.drift;
        assert!(at([c0, Y.printed_linear.unwrap(), c2], 10_200.0) > 16_383.0);
        assert!((at([c0, c1, c2], 10_200.0) - 8492.4).abs() < 1.0);
    }
}
