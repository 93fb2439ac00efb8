//! `zerorate export`.

use std::io::{self, IsTerminal};
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;
use zerorate_cal::calibration::Calibration;
use zerorate_cal::units::from_to;
use zerorate_export::{ExportOptions, Exported, ExportedAxis, ExportedSensor, Format, export};

use super::Outcome;
use crate::screen::{Grid, Page, aligned};
use crate::{output, screen};

/// Write a calibration as an autopilot's parameters, as source code or as a table
///
/// px4, ardupilot, methodic-configurator and json hold a cubic of temperature and no more: they get the best one there is,
/// in the autopilot's own units, names and range, and what it costs against the chosen model is told here and in the file.
/// c is self-contained and holds the model itself, in floating point and in integers. csv is the curve as a table.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Export {
    /// The calibration that `zerorate fit --out` wrote
    calibration: PathBuf,

    /// px4, ardupilot, methodic-configurator, c, json or csv
    #[arg(long, value_name = "FORMAT")]
    format: Format,

    /// Write here; without this the text goes to standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// The sensor's device id, for px4 where the log did not tell it (in PX4's console: listener sensor_gyro)
    #[arg(long, value_name = "NUMBER")]
    device_id: Option<u32>,

    /// Which of the autopilot's sensors it is, from 0, where the log did not tell it
    #[arg(long, value_name = "NUMBER")]
    instance: Option<u8>,

    #[command(flatten)]
    force: output::Force,

    /// Print JSON about what was written on standard output, and nothing else there; needs --out
    #[arg(long, requires = "out")]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  zerorate export calibration.json --format px4 --out vehicle.params
  zerorate export calibration.json --format ardupilot --out tcal.parm
  zerorate export calibration.json --format c --out zerorate_calibration.h
  zerorate export calibration.json --format csv | head

After loading parameters, see on a second run what they leave: zerorate verify LOG --with calibration.json";

/// What was done, as JSON has it.
#[derive(Serialize)]
struct Done<'a> {
    schema: u32,
    out: &'a Option<PathBuf>,
    format: String,
    sensors: &'a [ExportedSensor],
    notes: &'a [String],
}

impl Export {
    pub fn run(&self) -> Result<Outcome> {
        if let Some(out) = &self.out {
            output::check("--out", out, &[&self.calibration])?;
        }
        let calibration = Calibration::read(&(&self.calibration).into())?;
        let options = ExportOptions { device_id: self.device_id, instance: self.instance };
        let exported =
            export(&calibration, self.format, &options).with_context(|| format!("{}", self.calibration.display()))?;
        let Some(out) = &self.out else {
            // The text is all that standard output holds, so that it can be piped. Who reads it has read the notes in it.
            let is_read = |note: &&String| io::stdout().is_terminal() && exported.text.contains(note.as_str());
            exported.notes.iter().filter(|note| !is_read(note)).for_each(|note| screen::note(note));
            screen::print(&exported.text)?;
            return Ok(Outcome::Done);
        };
        // A table has no place for a word about where it came from.
        let nameless = Some(exported.text.as_str()).filter(|text| !text.contains("zerorate"));
        self.force.text("--out", out, &calibration.sources, nameless)?;
        output::write(out, &exported.text)?;
        if self.json {
            let Exported { sensors, notes, .. } = &exported;
            let format = self.format.to_string();
            screen::print_json(&Done { schema: 1, out: &self.out, format, sensors, notes })?;
        } else {
            self.page(&exported).print()?;
        }
        Ok(Outcome::Done)
    }

    fn page(&self, exported: &Exported) -> Page {
        let mut page = Page::default();
        let out = self.out.iter().map(|out| out.display().to_string()).collect::<String>();
        page.sentence("", &format!("Wrote {out}, for {}.", self.format));
        for sensor in &exported.sensors {
            page.heading(&format!(
                "{sensor}, {} C: what a cubic leaves of {}, {} rms",
                from_to(sensor.range[0], sensor.range[1]),
                of_what(sensor),
                sensor.told.unit()
            ));
            page.grid(&losses(sensor));
        }
        if !exported.sensors.is_empty() {
            page.gap();
            page.sentence(
                "  ",
                "away is how far the cubic is from the chosen model's curve at most. What an autopilot cannot hold is lost; \
                 c holds the whole curve and its history. Where the two ways of a log differ, the same run again leaves less by a \
                 cubic than is told here: of an eighth that is left out its own way is missing from the other seven.",
            );
        }
        for sensor in &exported.sensors {
            let why = |axis: &ExportedAxis| Some(format!("{}: {}.", axis.name, axis.why_it_was_chosen(sensor.told)?));
            sensor.axes.iter().flatten().filter_map(why).for_each(|why| page.sentence("  - ", &why));
        }
        // The losses stand in the table.
        let is_loss = |note: &&String| exported.sensors.iter().any(|sensor| note.starts_with(&sensor.to_string()));
        let notes: Vec<&String> = exported.notes.iter().filter(|note| !is_loss(note)).collect();
        if !notes.is_empty() {
            // Parameters are to be set: what is then to be done stands among them.
            let are_set = matches!(self.format, Format::Px4 | Format::ArduPilot | Format::MethodicConfigurator);
            page.heading(if are_set { "What to do" } else { "What to know" });
            notes.iter().for_each(|note| page.sentence("  - ", note));
        }
        page
    }
}

/// What the losses of a sensor are of.
fn of_what(sensor: &ExportedSensor) -> &'static str {
    match sensor.axes.iter().flatten().all(|axis| axis.loss.over_whole_log) {
        true => "a whole log, held out, its zero taken at the start",
        false => "held-out eighths of the log, zeroed",
    }
}

/// A row an axis.
fn losses(sensor: &ExportedSensor) -> Grid {
    let axes: Vec<&ExportedAxis> = sensor.axes.iter().flatten().collect();
    let column = |of: &dyn Fn(&ExportedAxis) -> Option<f64>| {
        aligned(&axes.iter().map(|axis| sensor.told.of_rate(of(axis).unwrap_or(f64::NAN))).collect::<Vec<_>>())
    };
    let columns = [
        column(&|axis| axis.loss.chosen_rms),
        column(&|axis| axis.loss.cubic_rms),
        column(&|axis| Some(axis.loss.furthest)),
    ];
    let mut grid = Grid::new("llrrr");
    grid.head(["axis", "chosen", "its rms", "cubic", "away"]);
    for (place, axis) in axes.iter().enumerate() {
        let cells = columns.iter().map(|column| column[place].clone());
        grid.row([axis.name.clone(), axis.model.clone()].into_iter().chain(cells));
    }
    grid
}
