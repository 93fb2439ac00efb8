//! The report of a lot as a page.

mod charts;
mod lists;
mod outside;

use maud::{Markup, html};

use super::lot::{LotReport, Quantity};
use super::number::{counted, exact, fixed, significant, whole};
use super::page::{self, Chapter, Table, told};
use super::{figure, log_page};

fn title(source: &str) -> String {
    format!("Lot {source}")
}

impl LotReport {
    /// The report as one self-contained HTML file. Equal reports make equal bytes.
    #[must_use]
    pub fn to_html(&self) -> String {
        let distribution = charts::distribution(self, 1);
        let drawn = usize::from(distribution.is_some());
        let time = charts::over_time(self, drawn + 1);
        let drawn = drawn + usize::from(time.is_some());
        let outside = outside::rows(self);
        let mut chapters: Vec<Chapter> = vec![
            ("yield", "Yield", self.yields()),
            ("distribution", "Distribution over the lot", self.drawn(distribution)),
            ("time", "The process over time", self.drawn(time)),
        ];
        if !self.worst.is_empty() || !self.undrawn.is_empty() {
            chapters.push(("worst", "The worst units", self.worst_units(drawn)));
        }
        if !outside.is_empty() {
            chapters.push(("outside", "Outside the limits", outside::table(&outside)));
        }
        if self.rejected() > 0 {
            chapters.push(("rejected", "Rejected", lists::rejected(self)));
        }
        if self.units.iter().any(|unit| !unit.warned.is_empty()) {
            chapters.push(("warnings", "Warnings", lists::warnings(self)));
        }
        if !self.skipped().is_empty() {
            chapters.push(("skipped", "Skipped files", lists::skipped(self)));
        }
        chapters.push(("reading", "How to read the numbers", definitions()));
        page::page(&title(&self.source), &self.headline(), &chapters)
    }

    /// Whether a page is the report of a source's rows.
    #[must_use]
    pub fn is_page_of(page: &str, source: &str) -> bool {
        page.contains(&html! { title { (title(source)) } }.into_string())
    }

    fn headline(&self) -> Markup {
        let (passed, rejected) = (self.passed(), self.rejected());
        html! {
            h1 { "Lot of " (counted(self.units.len(), "unit")) }
            p.lead {
                (self.share(passed)) @if passed == 1 { " passes, " } @else { " pass, " }
                (whole(rejected as u64)) @if rejected == 1 { " was" } @else { " were" } " rejected"
                @if self.outside() > 0 { ", " (whole(self.outside() as u64)) @if self.outside() == 1 { " is" } @else { " are" } " outside the limits" }
                @if self.warned() > 0 { ", " (whole(self.warned() as u64)) @if self.warned() == 1 { " has" } @else { " have" } " warnings" }
                ". Model: " (self.model) "."
            }
            p { "From " code { (self.source) } ". " (lists::beside(self)) }
        }
    }

    fn share(&self, units: usize) -> String {
        let part = 100.0 * units as f64 / self.units.len().max(1) as f64;
        format!("{} ({} %)", whole(units as u64), fixed(part, 1))
    }

    /// A figure, or why there is none.
    fn drawn(&self, figure: Option<figure::Figure>) -> Markup {
        let sound = charts::sound(self).count();
        match figure {
            Some(figure) => figure.markup(),
            None if sound == 0 => html! { p { "No unit was fitted and not rejected: there is nothing to draw." } },
            None => html! {
                p { "Of " (counted(sound, "unit")) " fitted and not rejected no two have times that differ: there is nothing to draw." }
            },
        }
    }

    fn yields(&self) -> Markup {
        let fitted = self.units.iter().filter(|unit| unit.rejected.is_empty()).count();
        let bound = |value: f64| {
            if value.is_finite() {
                html! { (exact(value)) }
            } else {
                html! { "none" }
            }
        };
        let mut rows = vec![vec![html! { "not rejected" }, html! {}, html! {}, html! { (self.share(fitted)) }]];
        for limit in &self.limits {
            let kept = self.units.iter().filter(|unit| unit.rejected.is_empty() && limit.kept_by(unit)).count();
            rows.push(vec![
                html! { span.wraps { (limit.quantity.words()) } },
                bound(limit.min),
                bound(limit.max),
                html! { (self.share(kept)) },
            ]);
        }
        rows.push(vec![
            html! { b { "all of these" } },
            html! {},
            html! {},
            html! { b { (self.share(self.passed())) } },
        ]);
        let caption = if self.limits.is_empty() {
            html! { "Units that pass. No limits were given: " code { "limits" } " names a file of them." }
        } else {
            html! { "Units that pass, both axes within the limit, in counts." }
        };
        Table { caption, heads: &["Limit", "Least", "Greatest", "Units"], rows, numbers_from: 1 }.markup()
    }

    fn worst_units(&self, drawn: usize) -> Markup {
        html! {
            @if !self.worst.is_empty() { p {
                "The units that were fitted and not rejected whose held-out residual is largest, each drawn by its worse axis."
            } }
            @for (place, unit) in self.worst.iter().enumerate() {
                @if let Some(axis) = unit.fit.axes.iter().find(|axis| axis.name == unit.axis) {
                    h3 { (place + 1) ". " (unit.serial) ", axis " (unit.axis) ": " (significant(unit.held_out_rms, 3)) " counts rms held out" }
                    (log_page::axis::figure(&unit.fit, axis, None, place + drawn).markup())
                }
            }
            @for sentence in self.undrawn_notes() { p { (told(&sentence)) } }
        }
    }
}

fn definitions() -> Markup {
    page::facts(&[
        (
            Quantity::Drift.words(),
            html! { "The distance between the fitted curve's extremes over the unit's valid range." },
        ),
        (Quantity::Reading.words(), html! { "The fitted curve in the middle of that range." }),
        (Quantity::InSample.words(), html! { "What the curve leaves of the groups that it was fitted to." }),
        (
            Quantity::HeldOut.words(),
            html! { "Blocked cross-validation: what is left of each of eight folds of the ramp, predicted by a fit of the other seven. It tells how far to trust the curve." },
        ),
        ("rejected", html! { "A unit whose recording speaks against it: no calibration comes of it." }),
        ("warning", html! { "Something to look at, which by itself rejects no unit." }),
        ("skipped", html! { "A file that is no recording of a ramp, or cannot be read: it is none of the units." }),
    ])
}
