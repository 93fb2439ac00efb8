//! What `zerorate calibrate` says when it is done.

use std::path::Path;

use console::Style;
use zerorate_bench::board::Axis;
use zerorate_bench::setup::SetUp;
use zerorate_board_run::folder::{CALIBRATION, CERTIFICATE, REPORT};
use zerorate_board_run::summary::Summary;
use zerorate_cal::quality::Verdict;

use crate::screen::{self, Grid, Page};

/// The page: the verdict, the drift, the trim, the tests, where to look.
pub fn page(summary: &Summary, out: &Path, setup: &SetUp) -> Page {
    let mut page = Page::default();
    headline(&mut page, summary);

    page.heading("Drift (the full-temperature test; counts)");
    let mut grid = Grid::new("llrrr");
    grid.head(["axis", "model", "peak to peak", "in-sample rms", "held-out rms"]);
    for (name, axis) in &summary.axes {
        grid.row([
            name.to_uppercase(),
            axis.model.clone(),
            format!("{:.1}", axis.drift_pp_counts),
            format!("{:.2}", axis.fit_rms_counts),
            axis.held_out_rms_counts.map_or_else(|| "-".into(), |rms| format!("{rms:.2}")),
        ]);
    }
    page.grid(&grid);
    page.sentence(
        "  ",
        "held-out: each eighth of the ramp as a fit of the rest predicts it; the ends lie beyond what such a fit has seen, which a \
         second ramp does not ask for",
    );

    page.heading("Trim (the supply's voltages, then every tap)");
    let mut grid = Grid::new("lrrrr");
    grid.head(["axis", "a, taps/count", "b, taps", "counts/tap", "V0, counts"]);
    for (name, axis) in &summary.axes {
        grid.row([
            name.to_uppercase(),
            format!("{:.7}", axis.trim_slope_taps_per_count),
            format!("{:+.3}", axis.trim_intercept_taps),
            format!("{:.2}", -1.0 / axis.trim_slope_taps_per_count),
            format!("{:.1}", axis.v0_counts),
        ]);
    }
    page.grid(&grid);

    page.heading("Verification (a second ramp, held out; counts)");
    let mut grid = Grid::new("lllrrrrrr");
    grid.head(["axis", "mode", "ramp", "before", "quadratic", "after", "floor", "mean", "writes"]);
    for test in &summary.tests {
        grid.row([
            test.axis.name().to_uppercase(),
            test.mode.name().into(),
            test.direction.name().into(),
            format!("{:.1}", test.uncompensated_pp_counts),
            test.quadratic_pp_counts.map_or_else(|| "-".into(), |left| format!("{left:.1}")),
            format!("{:.1}", test.residual_pp_counts),
            test.floor_pp_counts.map_or_else(|| "-".into(), |floor| format!("{floor:.1}")),
            format!("{:.1}", test.mean_counts),
            test.wiper_writes.to_string(),
        ]);
    }
    page.grid(&grid);
    let floor = if summary.tests.iter().any(|test| test.floor_pp_counts.is_some()) {
        "the floor is what noise alone makes, and less than it is chance"
    } else {
        "no floor is known on a real bench: hybrid is held against what trim leaves"
    };
    let told = "before, quadratic, after and floor are peak to peak over the ramp's group means; before is without compensation, in the same \
                direction; quadratic is what a plain quadratic of the full-temperature test would have left, of all its ramps, taken off in numbers";
    page.sentence("  ", &format!("{told}; {floor}"));

    page.heading("Written");
    page.facts(&[
        ("report", out.join(REPORT).display().to_string()),
        ("certificate", out.join(CERTIFICATE).display().to_string()),
        ("calibration", out.join(CALIBRATION).display().to_string()),
        ("device record", out.join("device-record.bin").display().to_string()),
        ("recordings", format!("{} (Parquet)", out.display())),
    ]);
    if summary.plant.is_none() {
        page.gap();
        page.sentence("", stored(summary.verdict, setup.trim.works_alone));
    }
    page
}

/// What the board does with its calibration from now on; where it does not work `alone`, a host has it start.
const fn stored(verdict: Verdict, alone: bool) -> &'static str {
    match verdict {
        Verdict::Rejected if !alone => {
            "The unit is rejected, and yet its calibration is stored on the board, which was tested with it and waits in mode off: do not \
             have it start. `zerorate device deploy` puts another calibration in its place."
        }
        Verdict::Good | Verdict::Warning if !alone => {
            "The calibration is stored on the board, which waits in mode off (works_alone = false in the set-up): `zerorate device mode` \
             has an axis start."
        }
        Verdict::Rejected => {
            "The unit is rejected, and yet its calibration is stored on the board, which was tested with it: from its next power-up on it \
             compensates. Do not use the unit as it is; `zerorate device deploy` puts another calibration in its place."
        }
        Verdict::Good | Verdict::Warning => {
            "The calibration is stored on the board, which compensates from its next power-up on; `zerorate device mode` turns \
             an axis on before."
        }
    }
}

fn headline(page: &mut Page, summary: &Summary) {
    let colour = match summary.verdict {
        Verdict::Rejected => Style::new().red(),
        Verdict::Warning => Style::new().yellow(),
        Verdict::Good => Style::new().green(),
    };
    let verdict = screen::style(colour.bold(), summary.verdict.name());
    let plant = summary.plant.as_ref().zip(summary.seed);
    let plant = plant.map(|(plant, seed)| format!(" ({plant} plant, seed {seed})")).unwrap_or_default();
    page.line(format!("Unit {}{plant}: {verdict}", summary.serial));
    // What speaks against the unit stands before every number that speaks for it.
    summary.failed_checks.iter().for_each(|failed| page.sentence("  - ", failed));
    summary.warnings.iter().for_each(|warning| page.sentence("  - ", warning));
    let before = summary.drift_pp_counts(Axis::X);
    let mut told = format!("X drifts {before:.0} counts over the heating ramp");
    let [trim, hybrid] = summary.headline();
    if let Some(trim) = trim {
        let (left, times) = (trim.residual_pp_counts, trim.times_beside(before));
        told += &format!("; the potentiometer leaves {left:.0} ({times}, peak to peak)");
    }
    if let Some(hybrid) = hybrid {
        let (left, times) = (hybrid.residual_pp_counts, hybrid.times_beside(before));
        told += &format!("; with the rest subtracted in numbers {left:.1} ({times})");
    }
    told += ".";
    if let Some(cooling) = summary.cooling() {
        let (mode, left, times) = (cooling.mode.name(), cooling.residual_pp_counts, cooling.times_beside(before));
        told += &format!(" On the way back down mode {mode} leaves {left:.1} ({times}).");
    }
    page.sentence("", &told);
}
