//! Who, when, with what: the facts of a certificate.

use maud::{Markup, html};
use zerorate_board_run::folder::{BoardRun, POWER};
use zerorate_cal::recording::{CALIBRATED, GroupRow, Phase};
use zerorate_core::units::Axis;

use crate::number::{fixed, significant};
use crate::page;

/// The labels by which a bench names its instruments.
const INSTRUMENTS: [&str; 2] = ["chamber", "supply"];

/// Seconds in a minute.
const MINUTE_S: f64 = 60.0;

pub(super) fn section(run: &BoardRun) -> Markup {
    let labels = &run.calibration.labels;
    let recorded = &run.full_temperature.info;
    let started = recorded.started.map(|started| started.format("%Y-%m-%d %H:%M UTC").to_string());
    let mut facts: Vec<(&str, Markup)> = vec![(
        "Measured",
        html! { @match (started, &run.summary.plant) {
            (Some(started), _) => (started),
            (None, Some(_)) => "simulated: the same whenever it is made",
            (None, None) => "date not recorded",
        } },
    )];
    for name in ["operator", "station"] {
        let label = labels.get(name).map_or("not given in the set-up’s labels", String::as_str);
        facts.push((if name == "operator" { "Operator" } else { "Station" }, html! { (label) }));
    }
    facts.extend(instruments(run));
    facts.push(("Board", board(run)));
    facts.push(("Ramp", ramp(run)));
    facts.extend(labels.get(POWER).map(|power| ("Power", html! { (power) })));
    let told = |name: &str| {
        ["operator", "station", POWER].contains(&name) || is_instrument(run, name) || instrument_of(name).is_some()
    };
    let others = labels.iter().filter(|(name, _)| !told(name));
    facts.extend(others.map(|(name, label)| (name.as_str(), html! { (label) })));
    page::facts(&facts)
}

/// The instrument whose calibration a label tells.
fn instrument_of(label: &str) -> Option<&str> {
    label.strip_suffix(CALIBRATED).filter(|instrument| !instrument.is_empty())
}

fn is_instrument(run: &BoardRun, name: &str) -> bool {
    INSTRUMENTS.contains(&name) || run.calibration.labels.contains_key(&format!("{name}{CALIBRATED}"))
}

/// Chamber and supply, and whatever else the labels call calibrated.
fn instruments(run: &BoardRun) -> Vec<(&str, Markup)> {
    let labels = &run.calibration.labels;
    let mut names: Vec<&str> = INSTRUMENTS.to_vec();
    names.extend(labels.keys().filter_map(|name| instrument_of(name)).filter(|name| !INSTRUMENTS.contains(name)));
    let simulated = run.summary.plant.is_some();
    let told = |name: &str| {
        html! {
            @match labels.get(name) {
                Some(label) => (label),
                None if simulated => "simulated",
                None => "not named in the set-up’s labels",
            }
            @match labels.get(&format!("{name}{CALIBRATED}")) {
                Some(date) => { ", calibrated " (date) },
                None if simulated => {},
                None => ", date of calibration not given",
            }
        }
    };
    let shown = |name| match name {
        "chamber" => "Chamber",
        "supply" => "Supply and voltmeter",
        name => name,
    };
    names.into_iter().map(|name| (shown(name), told(name))).collect()
}

fn number(run: &BoardRun, table: &str, field: &str) -> Option<f64> {
    run.calibration.setup.as_ref()?.get(table)?.get(field)?.as_f64()
}

fn board(run: &BoardRun) -> Markup {
    let summary = &run.summary;
    html! {
        (summary.trim_part.to_uppercase())
        @if let Some(bits) = number(run, "board", "converter_bits") { ", " (fixed(bits, 0)) " bits" }
        ", " (significant(summary.counts_per_dps, 4)) " counts per deg/s"
        @let firmware = &run.full_temperature.info.firmware;
        @if !firmware.is_empty() { ", firmware " (firmware) }
    }
}

/// The profile as it was asked for, and the rate that the unit's own thermometer shows of it.
fn ramp(run: &BoardRun) -> Markup {
    let ends = number(run, "chamber", "cold_c").zip(number(run, "chamber", "hot_c"));
    html! {
        @if let Some((cold, hot)) = ends { (shortest(cold)) " to " (shortest(hot)) "\u{a0}°C" }
        @if let Some(soak) = number(run, "chamber", "soak_s") { ", after " (shortest(soak / MINUTE_S)) " min of soak" }
        @if let Some([mean, fastest]) = rates(run) {
            "; by the unit’s own reading " (fixed(mean, 1)) " K/min on average, at most " (fixed(fastest, 1)) " K in a minute"
        }
        @if let Some((away, all)) = away(run) { "; for " (away) " of " (all) " groups the chamber did not say where it was" }
    }
}

/// How many groups of all recordings have no temperature of the chamber, of how many, where it told others.
fn away(run: &BoardRun) -> Option<(usize, usize)> {
    let recordings = [&run.full_temperature].into_iter().chain(&run.tests);
    let rows = || recordings.clone().flat_map(|recording| &recording.rows).filter(|row| row.axis == Axis::X);
    let (away, all) = (rows().filter(|row| row.chamber_c.is_nan()).count(), rows().count());
    (0 < away && away < all).then_some((away, all))
}

/// A set-up's number to a tenth, without one that is none.
fn shortest(number: f64) -> String {
    fixed(number, usize::from((number - number.round()).abs() >= 0.05))
}

/// Kelvins a minute of the heating ramp: on average, and most in any minute.
fn rates(run: &BoardRun) -> Option<[f64; 2]> {
    let scale = run.calibration.celsius_scale()?.counts_per_celsius;
    let is_of_it = |row: &&GroupRow| row.axis == Axis::X && row.phase == Phase::Heating && row.sums.n > 0;
    let rows = run.full_temperature.rows.iter().filter(is_of_it);
    let rows: Vec<(f64, f64)> = rows.map(|row| (row.t_s, row.sums.mean_temperature().0 / scale)).collect();
    let ((began, from), (ended, to)) = (*rows.first()?, *rows.last()?);
    let mean = (to - from) / ((ended - began) / MINUTE_S);
    let mut fastest = f64::NEG_INFINITY;
    let mut later = 0;
    for (time_s, temperature) in &rows {
        while rows.get(later).is_some_and(|(then, _)| then - time_s < MINUTE_S) {
            later += 1;
        }
        let Some((then, reached)) = rows.get(later) else { break };
        fastest = fastest.max((reached - temperature) * MINUTE_S / (then - time_s));
    }
    (mean.is_finite() && fastest.is_finite()).then_some([mean, fastest])
}
