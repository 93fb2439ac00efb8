//! The page that `zerorate fit` prints.

use std::path::PathBuf;

use console::Style;
use zerorate_cal::condition::Rejected;
use zerorate_cal::log_fit::{AxisFit, LogFit};
use zerorate_cal::quality::Verdict;
use zerorate_cal::units::RateUnit;
use zerorate_fit::drift_fit::{FitStatistics, ResidualOver};
use zerorate_fit::residual::ResidualStatistics;

use super::models;
use crate::screen::{Grid, Page, RateScale, aligned, style, thousands};

/// The page: verdict, curves, what was left out, what was guessed, what to do next.
pub fn page(
    fit: &LogFit,
    over: ResidualOver,
    written: &[PathBuf],
    next: &Option<(&'static str, String)>,
    explained: bool,
) -> Page {
    let mut page = Page::default();
    verdict(&mut page, fit);
    if !fit.axes.is_empty() {
        let mut units: Vec<RateUnit> = Vec::new();
        for axis in &fit.axes {
            if !units.contains(&axis.calibration.rate_unit) {
                units.push(axis.calibration.rate_unit);
            }
        }
        units.iter().for_each(|unit| curves(&mut page, fit, *unit));
        terms(&mut page, fit, over);
        models::models(&mut page, fit);
        if explained {
            models::explain(&mut page, fit);
        }
        left_out(&mut page, fit);
    }
    rejected_axes(&mut page, fit);
    let advice = fit.judgement.advice();
    if fit.judgement.rejected() && !advice.is_empty() {
        page.heading("What to do");
        advice.iter().for_each(|sentence| page.sentence("  - ", sentence));
    }
    if !fit.notes.is_empty() {
        page.heading("What to know");
        fit.notes.iter().for_each(|note| page.sentence("  - ", note));
    }
    if !written.is_empty() {
        let written: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
        page.gap();
        page.sentence("", &format!("Wrote {}.", written.join(" and ")));
    }
    if let Some((why, command)) = next {
        page.gap();
        page.line(format!("{why}:"));
        page.line(format!("  {command}"));
    }
    page
}

/// The axes that were rejected, where others were not.
fn rejected_axes(page: &mut Page, fit: &LogFit) {
    let rejected = || fit.verdicts.iter().filter(|axis| axis.judgement.rejected());
    if fit.judgement.rejected() || rejected().next().is_none() {
        return;
    }
    page.heading("Axes rejected, and not in the calibration");
    for axis in rejected() {
        let reasons: Vec<&str> = axis.judgement.reasons.iter().map(|reason| reason.text.as_str()).collect();
        page.sentence("  - ", &format!("{}: {}", axis.name, reasons.join("; ")));
    }
}

fn verdict(page: &mut Page, fit: &LogFit) {
    let (colour, word, meaning) = match fit.judgement.verdict {
        Verdict::Good => (Style::new().green(), "good", "fitted, nothing speaks against it"),
        Verdict::Warning => (Style::new().yellow(), "warning", "fitted, with something to look at"),
        Verdict::Rejected => {
            (Style::new().red(), "rejected", "no calibration comes of this log, and nothing was written")
        }
    };
    page.sentence("", &format!("{}: {}: {meaning}", fit.source(), style(colour.bold(), word)));
    fit.judgement.reasons.iter().for_each(|reason| page.sentence("  - ", &reason.text));
}

/// One row an axis of a unit: what drifts, and what the curve leaves of it.
fn curves(page: &mut Page, fit: &LogFit, unit: RateUnit) {
    let axes: Vec<&AxisFit> = fit.axes.iter().filter(|axis| axis.calibration.rate_unit == unit).collect();
    let drifts: Vec<f64> = axes.iter().map(|axis| axis.calibration.drift().peak_to_peak()).collect();
    let scale = RateScale::of(unit, &drifts);
    page.heading(&format!("Drift over {}, in {}", temperatures(&axes), scale.unit()));
    let statistics = || axes.iter().map(|axis| &axis.calibration.fit.statistics);
    let column = |of: &dyn Fn(&FitStatistics) -> f64| {
        aligned(&statistics().map(|statistics| scale.of_rate(of(statistics))).collect::<Vec<_>>())
    };
    let held_out = |fit: &FitStatistics| fit.held_out.unwrap_or(ResidualStatistics::NONE);
    let columns = [
        aligned(&drifts.iter().map(|drift| scale.of_rate(*drift)).collect::<Vec<_>>()),
        column(&|fit| fit.in_sample.rms),
        column(&|fit| fit.in_sample.pp),
        column(&|fit| held_out(fit).rms),
        column(&|fit| held_out(fit).pp),
    ];
    let mut grid = Grid::new("lllrrrrrr");
    let what = if axes[0].calibration.sensor.is_some() { "axis" } else { "rate column" };
    grid.head(["", "", "", "drift", "in-sample", "", "held out", "", "rows"]);
    grid.head([what, "verdict", "model", "pp", "rms", "pp", "rms", "pp", "used"]);
    for (place, axis) in axes.iter().enumerate() {
        let cells = columns.iter().map(|column| column[place].clone());
        let own = &axis.calibration.fit.model;
        let beside = if own.history.is_some() || own.time_drift.is_some() { "+" } else { "" };
        let model = format!("{}{beside}", axis.calibration.model());
        let named = [axis.name.clone(), word(axis.verdict).to_owned(), model];
        grid.row(named.into_iter().chain(cells).chain([thousands(axis.calibration.fit.statistics.samples_used)]));
    }
    page.grid(&grid);
}

/// What the numbers of the tables mean.
fn terms(page: &mut Page, fit: &LogFit, over: ResidualOver) {
    let of_what = match over {
        ResidualOver::Rows => "single rows",
        ResidualOver::Groups => "averages over about 10 s",
    };
    page.gap();
    page.sentence(
        "  ",
        &format!(
            "pp is peak to peak. In-sample and held out are residual statistics of {of_what}: in-sample, of the rows that \
             the curve was fitted to; held out, by blocked cross-validation: of each of eight folds of the log, predicted \
             by a fit of the other seven. That is what to expect of new data."
        ),
    );
    if fit.axes.iter().any(|axis| axis.calibration.reference_temperature.is_some()) {
        page.sentence(
            "  ",
            "An accelerometer's drift is told from the middle of its temperature range, for at rest its constant and \
             gravity are one.",
        );
    }
}

/// A verdict in a table.
fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Good => "good",
        Verdict::Warning => "usable",
        Verdict::Rejected => "rejected",
    }
}

/// The valid range; of several, the least and the greatest.
fn temperatures(axes: &[&AxisFit]) -> String {
    let min = axes.iter().map(|axis| axis.calibration.drift().valid.min()).fold(f64::INFINITY, f64::min);
    let max = axes.iter().map(|axis| axis.calibration.drift().valid.max()).fold(f64::NEG_INFINITY, f64::max);
    format!("{min:.1} to {max:.1} {}", axes[0].temperature_unit.name())
}

fn left_out(page: &mut Page, fit: &LogFit) {
    // Of one reason each column mostly has as many rows, for a row is left out of all.
    let mut found: Vec<(Rejected, Vec<&str>)> = Vec::new();
    for axis in &fit.axes {
        for rejected in &axis.samples_rejected {
            match found.iter_mut().find(|(known, _)| known == rejected) {
                Some((_, names)) => names.push(&axis.name),
                None => found.push((*rejected, vec![&axis.name])),
            }
        }
    }
    if found.is_empty() {
        return;
    }
    page.heading("Rows left out");
    let mut grid = Grid::new("rll");
    for (Rejected { count, reason }, names) in found {
        let names = if names.len() == fit.axes.len() { "every column".to_owned() } else { names.join(", ") };
        grid.row([thousands(count), reason.words().to_owned(), names]);
    }
    page.grid(&grid);
}
