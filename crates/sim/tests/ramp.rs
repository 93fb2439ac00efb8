//! The paper's hour on the paper's board: what a fit can find, and what hysteresis there is.

// Clippy knows tests by their attribute, and `hysteresis` is their helper.
#![allow(clippy::unwrap_used)]

mod support;

use support::{Group, hour, parabola, peak_to_peak, ramp, run, running};
use zerorate_core::units::{Axis, Celsius, Seconds};
use zerorate_sim::PlantParameters;

/// Equation (1) of the paper, with the sign of Y's linear term turned (docs/paper.md).
fn equation_1(axis: Axis, t: f64) -> f64 {
    match axis {
        Axis::X => 0.375_298e-4 * t * t - 0.894_782 * t + 13_435.7,
        Axis::Y => 0.276_524e-4 * t * t - 0.676_531 * t + 12_516.1,
    }
}

fn of(axis: Axis, groups: &[[Group; 2]]) -> Vec<Group> {
    groups.iter().map(|group| group[axis.index()]).collect()
}

/// The largest absolute value.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |largest: f64, v| largest.max(v.abs()))
}

#[test]
fn a_parabola_fitted_to_one_ramp_finds_the_plant_s_drift_and_equation_1() {
    for seed in 1..=20 {
        let groups = ramp(PlantParameters::paper(), seed, -40.0, 60.0);
        for axis in Axis::BOTH {
            let groups = of(axis, &groups);
            let fit = parabola(groups.iter().map(|g| (g.temperature, g.reading)));
            let from_truth = largest(groups.iter().map(|g| fit(g.true_temperature) - g.drift));
            let from_paper = largest(groups.iter().map(|g| fit(g.temperature) - equation_1(axis, g.temperature)));
            let floor = peak_to_peak(groups.iter().map(|g| g.reading - g.drift - g.wiper));
            let drift = peak_to_peak(groups.iter().map(|g| g.reading));
            assert!(from_truth < 1.0, "seed {seed} {}: {from_truth} counts from the truth", axis.name());
            assert!(from_paper < 5.0, "seed {seed} {}: {from_paper} counts from eq. (1)", axis.name());
            assert!(floor < 5.0, "seed {seed} {}: floor {floor} counts peak to peak", axis.name());
            assert!((350.0..550.0).contains(&drift), "seed {seed} {}: {drift}", axis.name());
        }
    }
}

#[test]
fn the_paper_s_hour_covers_8500_to_11900_counts_of_temperature() {
    let groups = ramp(PlantParameters::paper(), 1, -40.0, 60.0);
    for axis in Axis::BOTH {
        let groups = of(axis, &groups);
        let (first, last) = (groups[0].temperature, groups[groups.len() - 1].temperature);
        assert!((first - 8500.0).abs() < 25.0 && (last - 11_900.0).abs() < 25.0, "{first} to {last}");
    }
}

/// Heating less cooling of the noise-free drift at equal temperature readings: cold, middle and hot, in counts.
fn hysteresis(parameters: PlantParameters, axis: Axis) -> [f64; 3] {
    let (plant, mut port, _) = running(parameters, 1);
    run(&mut port, false);
    plant.borrow_mut().chamber_set_point(Celsius(-40.0)).unwrap();
    plant.borrow_mut().wait(Seconds(3600.0));
    let heating = of(axis, &hour(&plant, &mut port, 60.0));
    let cooling = of(axis, &hour(&plant, &mut port, -40.0));
    let at = |groups: &[Group], t: f64| {
        let pair = groups.windows(2).find(|pair| (pair[0].true_temperature < t) != (pair[1].true_temperature < t));
        let [a, b] = pair.unwrap() else { unreachable!() };
        let part = (t - a.true_temperature) / (b.true_temperature - a.true_temperature);
        a.drift + part * (b.drift - a.drift)
    };
    [8900.0, 10_200.0, 11_500.0].map(|t| at(&heating, t) - at(&cooling, t))
}

#[test]
fn hysteresis_comes_from_the_die_s_lag_and_is_one_or_two_counts() {
    for axis in Axis::BOTH {
        let [cold, middle, hot] = hysteresis(PlantParameters::paper(), axis);
        // The drift falls with temperature, and the die is colder than the sensor while heating: the reading is higher.
        assert!((0.5..2.0).contains(&cold), "{} cold: {cold}", axis.name());
        assert!(cold > middle && middle > hot && hot > -1.0, "{}: {cold} {middle} {hot}", axis.name());
    }
}

#[test]
fn without_a_lag_between_package_and_die_there_is_no_hysteresis() {
    let mut parameters = PlantParameters::paper();
    for axis in &mut parameters.axes {
        axis.thermal.die_time_constant_s = 0.0;
    }
    for axis in Axis::BOTH {
        // The low-pass's 4 ms and the quantised steps of the temperature are all that is left.
        let left = largest(hysteresis(parameters.clone(), axis).into_iter());
        assert!(left < 0.05, "{}: {left} counts", axis.name());
    }
}
