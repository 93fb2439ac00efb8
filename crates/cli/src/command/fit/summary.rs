//! The page that `zerorate fit` prints.

use std::path::PathBuf;

use console::Style;
use zerorate_cal::condition::Rejected;
use zerorate_cal::in_chamber::InChamber;
use zerorate_cal::log_fit::{AxisFit, LogFit};
use zerorate_cal::quality::Verdict;
use zerorate_cal::units::{RateScale, RateUnit, WrittenRate};
use zerorate_fit::drift_fit::{
    A_FOLD_MISSES_ITS_BRANCH, A_HISTORY_GOES_BY_AVERAGES, FitStatistics, LogLeft, ResidualOver,
};
use zerorate_fit::residual::ResidualStatistics;
use zerorate_report::{advice, believed_temperatures, by_log_sentence, measured_temperatures, trend_sentences};

use super::{beside, models};
use crate::screen::{Grid, Page, aligned, style, thousands};

/// What is to be told of a fit.
pub struct About<'a> {
    /// The unit in which rates are to be told, if one was asked for.
    pub asked: Option<WrittenRate>,
    /// What the residuals are of.
    pub over: ResidualOver,
    /// Whether every model is to be told.
    pub explained: bool,
    /// What stood about the log.
    pub chamber: Option<&'a InChamber>,
}

/// The page: verdict, curves, what was left out, what was guessed, what to do next.
pub fn page(fit: &LogFit, about: &About, written: &[PathBuf], next: &Option<(&'static str, String)>) -> Page {
    let &About { asked, over, explained, chamber } = about;
    let mut page = Page::default();
    verdict(&mut page, fit);
    rejected_axes(&mut page, fit);
    if !fit.axes.is_empty() {
        let units = RateUnit::each(fit.axes.iter().map(|axis| axis.calibration.rate_unit));
        units.iter().for_each(|unit| curves(&mut page, fit, fit.scale(*unit, asked), *unit));
        terms(&mut page, fit);
        for trend in trend_sentences(fit, asked) {
            page.gap();
            page.sentence("  ", &trend);
        }
        units.iter().for_each(|unit| by_log(&mut page, fit, fit.scale(*unit, asked), *unit));
        units.iter().for_each(|unit| in_recording(&mut page, fit, fit.scale(*unit, asked), *unit));
        terms_in_recording(&mut page, fit, over);
        models::models(&mut page, fit, asked);
        if explained {
            models::explain(&mut page, fit, asked);
        }
        left_out(&mut page, fit);
        if let Some(chamber) = chamber {
            beside::soaks(&mut page, fit, chamber, asked);
        }
    }
    let advice = advice(&fit.judgement);
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
        page.sentence("  - ", &format!("{}: {}", axis.name, axis.why()));
    }
}

fn verdict(page: &mut Page, fit: &LogFit) {
    let (colour, meaning) = match fit.judgement.verdict {
        Verdict::Good if fit.judgement.reasons.is_empty() => {
            (Style::new().green(), "fitted, nothing speaks against it")
        }
        Verdict::Good => (Style::new().green(), "fitted; nothing speaks against it but what was assumed"),
        Verdict::Warning => (Style::new().yellow(), "fitted, with something to look at"),
        Verdict::Rejected => (Style::new().red(), "no calibration comes of this log, and nothing was written"),
    };
    let word = fit.judgement.verdict.name();
    page.sentence("", &format!("{}: {}: {meaning}", fit.source(), style(colour.bold(), word)));
    fit.judgement.reasons.iter().for_each(|reason| page.sentence("  - ", &reason.text));
}

/// One row an axis of a unit: what drifts, and what a deployed device has left of it. Of a plain fit nobody knows that: what
/// was held out stands in its place.
fn curves(page: &mut Page, fit: &LogFit, scale: RateScale, unit: RateUnit) {
    let axes: Vec<&AxisFit> = fit.axes.iter().filter(|axis| axis.calibration.rate_unit == unit).collect();
    let drifts: Vec<f64> = axes.iter().map(|axis| axis.calibration.measured_drift().peak_to_peak()).collect();
    let degree = axes[0].temperature_unit.name();
    let (measured, believed) = (measured_temperatures(&axes, degree), believed_temperatures(&axes, degree));
    page.heading(&format!("Drift over {measured}, in {}", scale.unit()));
    let (left_head, left): (_, Figure) = match deployed(&axes) {
        true => ("deployed", |fit| fit.deployed),
        false => ("held out", |fit| fit.held_out),
    };
    let [before_rms, _, before_pp] = figures(&axes, scale, |fit| fit.uncorrected);
    let [rms, error, pp] = figures(&axes, scale, left);
    let drifts = aligned(&drifts.iter().map(|drift| scale.of_rate(*drift)).collect::<Vec<_>>());
    let mut grid = Grid::new("lllrrrrrrr");
    grid.head(["", "", "", "drift", left_head, "", "", "uncorrected", "", "rows"]);
    grid.head([axis_or_column(axes[0]), "verdict", "model", "pp", "rms", "±", "pp", "rms", "pp", "used"]);
    for (place, axis) in axes.iter().enumerate() {
        let model = axis.calibration.fit.chosen_model();
        let used = thousands(axis.calibration.fit.statistics.samples_used);
        let cells = [&drifts, &rms, &error, &pp, &before_rms, &before_pp].map(|column| column[place].clone());
        grid.row([axis.name.clone(), axis.verdict.name().to_owned(), model].into_iter().chain(cells).chain([used]));
    }
    page.grid(&grid);
    if believed != measured {
        let held = format!(
            "The curves are believed a little beyond what was measured, over {believed}, and held at the ends of that."
        );
        page.sentence("  ", &held);
    }
}

/// What an axis is called: of a table it is a column.
fn axis_or_column(axis: &AxisFit) -> &'static str {
    if axis.calibration.sensor.is_some() { "axis" } else { "rate column" }
}

/// What is left of each of several logs: what the others know of it, and what it brought.
fn by_log(page: &mut Page, fit: &LogFit, scale: RateScale, unit: RateUnit) {
    let left = fit.by_log(unit);
    if left.is_empty() {
        return;
    }
    page.heading(&format!("Each log as the others predict it, rms in {}", scale.unit()));
    let column = |of: &dyn Fn(&LogLeft) -> f64| -> Vec<f64> {
        left.iter().map(|(_, _, left)| scale.of_rate(of(left))).collect()
    };
    let columns = [
        aligned(&column(&|left| left.uncorrected)),
        aligned(&column(&|left| left.by_the_others.unwrap_or(f64::NAN))),
        aligned(&column(&|left| left.by_all)),
        aligned(&column(&|left| left.offset.unwrap_or(f64::NAN))),
    ];
    let mut grid = Grid::new("llrrrr");
    grid.head(["", "", "", "by a fit of", "by the fit", ""]);
    grid.head(["log", axis_or_column(left[0].1), "uncorrected", "the others", "of all", "level"]);
    for (place, (log, axis, _)) in left.iter().enumerate() {
        let name = if place > 0 && left[place - 1].0.name == log.name { String::new() } else { log.name.clone() };
        grid.row([name, axis.name.clone()].into_iter().chain(columns.iter().map(|column| column[place].clone())));
    }
    page.grid(&grid);
    page.gap();
    page.sentence("  ", &by_log_sentence(fit));
}

/// What is left within the recording: smaller than what a device gets, and below it.
fn in_recording(page: &mut Page, fit: &LogFit, scale: RateScale, unit: RateUnit) {
    let axes: Vec<&AxisFit> = fit.axes.iter().filter(|axis| axis.calibration.rate_unit == unit).collect();
    page.heading(&format!("Within the recording, in {}", scale.unit()));
    let [in_sample_rms, _, in_sample_pp] = figures(&axes, scale, |fit| Some(fit.in_sample));
    let [rms, error, pp] = figures(&axes, scale, |fit| fit.held_out);
    let columns = [in_sample_rms, in_sample_pp, rms, error, pp];
    let mut grid = Grid::new("lrrrrr");
    grid.head(["", "in-sample", "", "held out", "", ""]);
    grid.head(["", "rms", "pp", "rms", "±", "pp"]);
    for (place, axis) in axes.iter().enumerate() {
        grid.row([axis.name.clone()].into_iter().chain(columns.iter().map(|column| column[place].clone())));
    }
    page.grid(&grid);
}

/// One figure of a fit.
type Figure = fn(&FitStatistics) -> Option<ResidualStatistics>;

/// The rms, its standard error and the peak to peak of a figure, an entry an axis.
fn figures(axes: &[&AxisFit], scale: RateScale, figure: Figure) -> [Vec<String>; 3] {
    let of = |axis: &&AxisFit| figure(&axis.calibration.fit.statistics).unwrap_or(ResidualStatistics::NONE);
    let error = |left: ResidualStatistics| left.rms_standard_error.unwrap_or(f64::NAN);
    let column = |part: &dyn Fn(ResidualStatistics) -> f64| -> Vec<f64> {
        axes.iter().map(|axis| scale.of_rate(part(of(axis)))).collect()
    };
    // A figure and its error have as many decimals.
    let mut rms = aligned(&[column(&|left| left.rms), column(&error)].concat());
    let told = rms.split_off(axes.len());
    let error = told.into_iter().zip(column(&error)).map(|(told, error)| told_error(told, error)).collect();
    [rms, error, aligned(&column(&|left| left.pp))]
}

/// An error as a column tells it: one that rounds to nothing is below the last decimal, and where nothing scatters there is none.
fn told_error(told: String, error: f64) -> String {
    match told.parse::<f64>() {
        Ok(shown) if shown > 0.0 || error.is_nan() => told,
        Ok(_) if error > 0.0 => match told.strip_suffix('0') {
            Some(before) if before.contains('.') => format!("<{before}1"),
            _ => format!("{error:.0e}"),
        },
        _ => "-".to_owned(),
    }
}

/// Whether it is known what a deployed device has left.
fn deployed(axes: &[&AxisFit]) -> bool {
    axes.iter().any(|axis| axis.calibration.fit.statistics.deployed.is_some())
}

/// What the numbers of the first table mean.
fn terms(page: &mut Page, fit: &LogFit) {
    page.gap();
    page.sentence(
        "  ",
        "Drift, pp: the highest less the lowest of the fitted curve over the temperatures that were measured; of a model with plays, of the cubic for autopilots.",
    );
    let axes: Vec<&AxisFit> = fit.axes.iter().collect();
    if deployed(&axes) {
        let (averaged_over, zero_taken_in) = (fit.averaged_over(), fit.zero_taken_in());
        let verified_over = fit.verified_over();
        let steps = if fit.steps.is_empty() { "" } else { " The steps told above are taken out of it." };
        page.sentence(
            "  ",
            &format!(
                "Deployed is what a device has left of a whole log like this one, in averages over {averaged_over}, if it \
                 takes its zero in the {zero_taken_in} and the prediction off from then on: each eighth of the log as a fit of the \
                 other seven predicts it, along its own curve where these lack the temperatures; which model, and how much of it is \
                 the cubic, all eight have chosen. Only the zero of a start that is colder or warmer than all of these is as the fit \
                 of all leaves it. The log's own drift in time, which no device knows, is \
                 left in it.{steps} Uncorrected is the same without a model. zerorate verify measures the same two of \
                 another run{verified_over}. \u{b1} is one standard error of the rms, by how much the eight folds differ and by \
                 the noise of the zero; pp is peak to peak."
            ),
        );
        if axes.iter().any(|axis| axis.calibration.fit.model.history.is_some()) {
            page.sentence("  ", &format!("{A_HISTORY_GOES_BY_AVERAGES}."));
        }
        if axes.iter().any(|axis| axis.calibration.fit.misses_its_own_branch()) {
            page.sentence("  ", &format!("{A_FOLD_MISSES_ITS_BRANCH}."));
        }
    }
    if fit.axes.iter().any(|axis| axis.calibration.reference_temperature.is_some()) {
        page.sentence(
            "  ",
            "An accelerometer's drift is told from the middle of its temperature range, for at rest its constant and \
             gravity are one.",
        );
    }
}

/// What the numbers within the recording mean.
fn terms_in_recording(page: &mut Page, fit: &LogFit, over: ResidualOver) {
    let of_what = match over {
        ResidualOver::Rows => "single rows".to_owned(),
        ResidualOver::Groups => format!("averages over {}", fit.averaged_over()),
    };
    let levels = if fit.sources.len() > 1 { " The levels of the logs differ, and that is in both." } else { "" };
    let believed = if fit.axes.iter().any(|axis| axis.calibration.fit.model.time_drift.is_some()) {
        " Both take the log's own drift in time off, and its history as known from the start: that shows how well the model \
         describes this log, and is no promise for the next."
    } else {
        ""
    };
    page.gap();
    page.sentence(
        "  ",
        &format!(
            "Residuals of {of_what}: in-sample, of the rows that the curve was fitted to; held out, by blocked \
             cross-validation: of each of eight folds of the log, predicted by a fit of the other seven.{levels}{believed}"
        ),
    );
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

#[cfg(test)]
mod tests {
    use super::told_error;

    #[test]
    fn an_error_that_rounds_to_nothing_is_not_told_as_none() {
        let told = |told: &str, error| told_error(told.to_owned(), error);
        assert_eq!([told("0.0120", 0.012), told("0.000", 4e-4), told("0.000", 0.0)], ["0.0120", "<0.001", "-"]);
        assert_eq!([told("0", 3e-9), told("-", f64::NAN)], ["3e-9", "-"]);
    }
}
