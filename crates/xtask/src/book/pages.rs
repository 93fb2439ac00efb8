//! The pages, their commands and what these are shown to print.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

/// What stands for lines that are not shown.
const SKIPPED: &str = "...";

/// A page.
pub struct Page {
    /// Its place in the book: `first/vehicle.md`.
    pub name: String,
    text: String,
}

/// A command and the lines that it is shown to print.
#[derive(Debug, PartialEq)]
struct Shown {
    command: String,
    lines: Vec<String>,
    /// Whether it needs zerorate-lot.
    of_lot: bool,
}

impl Page {
    /// All that the summary names.
    pub fn all(book: &Path) -> Result<Vec<Self>> {
        let summary = fs::read_to_string(book.join("SUMMARY.md"))?;
        let pages = links(&summary).map(|name| {
            let text = fs::read_to_string(book.join(name)).with_context(|| format!("SUMMARY.md: {name}"))?;
            Ok(Self { name: name.to_owned(), text })
        });
        pages.collect()
    }

    /// Every link to a page leads to one.
    pub fn check_links(&self, book: &Path) -> Result<()> {
        let folder = book.join(&self.name);
        let folder = folder.parent().context("a page without a folder")?;
        for link in links(&self.text).filter(|link| !link.contains("://")) {
            let page = link.split('#').next().unwrap_or_default();
            ensure!(page.is_empty() || folder.join(page).is_file(), "{}: the link to {link} leads nowhere", self.name);
        }
        Ok(())
    }

    /// Runs its commands in a folder, with these programs first on the PATH: how many, and how many were left out.
    pub fn run(&self, folder: &Path, programs: &Path, has_lot: bool) -> Result<(usize, usize)> {
        let mut path = OsString::from(programs);
        path.push(":");
        path.push(env::var_os("PATH").unwrap_or_default());
        let (mut run, mut left_out) = (0, 0);
        for shown in shown(&self.text)? {
            if shown.of_lot && !has_lot {
                left_out += 1;
                continue;
            }
            let mut command = Command::new("sh");
            command.arg("-c").arg(format!("{} 2>&1", shown.command)).current_dir(folder).env("PATH", &path);
            let output = command.output()?;
            let printed = String::from_utf8_lossy(&output.stdout);
            ensure!(
                output.status.success(),
                "{}: `{}` ended with {}:\n{printed}",
                self.name,
                shown.command,
                output.status
            );
            if let Err(line) = compared(&shown.lines, &printed) {
                bail!("{}: `{}` does not print `{line}` where it is shown, but:\n{printed}", self.name, shown.command);
            }
            run += 1;
        }
        Ok((run, left_out))
    }
}

/// Where the links of a text lead.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split_once(')').map(|(link, _)| link))
}

/// The commands of a page, in their order: the lines of its `console` blocks that begin with a dollar.
fn shown(text: &str) -> Result<Vec<Shown>> {
    let mut found: Vec<Shown> = Vec::new();
    let mut block: Option<&str> = None;
    for line in text.lines() {
        match (block, line.strip_prefix("```")) {
            (None, Some(kind)) => block = Some(kind.trim()),
            (Some(_), Some(_)) => block = None,
            (Some(kind), None) if kind.split_whitespace().next() == Some("console") => match line.strip_prefix("$ ") {
                Some(command) => {
                    let of_lot = kind.ends_with("lot");
                    found.push(Shown { command: command.to_owned(), lines: Vec::new(), of_lot });
                }
                None => found.last_mut().context("a block begins without a command")?.lines.push(line.to_owned()),
            },
            _ => (),
        }
    }
    Ok(found)
}

/// Whether the lines are printed in their order, one after the other but where some are skipped; else the first that is not.
fn compared(lines: &[String], printed: &str) -> Result<(), String> {
    let mut printed = printed.lines().map(str::trim_end);
    let mut may_skip = false;
    for line in lines {
        if line == SKIPPED {
            may_skip = true;
        } else {
            let is_it = |printed: &str| printed == line.trim_end();
            let found = if may_skip { printed.any(is_it) } else { printed.next().is_some_and(is_it) };
            if !found {
                return Err(line.clone());
            }
            may_skip = false;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_those_of_console_blocks() {
        let text = "```console\n$ a b\none\n...\n$ c\n```\n```text\n$ no\n```\n```console lot\n$ d\n```\n";
        let shown = shown(text).unwrap();
        let commands: Vec<(&str, usize, bool)> =
            shown.iter().map(|shown| (shown.command.as_str(), shown.lines.len(), shown.of_lot)).collect();
        assert_eq!(commands, [("a b", 2, false), ("c", 0, false), ("d", 0, true)]);
    }

    #[test]
    fn what_is_shown_is_printed_in_that_order_and_skipped_lines_are_marked() {
        let compare = |lines: &[&str]| {
            compared(&lines.iter().map(|&line| line.to_owned()).collect::<Vec<_>>(), "one  \ntwo\nthree\n")
        };
        assert_eq!(compare(&["one", "two"]), Ok(()));
        assert_eq!(compare(&["one", "...", "three"]), Ok(()));
        assert_eq!(compare(&["one", "three"]), Err("three".to_owned()));
        assert_eq!(compare(&["...", "three", "two"]), Err("two".to_owned()));
    }

    #[test]
    fn links_are_found() {
        assert_eq!(links("[a](b.md) and [c](../d.md#e)").collect::<Vec<_>>(), ["b.md", "../d.md#e"]);
    }
}
