//! The page that `zerorate verify` prints.

use console::Style;
use zerorate_apply::verify::{Verified, VerifiedAxis};
use zerorate_cal::log_fit::{are_alike, zero_taken_in};
use zerorate_cal::units::{RateScale, RateUnit, WrittenRate, from_to};

use crate::screen::{Grid, Page, aligned, style};

/// The page: verdict, why, what is left of each axis, and the command that fits the runs as one.
pub fn page(verified: &Verified, asked: Option<WrittenRate>, join: Option<&str>) -> Page {
    let mut page = Page::default();
    verdict(&mut page, verified);
    // Rates and accelerations are told apart: they have no scale in common.
    for rate_unit in RateUnit::each(verified.axes.iter().map(|axis| axis.rate_unit)) {
        let axes: Vec<&VerifiedAxis> = verified.axes.iter().filter(|axis| axis.rate_unit == rate_unit).collect();
        let sizes: Vec<f64> = axes.iter().map(|axis| axis.raw.pp).collect();
        let scale = RateScale::of(rate_unit, &sizes, asked);
        page.heading(&format!(
            "Over {} {}, in {}",
            from_to(
                axes.iter().map(|axis| axis.temperature[0]).fold(f64::INFINITY, f64::min),
                axes.iter().map(|axis| axis.temperature[1]).fold(f64::NEG_INFINITY, f64::max)
            ),
            verified.temperature_unit.name(),
            scale.unit()
        ));
        page.grid(&grid(&axes, scale));
    }
    if !verified.axes.is_empty() {
        page.gap();
        page.sentence("  ", &terms(verified));
    }
    if !verified.notes.is_empty() {
        page.heading("What to know");
        verified.notes.iter().for_each(|note| page.sentence("  - ", note));
    }
    if let Some(command) = join {
        page.gap();
        page.line("Runs that go other ways, over other temperatures or at other speeds, say more of a unit than one. To fit them as one:");
        page.line(format!("  {command}"));
    }
    page
}

fn verdict(page: &mut Page, verified: &Verified) {
    let (green, yellow, red) = (Style::new().green(), Style::new().yellow(), Style::new().red());
    let is_warned = !verified.reasons.is_empty();
    let worse: Vec<&str> = verified.axes.iter().filter(|axis| axis.worse).map(|axis| axis.name.as_str()).collect();
    let worse_meaning = format!("of {} more is left than without a correction; no limits were given", worse.join(", "));
    let missed = verified.axes.iter().filter(|axis| !axis.missed.is_empty()).map(|axis| axis.name.as_str());
    let missed_meaning = format!("not within the limits, or not tested: {}", missed.collect::<Vec<_>>().join(", "));
    let (colour, word, meaning) = match verified.passed {
        None if !worse.is_empty() => (yellow, "worse", worse_meaning.as_str()),
        None => (Style::new(), "measured", "no limits were given (--max-rms, --max-pp)"),
        Some(true) if is_warned => (yellow, "passed, with a warning", "all axes are within their limits, but"),
        Some(true) => (green, "passed", "all axes are within their limits"),
        Some(false) if !verified.missing.is_empty() => (red, "failed", "not all axes are there"),
        Some(false) => (red, "failed", missed_meaning.as_str()),
    };
    page.sentence("", &format!("{}: {}: {meaning}", verified.log, style(colour.bold(), word)));
    verified.missing.iter().for_each(|missing| page.sentence("  - ", missing));
    verified.axes.iter().flat_map(|axis| &axis.missed).for_each(|missed| page.sentence("  - ", missed));
    if verified.in_sample {
        page.sentence(
            "  - ",
            "this is the log that the calibration was fitted on: what is left is in-sample, and no test",
        );
    }
    // What is missing has said why.
    let is_told = |text: &str| {
        let why = text.split_once(": ").map_or(text, |(_, why)| why);
        verified.missing.iter().any(|missing| missing.ends_with(why))
    };
    let reasons = verified.reasons.iter().map(|reason| reason.text.as_str()).filter(|text| !is_told(text));
    reasons.for_each(|text| page.sentence("  - ", text));
}

fn grid(axes: &[&VerifiedAxis], scale: RateScale) -> Grid {
    let column = |of: &dyn Fn(&VerifiedAxis) -> f64| {
        aligned(&axes.iter().map(|axis| scale.of_rate(of(axis))).collect::<Vec<_>>())
    };
    let columns = [
        column(&|axis| axis.raw.rms),
        column(&|axis| axis.raw.pp),
        column(&|axis| axis.corrected.rms),
        column(&|axis| axis.corrected.pp),
        column(&|axis| axis.offset),
        aligned(&axes.iter().map(|axis| axis.raw.rms / axis.corrected.rms).collect::<Vec<_>>()),
        column(&|axis| axis.uncorrected.rms),
        column(&|axis| axis.deployed.rms),
    ];
    let told = axes.iter().any(|axis| axis.fit_told.is_some());
    let told = told.then(|| column(&|axis| axis.fit_told.map_or(f64::NAN, |told| told.rms)));
    let mut grid = Grid::new("lrrrrrrrrr");
    let told_head = if told.is_some() { "fit told" } else { "" };
    grid.head(["", "recorded", "", "corrected", "", "", "rms, times", "uncorrected", "deployed", told_head]);
    grid.head([
        "axis",
        "rms",
        "pp",
        "rms",
        "pp",
        "mean",
        "smaller",
        "rms",
        "rms",
        if told.is_some() { "rms" } else { "" },
    ]);
    for (place, axis) in axes.iter().enumerate() {
        let cells = columns.iter().chain(&told).map(|column| column[place].clone());
        grid.row([axis.name.clone()].into_iter().chain(cells));
    }
    grid
}

fn terms(verified: &Verified) -> String {
    let averages = match verified.averaged_over_s {
        Some(period) => format!("Averages over {period:.1} s."),
        None => "Averages over successive rows: the log has no times.".to_owned(),
    };
    let zero_taken_in = zero_taken_in(verified.averaged_over_s);
    let own_and_fits = verified.averaged_over_s.zip(verified.fit_averaged_over_s);
    let fit_told = match own_and_fits.filter(|&(own, fits)| !are_alike(own, fits)) {
        Some((_, fits)) => format!("fit told both of averages over {fits:.1} s, which have another noise"),
        None => "fit foretells both of a next run".to_owned(),
    };
    let told = verified.axes.iter().any(|axis| axis.fit_told.is_some());
    let told = if told { " Fit told: what the calibration's fit told of deployed, held out." } else { "" };
    format!(
        "{averages} Recorded and corrected: rms about the mean, which the start of another run sets anew; the mean that is \
         left stands under mean. Times smaller: recorded rms over corrected rms, so below 1 the correction is worse than \
         none. Uncorrected and deployed: the rate, and the rate corrected, less the mean of the run's \
         {zero_taken_in}, as a device's zero at the start takes it off, from then on; {fit_told}.{told}"
    )
}
