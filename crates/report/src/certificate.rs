//! The certificate of a board's run: one sheet to lay beside the unit, made from the files that the run left.

mod budget;
mod facts;
mod results;

use maud::{Markup, html};
use zerorate_board_run::folder::BoardRun;
use zerorate_board_run::summary::Summary;
use zerorate_board_run::uncertainty::budgets;
use zerorate_cal::calibration::Origin;

use crate::number::{counted, significant};
use crate::page;

/// What makes one sheet of it.
const STYLE: &str = include_str!("certificate/certificate.css");

/// More sentences than these would push the results off the sheet; the report has all of them.
const MOST_SENTENCES: usize = 3;

/// The certificate of a board's run as one self-contained HTML file, which prints on one sheet of A4. Equal files make equal
/// bytes.
#[must_use]
pub fn certificate(run: &BoardRun) -> String {
    let summary = &run.summary;
    let body = html! {
        header {
            p.over { "Certificate of calibration: zero-rate output of a gyroscope board over temperature" }
            h1 { "Unit " (summary.serial) }
            (simulated(summary))
            (against(summary))
        }
        main {
            (facts::section(run))
            (results::section(run))
            (budget::section(run, &budgets(run)))
            (sources(run))
        }
    };
    page::document(&format!("Certificate of {}", summary.serial), STYLE, &body)
}

/// Who holds the sheet must see at once that there was no board.
fn simulated(summary: &Summary) -> Markup {
    html! {
        @if let Some(plant) = &summary.plant {
            p.simulated {
                b { "SIMULATED" } ": no board was measured. Plant " (plant)
                @if let Some(seed) = summary.seed { ", seed " (seed) }
                "."
            }
        }
    }
}

/// The verdict, and what speaks against the unit before every number that speaks for it.
fn against(summary: &Summary) -> Markup {
    let failed: Vec<&str> = summary.failed_checks.iter().map(String::as_str).collect();
    let warnings: Vec<&str> = summary.warnings.iter().map(String::as_str).collect();
    html! {
        p.verdict-line {
            (page::verdict(summary.verdict)) ": "
            @if summary.checks.is_empty() { "nothing was checked against a limit." }
            @else { (summary.checks.len() - failed.len()) " of " (counted(summary.checks.len(), "check")) " passed." }
        }
        (sentences("Failed", &failed))
        (sentences("Warnings", &warnings))
    }
}

fn sentences(heading: &str, all: &[&str]) -> Markup {
    html! {
        @if !all.is_empty() {
            ul.reasons aria-label=(heading) {
                @for sentence in all.iter().take(MOST_SENTENCES) { li { (heading) ": " (sentence) } }
                @if all.len() > MOST_SENTENCES {
                    li { (heading) ": " (all.len() - MOST_SENTENCES) " more, which are in the run’s report" }
                }
            }
        }
    }
}

/// Counts as a rate, deg/s.
fn dps(summary: &Summary, counts: f64) -> Markup {
    significant(counts / summary.counts_per_dps.abs(), 3)
}

/// By which the sheet is told from that of another run.
fn sources(run: &BoardRun) -> Markup {
    html! {
        footer {
            p { "Made by " (run.calibration.created_by) " of these recordings:" }
            ul { @for Origin { file, sha256, .. } in &run.summary.recordings {
                li { "of " (file) ", SHA-256 " code { (sha256) } }
            } }
        }
    }
}
