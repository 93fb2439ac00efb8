//! The certificate as its reader gets it; its numbers are held against ones that are made here from the recordings, by another
//! way.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

#[allow(dead_code, unused_imports)] // The tests of the other pages use the rest.
mod sample;

use zerorate_board_run::folder::BoardRun;
use zerorate_cal::recording::{GroupRow, Phase};
use zerorate_core::compensate::Mode;
use zerorate_core::units::Axis;
use zerorate_report::certificate;

/// The words of the page, without its style.
fn words(run: &BoardRun) -> String {
    certificate(run).split("</style>").nth(1).unwrap().to_owned()
}

/// The texts of a table's cells, row by row, of the table whose caption has these words.
fn table(page: &str, caption: &str) -> Vec<Vec<String>> {
    let table = page.split("<figure class=\"table\">").find(|table| table.contains(caption)).unwrap();
    let body = table.split("<tbody>").nth(1).unwrap().split("</tbody>").next().unwrap();
    let plain = |cell: &str| {
        let texts = cell.split('<').map(|piece| piece.rsplit('>').next().unwrap());
        texts.collect::<String>().replace('\u{2212}', "-")
    };
    let cells = |row: &str| {
        row.split("<t").skip(1).map(|cell| plain(&format!("<t{}", cell.split("</t").next().unwrap()))).collect()
    };
    body.split("<tr>").skip(1).map(cells).collect()
}

/// A cell's number is this one, in the digits that it has.
fn is(cell: &str, number: f64) {
    let decimals = cell.split('.').nth(1).map_or(0, str::len);
    assert_eq!(cell, format!("{number:.decimals$}"));
}

/// The value at a temperature on straight lines between knots.
fn straight_between(at: &[f64], knots: &[f64], temperature: f64) -> f64 {
    let next = at.iter().position(|knot| *knot > temperature).unwrap_or(at.len() - 1).max(1);
    let share = (temperature - at[next - 1]) / (at[next] - at[next - 1]);
    knots[next - 1] + share.clamp(0.0, 1.0) * (knots[next] - knots[next - 1])
}

/// What the calibration leaves of each group of a test, by the fitted curve's own numbers as JSON has them.
fn left(run: &BoardRun, axis: Axis, test: usize, compensated: Axis, phase: Phase) -> Vec<(f64, f64)> {
    let json: serde_json::Value = serde_json::from_str(&run.calibration.to_json().unwrap()).unwrap();
    let own = &json["axes"][axis.name()];
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let drift = &own["drift"];
    let numbers = |name: &str| -> Option<Vec<f64>> { Some(drift[name].as_array()?.iter().map(number).collect()) };
    let (centre, half) = (number(&drift["temperature_centre"]), number(&drift["temperature_half_span"]));
    let polynomial = numbers("scaled_coefficients");
    let knots = numbers("knot_temperatures").zip(numbers("knots"));
    let curve = |temperature: f64| match &polynomial {
        Some(coefficients) => {
            let x = (temperature - centre) / half;
            coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
        }
        None => knots.as_ref().map_or(f64::NAN, |(at, knots)| straight_between(at, knots, temperature)),
    };
    let effects = run.calibration.axes[axis.name()].trim.as_ref().unwrap().trim.measured.clone().unwrap();
    let rows = &run.tests[test].rows;
    let groups: Vec<u32> =
        rows.iter().filter(|row| row.axis == compensated && row.mode != Mode::Off).map(|row| row.group).collect();
    let own = |row: &&GroupRow| row.axis == axis && row.phase == phase && groups.binary_search(&row.group).is_ok();
    rows.iter()
        .filter(own)
        .map(|row| {
            let (n, temperature) = (f64::from(row.sums.n), row.sums.temperature as f64);
            let effect = effects.effects()[usize::from(row.tap - effects.first().get())].0;
            (temperature / n, row.sums.zro as f64 / n - effect - curve(temperature / n))
        })
        .collect()
}

/// Means over twentieths of the range, and how many groups are in each.
// A place is one of twenty.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn means(range: [f64; 2], groups: &[(f64, f64)]) -> Vec<Option<(f64, f64)>> {
    let mut sums = vec![(0.0, 0.0); 20];
    for (temperature, counts) in groups {
        let place = ((temperature - range[0]) / (range[1] - range[0]) * 20.0).floor();
        if (0.0..20.0).contains(&place) {
            let sum = &mut sums[place as usize];
            *sum = (sum.0 + counts, sum.1 + 1.0);
        }
    }
    sums.iter().map(|(sum, n)| (*n >= 8.0).then(|| (sum / n, *n))).collect()
}

#[test]
fn every_number_of_a_budget_is_the_one_made_here_from_the_recordings() {
    let run = sample::board_run();
    let page = words(&run);
    for axis in Axis::BOTH {
        let name = axis.name().to_uppercase();
        let rows = table(&page, &format!("<b>{name}</b>: standard uncertainty"));
        let cell = |row: &str| rows.iter().find(|cells| cells[0].starts_with(row)).unwrap_or_else(|| panic!("{row}"));
        let tests = [(0, Axis::X), (0, Axis::Y), (1, Axis::X), (1, Axis::Y)];
        let ramp = |(test, compensated): (usize, Axis), phase| left(&run, axis, test, compensated, phase);
        let mut ramps: Vec<Vec<(f64, f64)>> = tests.iter().map(|test| ramp(*test, Phase::Heating)).collect();
        let cooling: Vec<Vec<(f64, f64)>> =
            [tests[0], tests[2]].iter().map(|test| ramp(*test, Phase::Cooling)).collect();
        // Noise: the tap is the same everywhere.
        let (mut squares, mut n) = (0.0, 0.0);
        for ramp in ramps.iter().chain(&cooling) {
            for i in 2..ramp.len() {
                squares += (ramp[i].1 - 2.0 * ramp[i - 1].1 + ramp[i - 2].1).powi(2) / 6.0;
                n += 1.0;
            }
        }
        let noise = squares / n;
        is(&cell("Noise")[2], noise.sqrt());
        is(&cell("Noise")[3], noise.sqrt() / 54.6);
        let fitted = run.calibration.axes[axis.name()].fit.measured;
        let range = [fitted.min(), fitted.max()];
        let of = |ramp: &Vec<(f64, f64)>| means(range, ramp);
        let average = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let heated: Vec<f64> = ramps.iter().flat_map(of).flatten().map(|(mean, n)| mean * mean - noise / n).collect();
        let repeatability = average(&heated).max(0.0);
        is(&cell("Repeatability")[2], repeatability.sqrt());
        is(&cell("Repeatability")[3], repeatability.sqrt() / 54.6);
        ramps.swap(1, 2);
        let mut apart = Vec::new();
        for (heating, cooling) in ramps.iter().zip(&cooling) {
            for (warm, cold) in of(heating).into_iter().zip(of(cooling)) {
                if let Some(((warm, n), (cold, m))) = warm.zip(cold) {
                    apart.push((cold - warm).powi(2) - noise / n - noise / m);
                }
            }
        }
        let gradient = average(&apart) / 2.0;
        is(&cell("Temperature gradient")[2], gradient.sqrt());
        let per_tap = -1.0 / run.summary.axes[axis.name()].trim_slope_taps_per_count;
        is(&cell("Tap")[2], per_tap / 12.0_f64.sqrt());
        let late = run.calibration.axes[axis.name()].trim.as_ref().unwrap().dead_band_taps * per_tap;
        assert!(late > 0.0);
        is(&cell("Dead band")[2], late);
        // The invented samples have no scatter, so a count's rounding is in no other row; nor is there a step of temperature.
        is(&cell("Count")[2], 0.288_675);
        is(&cell("Step")[2], 0.0);
        let hybrid = noise + repeatability + gradient + 1.0 / 12.0;
        let trim = hybrid + per_tap * per_tap / 12.0 + late * late;
        for (mode, square) in [("trim", trim), ("hybrid", hybrid)] {
            let combined = cell(&format!("Combined, u, mode {mode}"));
            is(&combined[2], square.sqrt());
            is(&combined[3], square.sqrt() / 54.6);
            let expanded = cell(&format!("Expanded, U, mode {mode}"));
            is(&expanded[2], 2.0 * square.sqrt());
            is(&expanded[3], 2.0 * square.sqrt() / 54.6);
        }
    }
}

#[test]
fn the_results_are_the_recordings_extremes_with_their_temperatures() {
    let run = sample::board_run();
    let rows = table(&words(&run), "Zero-rate output, peak to peak");
    assert_eq!(rows.len(), 6);
    for (name, test, mode, axis, phase) in [
        ("X trim, heating", 0, Mode::Trim, Axis::X, Phase::Heating),
        ("X hybrid, cooling", 1, Mode::Hybrid, Axis::X, Phase::Cooling),
        ("Y hybrid, heating", 1, Mode::Hybrid, Axis::Y, Phase::Heating),
    ] {
        let cells = rows.iter().find(|cells| cells[0] == name).unwrap();
        let own = run.tests[test].rows.iter().filter(|row| (row.mode, row.axis, row.phase) == (mode, axis, phase));
        let read = |row: &GroupRow| row.sums.zro as f64 / f64::from(row.sums.n);
        let pp = |of: &dyn Fn(&GroupRow) -> f64| {
            let values: Vec<f64> = own.clone().map(of).collect();
            let (least, most) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
            most - least
        };
        for (at, counts) in [(1, pp(&read)), (3, pp(&|row| row.corrected_counts))] {
            is(&cells[at], counts);
            is(&cells[at + 1], counts / 54.6);
        }
        let means: Vec<f64> = own.map(|row| row.corrected_counts).collect();
        is(&cells[5], means.iter().sum::<f64>() / means.len() as f64 - 8200.0);
        // 8500 and 11 900 counts by 34 counts a degree, and 9860 at zero.
        assert_eq!(cells[6], "-40.0 to 60.0\u{a0}°C");
    }
}

#[test]
fn a_simulated_run_is_marked_and_what_speaks_against_a_unit_stands_before_its_numbers() {
    let mut run = sample::board_run();
    run.summary.failed_checks = vec!["Cooling residual: 11.9 counts, limit at most 10 counts".into()];
    let page = certificate(&run);
    assert!(!page.contains("<script") && page.contains("@page"));
    for loader in ["http:", "https:", "src=", "@import", "url("] {
        assert!(!page.contains(loader), "{loader}");
    }
    let page = words(&run);
    let at = |words: &str| page.find(words).unwrap_or_else(|| panic!("{words}"));
    assert!(page.contains("<title>") || certificate(&run).contains("<title>Certificate of ZR-2012-0001</title>"));
    assert!(at("ZR-2012-0001") < at("SIMULATED") && at("SIMULATED") < at("Failed: Cooling residual"));
    assert!(at("Failed: Cooling residual") < at("A. N.") && at("A. N.") < at("Result</h2>"));
    assert!(page.contains("3 of 4 checks passed."));
    // A real one is not.
    (run.summary.plant, run.summary.seed) = (None, None);
    assert!(!words(&run).to_lowercase().contains("simulated"));
}

#[test]
fn instruments_are_named_by_the_labels_with_their_dates_or_are_said_not_to_be() {
    let mut run = sample::board_run();
    run.summary.plant = None;
    let page = words(&run);
    assert!(page.contains("not named in the set-up’s labels, date of calibration not given"));
    for (name, label) in [
        ("chamber", "scpi:10.0.0.9, Maker,T-40,1"),
        ("chamber_calibrated", "2026-02-01"),
        ("thermometer", "PT-100 no. 4"),
        ("thermometer_calibrated", "2026-03-01"),
        ("room", "2.17"),
    ] {
        run.calibration.labels.insert(name.into(), label.into());
    }
    let page = words(&run);
    assert!(page.contains("scpi:10.0.0.9, Maker,T-40,1, calibrated 2026-02-01"));
    assert!(page.contains("PT-100 no. 4, calibrated 2026-03-01"));
    assert!(page.contains("<dt>room</dt><dd>2.17</dd>") && !page.contains("<dt>chamber_calibrated"));
}

#[test]
fn it_says_whether_the_power_was_switched_and_for_how_long_nobody_knew_where_the_chamber_was() {
    let mut run = sample::board_run();
    assert!(words(&run).contains("changes is in it: the power was switched"));
    run.summary.plant = None;
    let page = words(&run);
    assert!(page.contains("in it where the power was switched") && !page.contains("did not say where it was"));
    run.calibration.labels.insert("power".into(), "left on through the whole run".into());
    let recordings = [&mut run.full_temperature].into_iter().chain(&mut run.tests);
    let rows = recordings.flat_map(|recording| &mut recording.rows).filter(|row| row.axis == Axis::X);
    rows.skip(7).for_each(|row| row.chamber_c = 20.0);
    let page = words(&run);
    assert!(page.contains("<dt>Power</dt><dd>left on through the whole run</dd>"));
    assert!(page.contains("<b>not in it</b>: the power was left on") && page.contains("not of the switch-on"));
    let recordings = [&run.full_temperature].into_iter().chain(&run.tests);
    let all = recordings.flat_map(|recording| &recording.rows).filter(|row| row.axis == Axis::X).count();
    assert!(page.contains(&format!("for 7 of {all} groups the chamber did not say where it was")));
}

#[test]
fn the_ramps_rate_is_the_way_over_the_time() {
    let page = words(&sample::board_run());
    // The invented die is at 102 (1 - exp(-3.2 h^1.5)) K above -40 °C after h hours: 97.8 K in the 2399 groups of 1.5 s, and
    // 2.75 K in the fastest minute, which begins after 13 minutes.
    assert!(page.contains("1.6 K/min on average, at most 2.8 K in a minute"), "{page}");
}

#[test]
fn a_run_without_tests_says_that_there_is_no_budget() {
    let mut run = sample::board_run();
    run.tests.clear();
    run.summary.tests.clear();
    let page = words(&run);
    assert!(page.contains("No test was run from which an uncertainty could be told"));
}

#[test]
fn where_no_test_cools_the_soaks_tell_the_gradient_and_without_them_it_is_said_to_be_open() {
    let mut run = sample::board_run();
    run.tests.iter_mut().for_each(|test| test.rows.retain(|row| row.phase != Phase::Cooling));
    let page = words(&run);
    assert!(page.contains("soaks less the ramp’s curve") || page.contains("soaks less the ramp's curve"));
    run.summary.soaks = None;
    let page = words(&run);
    assert!(page.contains("not measured") && page.contains("U is of a rising temperature alone"));
}
