//! The rules of the house that no other tool keeps: small files, folders with names of their own, and nothing in the
//! repository that is true on one machine only.

use std::ffi::OsStr;
use std::path::Path;

use anyhow::{Result, ensure};

use crate::steps::Outcome;
use crate::workspace::Workspace;

/// A source file is one chip, one algorithm, one subcommand: about 300 lines, and never more than this.
const MOST_LINES: usize = 500;

/// Folders that say nothing of what is in them.
const NAMELESS: [&str; 2] = ["utils", "common"];

/// How a path into somebody's machine begins; in halves, for this file is read as well.
const ABSOLUTE: [&str; 3] = [concat!("/wo", "rk/"), concat!("/ho", "me/"), concat!("/Us", "ers/")];

/// Checks every file of the project.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let mut faults = Vec::new();
    let files = workspace.files(".")?;
    for path in &files {
        // A file that is not text has neither lines nor readable paths.
        let text = workspace.read(path).unwrap_or_default();
        faults.extend(faults_of(path, &text));
    }
    ensure!(faults.is_empty(), "{} faults\n    {}", faults.len(), faults.join("\n    "));
    println!("    {} files", files.len());
    Ok(Outcome::Passed)
}

fn faults_of(path: &Path, text: &str) -> Vec<String> {
    let shown = path.display();
    let mut faults = Vec::new();
    let parts: Vec<&OsStr> = path.iter().filter(|part| *part != ".").collect();
    if let Some(name) = NAMELESS.iter().find(|name| parts.contains(&OsStr::new(**name))) {
        faults.push(format!("{shown}: a folder called {name} says nothing of what is in it"));
    }
    let is_source = parts.len() > 3 && parts[0] == "crates" && parts[2] == "src";
    let lines = text.lines().count();
    if is_source && lines > MOST_LINES {
        faults.push(format!("{shown}: {lines} lines, at most {MOST_LINES}: it holds more than one thing"));
    }
    for (index, line) in text.lines().enumerate() {
        if let Some(start) = ABSOLUTE.iter().find(|start| names_a_place(line, start)) {
            faults.push(format!("{shown}:{}: a path from {start}... is there on one machine only", index + 1));
        }
    }
    faults
}

/// Whether `line` has a path that begins with `start`; `crates/work/x` and `docs.rs/home/x` do not.
fn names_a_place(line: &str, start: &str) -> bool {
    line.match_indices(start).any(|(at, _)| !line[..at].ends_with(|c: char| c.is_alphanumeric() || "._-".contains(c)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_file_may_have_500_lines_and_a_document_more() {
        let long = "\n".repeat(501);
        assert_eq!(faults_of(Path::new("./crates/cal/src/fit.rs"), &long).len(), 1);
        assert_eq!(faults_of(Path::new("./crates/cal/src/fit.rs"), &long[1..]).len(), 0);
        assert_eq!(faults_of(Path::new("./Cargo.lock"), &long).len(), 0);
    }

    #[test]
    fn a_folder_without_a_name_of_its_own_is_a_fault() {
        assert_eq!(faults_of(Path::new("crates/cal/src/utils/x.rs"), "").len(), 1);
        assert_eq!(faults_of(Path::new("crates/cal/src/common_mode.rs"), "").len(), 0);
    }

    #[test]
    fn a_path_into_one_machine_is_a_fault_and_a_relative_one_is_not() {
        let faults = |text: &str| faults_of(Path::new("README.md"), text).len();
        assert_eq!(faults(&format!("\nsee {}main", ABSOLUTE[0])), 1);
        assert_eq!(faults(&format!("({}me/zerorate)", ABSOLUTE[1])), 1);
        assert_eq!(faults(&format!("docs{}x and docs.rs{}x", ABSOLUTE[0], ABSOLUTE[1])), 0);
        assert_eq!(faults("../shared/data"), 0);
    }
}
