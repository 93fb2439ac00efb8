//! What was chosen, what it predicts, and what it was chosen from.

use zerorate_cal::log_fit::{AxisFit, LogFit};
use zerorate_cal::units::{RateScale, WrittenRate};
use zerorate_fit::drift_fit::{Candidate, HeldOut};

use crate::screen::{Grid, Page, aligned};

/// The model of each axis and what it predicts of data that played no part in choosing it; nothing where nothing was
/// chosen.
pub fn models(page: &mut Page, fit: &LogFit, asked: Option<WrittenRate>) {
    let axes: Vec<&AxisFit> = fit.axes.iter().filter(|axis| nested(axis).is_some()).collect();
    let Some(first) = axes.first() else { return };
    let unit = first.calibration.rate_unit;
    let scale = fit.scale(unit, asked);
    page.heading(&format!("Model, and what it leaves of an eighth of the log (rms, {})", scale.unit()));
    let mut grid = Grid::new("llrrrr");
    grid.head(["", "", "in the", "zeroed,", "zeroed,", "cubic,"]);
    grid.head(["", "model", "recording", "warm", "cold", "zeroed"]);
    let shown = axes.iter().filter(|axis| axis.calibration.rate_unit == unit);
    let rows = shown.filter_map(|axis| {
        let nested = nested(axis)?;
        let figures = [nested.in_recording, nested.deployed_warm, nested.deployed_cold, nested.cubic_deployed];
        Some(([axis.name.clone(), axis.calibration.fit.chosen_model()], figures.map(or_none)))
    });
    fill(&mut grid, rows.collect(), scale);
    page.grid(&grid);
    page.gap();
    page.sentence(
        "  ",
        &format!(
            "Each of eight folds as above. Zeroed: as a run of one fold's length, its zero taken in the \
             fold's {}; a whole log may leave more. Of these, warm: the history is known from the log's start; cold: it begins with \
             the fold.",
            fit.zero_taken_in()
        ),
    );
}

/// The candidates of every axis.
pub fn explain(page: &mut Page, fit: &LogFit, asked: Option<WrittenRate>) {
    for axis in &fit.axes {
        let candidates = &axis.calibration.fit.statistics.candidates;
        let scale = fit.scale(axis.calibration.rate_unit, asked);
        page.heading(&format!("Candidates of {} (rms, {})", axis.name, scale.unit()));
        let mut grid = Grid::new("llrrrrrr");
        grid.head(["", "", "in-", "held", "± to the", "", "cold", "hot"]);
        grid.head(["", "model", "sample", "out", "best", "zeroed", "end", "end"]);
        let mark = |candidate: &Candidate| if candidate.chosen { "*" } else { "" }.to_owned();
        let row = |candidate: &Candidate| ([mark(candidate), candidate.model.clone()], cells(candidate));
        fill(&mut grid, candidates.iter().map(row).collect(), scale);
        page.grid(&grid);
    }
    let taken = fit.axes.iter().find_map(|axis| axis.calibration.fit.statistics.how_it_was_chosen());
    let taken = taken.map(|how| format!(" Taken (*) is {how}.")).unwrap_or_default();
    page.gap();
    page.sentence(
        "  ",
        &format!(
            "Held out: each fold of the log, predicted by a fit of the others; ± to the best: one standard error of how \
             far that is from the best one's. Zeroed: the same without drift in time, less \
             the mean of each fold's {}. Cold and hot end: the coldest and the hottest groups held out, as many as a fold.{taken}",
            fit.zero_taken_in()
        ),
    );
}

fn cells(candidate: &Candidate) -> [f64; 6] {
    let [cold, hot] = candidate.ends_rms.unwrap_or([f64::NAN; 2]);
    let Candidate { in_sample_rms, held_out_rms, held_out_excess_standard_error, deployed_rms, .. } = candidate;
    let errors = [*held_out_rms, *held_out_excess_standard_error, *deployed_rms].map(or_none);
    [*in_sample_rms, errors[0], errors[1], errors[2], cold, hot]
}

fn nested(axis: &AxisFit) -> Option<HeldOut> {
    axis.calibration.fit.statistics.nested
}

fn or_none(figure: Option<f64>) -> f64 {
    figure.unwrap_or(f64::NAN)
}

/// Rows of words and figures; all figures have as many decimals, for they are compared with each other.
fn fill<const N: usize>(grid: &mut Grid, rows: Vec<([String; 2], [f64; N])>, scale: RateScale) {
    let figures: Vec<f64> = rows.iter().flat_map(|(_, figures)| figures).map(|figure| scale.of_rate(*figure)).collect();
    let mut told = aligned(&figures).into_iter();
    for (words, _) in rows {
        grid.row(words.into_iter().chain(told.by_ref().take(N)));
    }
}
