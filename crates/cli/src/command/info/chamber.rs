//! What is in a chamber's recording.

use chrono::SecondsFormat;
use serde::Serialize;
use zerorate_bench::profile::Profile;
use zerorate_cal::recording::ChamberRecording;
use zerorate_cal::units::from_to;
use zerorate_report::number::counted;

use super::recording::{duration, range};
use crate::screen::{Page, thousands};

#[derive(Debug, Serialize)]
pub struct Facts {
    started: String,
    /// Not finished: cut off, or still being written.
    cut: bool,
    moments: usize,
    seconds: f64,
    chamber_c: [f64; 2],
    /// The profile's last step that was begun; 0 where none was.
    last_step: u32,
    /// How many it has, cycles counted through.
    steps: Option<usize>,
    away: usize,
}

impl Facts {
    pub fn of(recording: &ChamberRecording) -> Self {
        let moments = &recording.moments;
        Self {
            started: recording.info.started.to_rfc3339_opts(SecondsFormat::Secs, true),
            cut: recording.cut,
            moments: moments.len(),
            seconds: moments.last().map_or(0.0, |moment| moment.t_s),
            chamber_c: range(moments.iter().map(|moment| moment.air_c)),
            last_step: moments.last().map_or(0, |moment| moment.step),
            steps: Profile::parse("", recording.info.profile.clone(), Profile::ANYWHERE)
                .ok()
                .map(|profile| profile.steps.len()),
            away: moments.iter().filter(|moment| moment.air_c.is_nan()).count(),
        }
    }

    pub fn show(&self, file: &str, page: &mut Page) {
        let was_stopped = self.steps.is_some_and(|steps| (self.last_step as usize) < steps);
        let state = match (self.cut, was_stopped) {
            (true, _) => "CUT: it was not finished, or is still being written",
            (false, true) => "whole, of a profile that was stopped",
            (false, false) => "whole",
        };
        let of_all = self.steps.map_or_else(String::new, |steps| format!(" of {steps}"));
        page.sentence("", &format!("{file}: a chamber's recording, {state}"));
        let mut facts = vec![
            ("started", self.started.clone()),
            ("moments", format!("{}, {}", thousands(self.moments as u64), duration(self.seconds))),
            ("last step", format!("{}{of_all}", self.last_step)),
        ];
        if self.chamber_c[0].is_finite() {
            facts.push(("chamber", format!("{} C", from_to(self.chamber_c[0], self.chamber_c[1]))));
        }
        if self.away > 0 {
            facts.push(("away", format!("{} without an answer", counted(self.away, "moment"))));
        }
        page.facts(&facts);
        page.gap();
        page.sentence(
            "",
            &format!("zerorate fit LOG --chamber {file} shows it beside the log of a board that lay in it."),
        );
    }
}
