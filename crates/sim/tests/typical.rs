//! Drawn units: what they do over the paper's hour.

mod support;

use support::{peak_to_peak, ramp};
use zerorate_core::units::Axis;
use zerorate_sim::PlantParameters;

#[test]
fn a_drawn_unit_drifts_as_it_says_and_is_as_quiet_as_the_paper_s() {
    for seed in 1..=20 {
        let groups = ramp(PlantParameters::typical(seed), seed, -40.0, 60.0);
        for axis in Axis::BOTH {
            let of = || groups.iter().map(|group| group[axis.index()]);
            let floor = peak_to_peak(of().map(|g| g.reading - g.drift - g.wiper));
            let temperature = of().map(|g| (g.temperature - g.true_temperature).abs()).fold(0.0, f64::max);
            let drift = peak_to_peak(of().map(|g| g.drift));
            assert!(floor < 6.0, "seed {seed} {}: {floor} counts peak to peak", axis.name());
            assert!(temperature < 0.8, "seed {seed} {}: {temperature} counts", axis.name());
            assert!((5.0..2100.0).contains(&drift), "seed {seed} {}: {drift} counts", axis.name());
        }
    }
}
