//! What is in a recording of the bench.

use chrono::SecondsFormat;
use serde::Serialize;
use zerorate_cal::recording::{GroupRow, Recording, status};
use zerorate_cal::units::from_to;
use zerorate_report::number::counted;

use crate::screen::{Grid, Page, thousands};

#[derive(Debug, Serialize)]
pub struct Facts {
    unit_serial: String,
    procedure: String,
    firmware: String,
    seed: Option<u64>,
    started: Option<String>,
    /// Not finished: cut off, or still being written.
    cut: bool,
    whole_groups: usize,
    rows: usize,
    samples_per_group: [u32; 2],
    seconds: f64,
    chamber_c: [f64; 2],
    saturated_rows: usize,
    unbelieved_rows: usize,
    trim_failed_rows: usize,
    parts: Vec<Part>,
}

/// One axis through one phase.
#[derive(Debug, Serialize)]
struct Part {
    axis: &'static str,
    phase: String,
    mode: &'static str,
    groups: usize,
    temperature_counts: [f64; 2],
    zro_counts: [f64; 2],
    taps: [u16; 2],
}

impl Facts {
    pub fn of(recording: &Recording) -> Self {
        let rows = &recording.rows;
        let info = &recording.info;
        let times = range(rows.iter().map(|row| row.t_s));
        let flagged = |which: u16| rows.iter().filter(|row| row.status_bits & which != 0).count();
        Self {
            unit_serial: info.unit_serial.clone(),
            procedure: info.procedure.clone(),
            firmware: info.firmware.clone(),
            seed: info.seed,
            started: info.started.map(|started| started.to_rfc3339_opts(SecondsFormat::Secs, true)),
            cut: recording.cut,
            whole_groups: recording.groups(),
            rows: rows.len(),
            samples_per_group: extremes(rows.iter().map(|row| row.sums.n)),
            seconds: if rows.is_empty() { 0.0 } else { times[1] - times[0] },
            chamber_c: range(rows.iter().map(|row| row.chamber_c)),
            saturated_rows: flagged(status::SATURATED),
            unbelieved_rows: flagged(status::STUCK | status::JUMPED | status::TEMPERATURE_SATURATED),
            trim_failed_rows: flagged(status::TRIM_FAILED),
            parts: parts(rows),
        }
    }

    pub fn show(&self, file: &str, page: &mut Page) {
        let groups = thousands(self.whole_groups as u64);
        let state = if self.cut {
            format!("CUT: it was not finished (or is still being written); its {groups} whole groups are readable")
        } else {
            "finished".to_owned()
        };
        page.sentence("", &format!("{file}: a recording, {state}"));
        let [fewest, most] = self.samples_per_group;
        let samples = if fewest == most { fewest.to_string() } else { format!("{fewest} to {most}") };
        let given = |text: &str| if text.is_empty() { "not given".to_owned() } else { text.to_owned() };
        let mut facts = vec![
            ("unit", given(&self.unit_serial)),
            ("procedure", given(&self.procedure)),
            ("firmware", given(&self.firmware)),
        ];
        facts.extend(self.seed.map(|seed| ("bench", format!("simulated, seed {seed}"))));
        facts.extend(self.started.clone().map(|started| ("started", started)));
        facts.push(("groups", format!("{groups} of {samples} samples, {}", duration(self.seconds))));
        if self.chamber_c[0].is_finite() {
            facts.push(("chamber", format!("{} C", from_to(self.chamber_c[0], self.chamber_c[1]))));
        }
        if self.saturated_rows > 0 {
            facts.push(("saturated", format!("{}: the A/D was at its end", counted(self.saturated_rows, "row"))));
        }
        let mut flagged = |rows: usize, what: &'static str, why: &str| {
            if rows > 0 {
                facts.push((what, format!("{}: {why}", counted(rows, "row"))));
            }
        };
        flagged(self.unbelieved_rows, "not believed", "their temperature was stuck, jumped or at the A/D's end");
        flagged(self.trim_failed_rows, "not trimmed", "the potentiometer could not be written");
        page.facts(&facts);
        if self.parts.is_empty() {
            return;
        }
        page.gap();
        let mut grid = Grid::new("lllrrrr");
        grid.head(["", "", "", "", "temperature", "reading", ""]);
        grid.head(["axis", "phase", "mode", "groups", "counts", "counts", "taps"]);
        for part in &self.parts {
            let counts = |[min, max]: [f64; 2]| format!("{min:.0} to {max:.0}");
            let [first, last] = part.taps;
            let taps = if first == last { first.to_string() } else { format!("{first} to {last}") };
            let (temperature, reading) = (counts(part.temperature_counts), counts(part.zro_counts));
            let groups = thousands(part.groups as u64);
            grid.row([part.axis, &part.phase, part.mode, &groups, &temperature, &reading, &taps]);
        }
        page.grid(&grid);
    }
}

/// An axis's runs of one phase and mode, in the order of their first groups.
fn parts(rows: &[GroupRow]) -> Vec<Part> {
    let mut parts: Vec<Vec<&GroupRow>> = Vec::new();
    for row in rows {
        let alike = |part: &Vec<&GroupRow>| {
            let other = part[0];
            (other.axis, other.phase, other.mode) == (row.axis, row.phase, row.mode)
        };
        match parts.iter_mut().find(|part| alike(part)) {
            Some(part) => part.push(row),
            None => parts.push(vec![row]),
        }
    }
    parts
        .iter()
        .map(|rows| Part {
            axis: rows[0].axis.name(),
            phase: rows[0].phase.name().to_owned(),
            mode: rows[0].mode.name(),
            groups: rows.len(),
            temperature_counts: range(rows.iter().map(|row| row.sums.mean_temperature().0)),
            zro_counts: range(rows.iter().map(|row| row.sums.mean_zro().0)),
            taps: extremes(rows.iter().map(|row| row.tap)),
        })
        .collect()
}

/// The least and the greatest number; NaN where there is none.
pub(super) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::NAN; 2], |[min, max], value| [min.min(value), max.max(value)])
}

fn extremes<T: Ord + Copy + Default>(values: impl Iterator<Item = T> + Clone) -> [T; 2] {
    [values.clone().min().unwrap_or_default(), values.max().unwrap_or_default()]
}

/// A duration in the unit that suits it.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.1} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
