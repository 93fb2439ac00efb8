//! The book's reference: the program's own help, and the forms of JSON as their schemas tell them.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::workspace::Workspace;

/// Where the schemas are.
const SCHEMAS: &str = "docs/schemas";

/// How deep a form is told: what stands deeper has a schema of its own, or is like what is told.
const DEEPEST: usize = 4;

/// The help of every command.
pub fn commands(zerorate: &Path) -> Result<String> {
    let mut page = "# Commands\n\nWhat `zerorate help` prints, command by command.\n".to_owned();
    let whole = help(zerorate, &["help"])?;
    write!(page, "\n```text\n{whole}```\n")?;
    for name in subcommands(&whole) {
        let text = help(zerorate, &["help", name])?;
        write!(page, "\n## zerorate {name}\n\n```text\n{text}```\n")?;
        for of_it in subcommands(&text) {
            let text = help(zerorate, &[name, "help", of_it])?;
            write!(page, "\n### zerorate {name} {of_it}\n\n```text\n{text}```\n")?;
        }
    }
    Ok(page)
}

fn help(zerorate: &Path, arguments: &[&str]) -> Result<String> {
    let output = Command::new(zerorate).args(arguments).output()?;
    ensure!(output.status.success(), "zerorate {}: {}", arguments.join(" "), output.status);
    let text = String::from_utf8(output.stdout)?;
    Ok(text.trim_end().to_owned() + "\n")
}

/// The commands that a help lists; help itself, and the program that stands apart, are none.
fn subcommands(help: &str) -> Vec<&str> {
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = listed.filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with(' '));
    names.filter_map(|line| line.split_whitespace().next()).filter(|name| !["help", "lot"].contains(name)).collect()
}

/// Every form, its fields in a table.
pub fn forms(workspace: &Workspace) -> Result<String> {
    let mut page = "# Forms of JSON\n\nWhat `--json` prints and what is in each file, by the schemas of `docs/schemas`. A field that may be missing is in \
        *italics*.\n"
        .to_owned();
    let common: Value = serde_json::from_str(&workspace.read(format!("{SCHEMAS}/common.json"))?)?;
    for path in workspace.files(SCHEMAS)? {
        let is_form = path.extension().is_some_and(|kind| kind == "json") && !path.ends_with("common.json");
        if !is_form {
            continue;
        }
        let named = || path.display().to_string();
        let schema: Value = serde_json::from_str(&workspace.read(&path)?).with_context(named)?;
        let title = schema["title"].as_str().with_context(named)?;
        writeln!(page, "\n## {title}\n\n{}\n", schema["description"].as_str().unwrap_or_default())?;
        let mut rows = Vec::new();
        let of = Schemas { own: &schema, common: &common };
        of.fields("", &schema, 0, &mut rows);
        if !rows.is_empty() {
            writeln!(page, "| field | what it is |\n|---|---|\n{}", rows.join("\n"))?;
        }
    }
    Ok(page)
}

/// A schema, and the one that several share.
struct Schemas<'a> {
    own: &'a Value,
    common: &'a Value,
}

impl<'a> Schemas<'a> {
    /// What a reference stands for.
    fn resolved(&self, schema: &'a Value) -> &'a Value {
        let Some(reference) = schema["$ref"].as_str() else { return schema };
        let (file, place) = reference.split_once('#').unwrap_or((reference, ""));
        let root = if file.is_empty() { self.own } else { self.common };
        self.resolved(root.pointer(place).unwrap_or(&Value::Null))
    }

    /// A row a field, and the fields below it.
    fn fields(&self, before: &str, schema: &'a Value, depth: usize, rows: &mut Vec<String>) {
        let schema = self.resolved(schema);
        if depth > DEEPEST {
            return;
        }
        let required: Vec<&str> =
            schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        for (name, field) in schema["properties"].as_object().into_iter().flatten() {
            let place = if before.is_empty() { name.clone() } else { format!("{before}.{name}") };
            let told = field["description"].as_str().or_else(|| self.resolved(field)["description"].as_str());
            let told = told.unwrap_or_default().replace('|', "\\|");
            let mark = if required.contains(&name.as_str()) { "" } else { "*" };
            rows.push(format!("| {mark}`{place}`{mark} | {told} |"));
            self.fields(&place, field, depth + 1, rows);
        }
        for (part, mark) in [("items", "[]"), ("additionalProperties", ".*")] {
            if schema[part].is_object() {
                self.fields(&format!("{before}{mark}"), &schema[part], depth + 1, rows);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn commands_are_read_from_help() {
        let help = "A tool\n\nCommands:\n  fit      Fit it:\n             all of it\n  lot      Apart\n  help     This\n\nOptions:\n  -h\n";
        assert_eq!(subcommands(help), ["fit"]);
        assert!(subcommands("no list\n").is_empty());
    }

    #[test]
    fn fields_are_told_with_what_they_refer_to() {
        let common = json!({ "$defs": { "unit": { "description": "Of rates." } } });
        let own = json!({
            "required": ["a"],
            "properties": {
                "a": { "description": "A list.", "items": { "properties": { "b": { "$ref": "common.json#/$defs/unit" } } } }
            }
        });
        let mut rows = Vec::new();
        Schemas { own: &own, common: &common }.fields("", &own, 0, &mut rows);
        assert_eq!(rows, ["| `a` | A list. |", "| *`a[].b`* | Of rates. |"]);
    }
}
