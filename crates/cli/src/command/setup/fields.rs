//! What each field of a set-up is, for the file that `zerorate setup` prints.

use std::collections::BTreeMap;
use std::fmt::Write;

use anyhow::{Context, Result};
use serde::Serialize;
use toml::{Table, Value};
use zerorate_bench::setup::SetUp;

/// The file's first lines.
const HEAD: &str = "The set-up of a board and its bench. A field may be left out: its value is then the one that \
                    `zerorate setup` prints. `zerorate setup --check FILE` checks a file.";

/// A section: its name, what it is, its fields, each with what it is.
type Section = (&'static str, &'static str, &'static [(&'static str, &'static str)]);

/// Every field, in the order of the file.
const SECTIONS: &[Section] = &[
    (
        "board",
        "The board: what stands on its schematic.",
        &[
            ("converter_bits", "Bits of the A/D converter. Only 14 is supported so far."),
            ("centre_counts", "The zero-rate reading aimed at, V0, counts."),
            ("middle_tap", "The tap N0 at which the drift is measured: the middle of the part's 0 to 1023."),
            ("trim_part", "The trim part. Only \"max5494\" is supported so far."),
            ("counts_per_dps", "Counts a degree per second; negative where the reading falls when the rate rises."),
            ("counts_per_celsius", "Counts a degree C of the temperature reading."),
            ("input_volts_per_count", "Volts at the rate input that move the reading by one count, without sign."),
            ("low_pass_hz", "Cut-off of the circuit's first-order low-pass, Hz."),
            ("wiper_delay_us", "Time from a set's last sample to the wiper's write, microseconds."),
        ],
    ),
    (
        "acquisition",
        "How groups are taken. Length times period is a group's time: 1.5 s, or 40 groups a minute.",
        &[
            ("group_length", "Samples averaged to a group, 1 to 512."),
            ("sample_period_us", "Time from sample to sample, microseconds."),
        ],
    ),
    (
        "chamber",
        "The chamber's profile.",
        &[
            ("cold_c", "The cold end of the ramp, degrees C."),
            ("hot_c", "The hot end of the ramp, degrees C."),
            ("room_c", "Room temperature, at which the trim is measured, degrees C."),
            ("soak_s", "How long the chamber is held before a ramp once it is at its set point, seconds."),
            ("ramp_groups", "Groups of a ramp that are used, from its beginning: 2400 are its first hour."),
            (
                "cooling_ramp",
                "Whether the full-temperature test records the way back down too: a history shows only in both directions.",
            ),
            ("soak_groups", "Groups taken at the end of a soak, before the ramp begins."),
            ("limits_c", "The least and the greatest temperature that the chamber may be sent to, degrees C."),
            ("soaks_c", "The soaks of the traditional test to compare with, degrees C."),
        ],
    ),
    (
        "trim",
        "The trim experiment, and the law that is made from it.",
        &[
            ("points", "Supply voltages, half of them to each side of the room reading."),
            ("span_counts", "How far the supply moves the reading to each side, counts."),
            ("groups_per_point", "Groups averaged at each voltage."),
            ("margin_taps", "Taps measured beyond those that the drift needs, on each side."),
            (
                "dead_band_taps",
                "Dead band of the law, taps, 0 to 0.45. Every 0.05 costs 1.6 counts of residual each way where the drift \
                 turns round; too little, and noise of the temperature switches a tap to and fro.",
            ),
        ],
    ),
    (
        "drift",
        "The drift model.",
        &[(
            "model",
            "poly:1 to poly:5, table:1 to table:32, or auto: what predicts held-out eighths, with a history where \
             chamber.cooling_ramp records both directions.",
        )],
    ),
    (
        "limits",
        "What a unit must pass, over the heating ramp.",
        &[
            ("trim_residual_pp_counts", "Residual of mode trim, counts peak to peak."),
            (
                "hybrid_residual_floors",
                "Residual of mode hybrid, in multiples of the floor (what no compensation could beat), where that is known.",
            ),
            ("mean_offset_counts", "Distance of the compensated mean from the centre, counts."),
        ],
    ),
];

/// The one section whose fields are the user's own.
const LABELS: &str = "What is to stand in every recording besides, by names of your own: station = \"oven 2\", operator = \
                      \"A. N.\"";

/// The widest line of a comment.
const WIDTH: usize = 80;

/// A set-up as a TOML file that explains itself.
pub fn commented(setup: &SetUp) -> Result<String> {
    let table = Table::try_from(setup).context("the set-up cannot be written as TOML")?;
    let mut text = comment(HEAD);
    for (section, about, fields) in SECTIONS {
        writeln!(text, "\n{}[{section}]", comment(about))?;
        for (field, about) in *fields {
            let value = value(&table, section, field)?;
            writeln!(text, "{}{field} = {value}", comment(about))?;
        }
    }
    write!(text, "\n{}{}", comment(LABELS), toml::to_string(&Labels { labels: &setup.labels })?)?;
    Ok(text)
}

/// The labels as their section of the file.
#[derive(Serialize)]
struct Labels<'a> {
    labels: &'a BTreeMap<String, String>,
}

/// A field that is not as the paper has it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// The field, as `chamber.cold_c`.
    pub field: String,
    /// Its value.
    pub here: String,
    /// The paper's.
    pub paper: String,
}

/// In what a set-up differs from the paper's.
pub fn differences(setup: &SetUp) -> Result<Vec<Difference>> {
    let (table, paper) = (Table::try_from(setup)?, Table::try_from(SetUp::paper())?);
    let mut found = Vec::new();
    for (section, _, fields) in SECTIONS {
        for (field, _) in *fields {
            let (here, paper) = (value(&table, section, field)?, value(&paper, section, field)?);
            if here != paper {
                let field = format!("{section}.{field}");
                found.push(Difference { field, here: here.to_string(), paper: paper.to_string() });
            }
        }
    }
    Ok(found)
}

fn value<'a>(table: &'a Table, section: &str, field: &str) -> Result<&'a Value> {
    let value = table.get(section).and_then(|section| section.get(field));
    value.with_context(|| format!("the set-up has no field {section}.{field}"))
}

fn comment(about: &str) -> String {
    let mut lines = String::new();
    let mut line = "#".to_owned();
    for word in about.split(' ') {
        if line.len() + 1 + word.len() > WIDTH {
            lines += &line;
            lines.push('\n');
            "#".clone_into(&mut line);
        }
        line.push(' ');
        line += word;
    }
    lines + &line + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_commented_file_reads_back_as_the_set_up() {
        let labelled = SetUp { labels: [("station".to_owned(), "oven \"2\"".to_owned())].into(), ..SetUp::paper() };
        for setup in [SetUp::paper(), SetUp::typical(), labelled] {
            let text = commented(&setup).unwrap();
            assert_eq!(SetUp::parse(&text, "printed").unwrap(), setup);
            assert!(text.lines().filter(|line| line.starts_with('#')).all(|line| line.len() <= WIDTH), "{text}");
        }
    }

    #[test]
    fn every_field_is_explained() {
        let Value::Table(table) = Value::try_from(SetUp::paper()).unwrap() else { panic!() };
        for (section, fields) in &table {
            let (_, _, explained) = SECTIONS.iter().find(|(name, ..)| name == section).unwrap();
            for (field, _) in fields.as_table().unwrap() {
                assert!(explained.iter().any(|(name, _)| name == field), "{section}.{field} is not explained");
            }
        }
    }

    #[test]
    fn a_difference_from_the_paper_is_named_with_both_values() {
        let setup = SetUp::parse("[chamber]\ncold_c = -20.0\n", "x").unwrap();
        let difference = Difference { field: "chamber.cold_c".into(), here: "-20.0".into(), paper: "-40.0".into() };
        assert_eq!(differences(&setup).unwrap(), [difference]);
    }
}
