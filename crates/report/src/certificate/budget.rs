//! The uncertainty budget of each axis.

use maud::{Markup, html};
use zerorate_board_run::folder::BoardRun;
use zerorate_board_run::uncertainty::{Budget, COVERAGE_FACTOR, Contribution, Evaluation, Part, Source};
use zerorate_core::units::Axis;

use super::dps;
use crate::number::fixed;
use crate::page::Table;
use crate::panels::name_of;

pub(super) fn section(run: &BoardRun, budgets: &[Budget]) -> Markup {
    let of = |axis: Axis| budgets.iter().filter(|budget| budget.axis == axis).collect::<Vec<_>>();
    html! {
        section {
            h2 { "Uncertainty" }
            @if budgets.is_empty() { p { "No test was run from which an uncertainty could be told." } }
            @else {
                (quantity(run))
                @for axis in Axis::BOTH { @let own = of(axis); @if !own.is_empty() { (table(run, axis, &own)) } }
                p.small {
                    "Not in the budget: ageing, sensitivity to acceleration and vibration, the supply voltage, mounting, rates of "
                    "temperature beyond the ramp’s, and the scale factor: deg/s are counts by the set-up’s."
                }
            }
        }
    }
}

/// What U is of.
fn quantity(run: &BoardRun) -> Markup {
    let centre =
        run.calibration.axes.values().find_map(|axis| axis.trim.as_ref()).map(|trim| trim.trim.line.centre().0);
    html! {
        p {
            "U is of the zero-rate output of the compensated unit less the centre"
            @if let Some(centre) = centre { " of " (fixed(centre, 0)) " counts" }
            ", the mean of one group"
            @if let Some(period) = run.calibration.group_period_s { " of " (fixed(period, 1)) " s" }
            ", at a temperature of the range, rising or falling as the ramp’s. What another switch-on changes is "
            @match run.was_switched() {
                Some(true) => "in it: the power was switched off and on before each test",
                Some(false) => { b { "not in it" } ": the power was left on through the whole run" },
                None => "in it where the power was switched between the ramps",
            }
            ". U = "
            i { "k" } " " i { "u" } " with " i { "k" } " = " (fixed(COVERAGE_FACTOR, 0)) ", by the GUM (JCGM 100:2008): about 95 %, more where the largest part has ends, as a tap’s, and less where it rests on few switch-ons. How often each holds stands beside it."
        }
    }
}

fn table(run: &BoardRun, axis: Axis, budgets: &[&Budget]) -> Markup {
    let summary = &run.summary;
    // Every mode has the rows of the others, and trim two more.
    let fullest = budgets.iter().max_by_key(|budget| budget.contributions.len());
    let mut rows: Vec<Vec<Markup>> =
        fullest.iter().flat_map(|budget| &budget.contributions).map(|row| cells(run, row)).collect();
    let total = |name: &str, budget: &Budget, counts: f64, told: Markup| {
        vec![
            html! { b { (name) ", mode " (budget.mode.name()) } },
            html! {},
            html! { b { (fixed(counts, 2)) } },
            html! { b { (dps(summary, counts)) } },
            told,
        ]
    };
    rows.extend(budgets.iter().map(|budget| total("Combined, u", budget, budget.combined_counts(), html! {})));
    rows.extend(budgets.iter().map(|budget| total("Expanded, U", budget, budget.expanded_counts(), held(budget))));
    Table {
        caption: html! { b { (name_of(axis)) } ": standard uncertainty u of each contribution (k = 1)." },
        heads: &["Contribution", "Type", "u, counts", "u, deg/s", "Source"],
        rows,
        numbers_from: 1,
    }
    .wide_markup()
}

/// How often U holds: with few switch-ons not as often as with many.
fn held(budget: &Budget) -> Markup {
    let freedom = budget.degrees_of_freedom();
    html! {
        span.source {
            "holds about " (fixed(100.0 * budget.held(), 0)) " %, with "
            // Beyond these nothing changes in the digits that are told.
            @if freedom < 1000.0 { (fixed(freedom.floor(), 0)) " effective" } @else { "many" } " degrees of freedom"
        }
    }
}

fn cells(run: &BoardRun, row: &Contribution) -> Vec<Markup> {
    let name = match row.source {
        Source::Noise => "Noise of a group’s mean",
        Source::Repeatability => "Repeatability",
        Source::Gradient => "Temperature gradient",
        Source::Tap => "Tap, mode trim alone",
        Source::DeadBand => "Dead band, mode trim alone",
        Source::Temperature => "Step of the temperature",
        Source::Converter => "Count of the A/D converter",
    };
    let evaluation = match row.evaluation {
        Evaluation::A => "A",
        Evaluation::B => "B",
    };
    let (counts, rate) = match row.part {
        Part::Known(counts) => (html! { (fixed(counts, 2)) }, dps(&run.summary, counts)),
        Part::InNoise => (html! { "in noise" }, html! { "\u{2013}" }),
        Part::NotMeasured => (html! { "not measured" }, html! { "\u{2013}" }),
    };
    vec![html! { (name) }, html! { (evaluation) }, counts, rate, html! { span.source { (row.told) } }]
}
