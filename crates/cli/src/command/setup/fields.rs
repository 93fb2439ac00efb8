//! A set-up as a file that explains itself, and what in it is not the paper's.

use anyhow::{Context, Result};
use documented::DocumentedFields;
use serde::Serialize;
use toml::{Table, Value};
use zerorate_bench::setup::{
    Acquisition, Board, ChamberProfile, ControllerTable, DriftChoice, Limits, SetUp, SupplyTable, TrimExperiment,
};

/// The file's first lines.
const HEAD: &str = "The set-up of a board and its bench. A field may be left out: its value is then the one that \
                    `zerorate setup` prints. `zerorate setup --check FILE` checks a file.";

/// The section whose fields are the user's own.
const LABELS: &str = "labels";

/// The widest line of a comment.
const WIDTH: usize = 80;

/// What a field of a section is.
fn about(section: &str, field: &str) -> &'static str {
    let docs = match section {
        "board" => Board::get_field_docs(field),
        "acquisition" => Acquisition::get_field_docs(field),
        "chamber" => ChamberProfile::get_field_docs(field),
        "chamber.controller" => ControllerTable::get_field_docs(field),
        "supply" => SupplyTable::get_field_docs(field),
        "trim" => TrimExperiment::get_field_docs(field),
        "drift" => DriftChoice::get_field_docs(field),
        "limits" => Limits::get_field_docs(field),
        _ => Ok(""),
    };
    docs.unwrap_or_default()
}

/// A set-up as a TOML file that explains itself.
pub fn commented(setup: &SetUp) -> Result<String> {
    let mut text = comment(HEAD);
    let written = toml::to_string(setup).context("the set-up cannot be written as TOML")?;
    let mut section = String::new();
    for line in written.lines() {
        if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            name.clone_into(&mut section);
            text += "\n";
            let within = name.strip_prefix("chamber.").map(|field| about("chamber", field));
            text += &comment(within.unwrap_or_else(|| SetUp::get_field_docs(name).unwrap_or_default()));
        } else if let Some((field, _)) = line.split_once(" = ").filter(|_| section != LABELS) {
            text += &comment(about(&section, field));
        }
        if !line.is_empty() {
            text += line;
            text += "\n";
        }
    }
    // A set-up without labels has no such section, and people are to know that there can be one.
    if setup.labels.is_empty() {
        text += &format!("\n{}[{LABELS}]\n", comment(SetUp::get_field_docs(LABELS).unwrap_or_default()));
    }
    Ok(text)
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

/// In what a set-up differs from the paper's. Of a section that the paper's has not, as a controller's registers, it is told
/// that it is given.
pub fn differences(setup: &SetUp) -> Result<Vec<Difference>> {
    let (table, paper) = (Table::try_from(setup)?, Table::try_from(SetUp::paper())?);
    let sections = table.iter().filter_map(|(name, value)| Some((name, value.as_table()?)));
    let difference = |field: String, here: &Value, paper: Option<&Value>| Difference {
        field,
        here: if here.is_table() { "given".to_owned() } else { here.to_string() },
        paper: paper.map_or_else(|| "none".to_owned(), Value::to_string),
    };
    let mut found = Vec::new();
    for (section, fields) in sections {
        let Some(paper) = paper.get(section) else {
            found.push(difference(section.clone(), &table[section], None));
            continue;
        };
        let differs = fields.iter().filter(|(field, here)| paper.get(field.as_str()) != Some(*here));
        found.extend(differs.map(|(field, here)| difference(format!("{section}.{field}"), here, paper.get(field))));
    }
    Ok(found)
}

fn comment(about: &str) -> String {
    let about = about.split_whitespace().collect::<Vec<_>>().join(" ");
    if about.is_empty() {
        return String::new();
    }
    let options = textwrap::Options::new(WIDTH).initial_indent("# ").subsequent_indent("# ").break_words(false);
    textwrap::fill(&about, options) + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_commented_file_reads_back_as_the_set_up() {
        let mut remote = SetUp { supply: Some(SupplyTable::default()), ..SetUp::paper() };
        remote.chamber.controller = Some(ControllerTable::of("binder"));
        let labelled = SetUp { labels: [("station".to_owned(), "oven \"2\"".to_owned())].into(), ..SetUp::paper() };
        for setup in [SetUp::paper(), SetUp::typical(), labelled, remote] {
            let text = commented(&setup).unwrap();
            assert_eq!(SetUp::parse(&text, "printed").unwrap(), setup);
            assert!(text.lines().filter(|line| line.starts_with('#')).all(|line| line.len() <= WIDTH), "{text}");
        }
    }

    #[test]
    fn every_field_is_explained() {
        let table = Table::try_from(SetUp::paper()).unwrap();
        for (section, fields) in &table {
            for field in fields.as_table().unwrap().keys() {
                assert!(!about(section, field).is_empty(), "{section}.{field} is not explained");
            }
        }
    }

    #[test]
    fn a_difference_from_the_paper_is_named_with_both_values() {
        let setup = SetUp::parse("[chamber]\ncold_c = -20.0\n", "x").unwrap();
        let difference = Difference { field: "chamber.cold_c".into(), here: "-20.0".into(), paper: "-40.0".into() };
        assert_eq!(differences(&setup).unwrap(), [difference]);
        let mut remote = SetUp { supply: Some(SupplyTable::default()), ..SetUp::paper() };
        remote.chamber.controller = Some(ControllerTable::of("binder"));
        let given = |field: &str| Difference { field: field.into(), here: "given".into(), paper: "none".into() };
        assert_eq!(differences(&remote).unwrap(), [given("chamber.controller"), given("supply")]);
    }
}
