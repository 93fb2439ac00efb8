//! The rules of the house that no other tool keeps: small crates and files, folders with names of their own, and nothing in
//! the repository that is true on one machine only.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use syn::Block;
use syn::visit::{self, Visit};

use crate::lines::{self, Files};
use crate::steps::Outcome;
use crate::syntax::{attributes_of, only_in_tests};
use crate::workspace::Workspace;

/// A source file is one chip, one algorithm, one subcommand: about 300 lines, and never more than this; unless it is a
/// table.
const MOST_LINES: usize = 500;

/// A crate is one part of the story: never more lines than this, its tests left out.
const MOST_OF_CRATE: usize = 10_000;

/// Half of a crate's files have no more lines than this, their tests left out.
const MOST_MEDIAN: usize = 200;

/// Folders of crates that are too large still. One that is not must not stand here: this list gets shorter, never longer.
const NOT_YET_SMALL: [&str; 0] = [];

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
    let packages = lines::by_package(workspace)?;
    faults.extend(faults_of_size(&packages, &NOT_YET_SMALL));
    ensure!(faults.is_empty(), "{} faults\n    {}", faults.len(), faults.join("\n    "));
    println!("    {} files; {} lines of Rust without tests", files.len(), lines::total(&packages));
    Ok(Outcome::Passed)
}

fn faults_of(path: &Path, text: &str) -> Vec<String> {
    let shown = path.display();
    let mut faults = Vec::new();
    let parts: Vec<&OsStr> = path.iter().filter(|part| *part != ".").collect();
    if let Some(name) = NAMELESS.iter().find(|name| parts.contains(&OsStr::new(**name))) {
        faults.push(format!("{shown}: a folder called {name} says nothing of what is in it"));
    }
    let lines = text.lines().count();
    if path.extension() == Some(OsStr::new("rs")) && lines > MOST_LINES && !is_table(text) {
        faults.push(format!("{shown}: {lines} lines, at most {MOST_LINES}: it holds more than one thing"));
    }
    for (index, line) in text.lines().enumerate() {
        if let Some(start) = ABSOLUTE.iter().find(|start| names_a_place(line, start)) {
            faults.push(format!("{shown}:{}: a path from {start}... is there on one machine only", index + 1));
        }
    }
    faults
}

/// Packages that are too large or whose files are; those of `exempt` may be, and must be.
fn faults_of_size(packages: &BTreeMap<PathBuf, Files>, exempt: &[&str]) -> Vec<String> {
    let mut faults = Vec::new();
    for (folder, files) in packages {
        let shown = folder.display();
        let is_exempt = exempt.iter().any(|exempt| folder == Path::new(exempt));
        let lines: usize = files.values().sum();
        if lines > MOST_OF_CRATE && !is_exempt {
            faults.push(format!(
                "{shown}: {lines} lines without tests, at most {MOST_OF_CRATE}: it is more than one crate"
            ));
        } else if lines <= MOST_OF_CRATE && is_exempt {
            faults.push(format!("{shown}: small enough now, take it out of NOT_YET_SMALL"));
        }
        let median = lines::median(files);
        if median > MOST_MEDIAN {
            faults.push(format!("{shown}: half of its files have {median} lines or more, at most {MOST_MEDIAN}"));
        }
    }
    faults
}

/// Whether a file only says what is: constants, types and imports, and outside its tests no line of code that runs.
fn is_table(text: &str) -> bool {
    struct Code(bool);
    impl Visit<'_> for Code {
        fn visit_item(&mut self, item: &syn::Item) {
            if !only_in_tests(attributes_of(item)) {
                visit::visit_item(self, item);
            }
        }
        fn visit_block(&mut self, _: &Block) {
            self.0 = true;
        }
    }
    let mut code = Code(false);
    syn::parse_file(text).is_ok_and(|file| {
        code.visit_file(&file);
        !code.0
    })
}

/// Whether `line` has a path that begins with `start`; `crates/work/x` and `docs.rs/home/x` do not.
fn names_a_place(line: &str, start: &str) -> bool {
    line.match_indices(start).any(|(at, _)| !line[..at].ends_with(|c: char| c.is_alphanumeric() || "._-".contains(c)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_file_may_have_500_lines_and_a_document_or_a_table_more() {
        let long = "\n".repeat(500) + "fn f() {}";
        assert_eq!(faults_of(Path::new("./firmware/app/src/parts.rs"), &long).len(), 1);
        assert_eq!(faults_of(Path::new("./firmware/app/src/parts.rs"), &long[1..]).len(), 0);
        assert_eq!(faults_of(Path::new("./Cargo.lock"), &long).len(), 0);
        let table = "\n".repeat(500) + "const A: [u8; 1] = [1];\n#[cfg(test)]\nmod tests {\n    fn f() {}\n}";
        assert_eq!(faults_of(Path::new("./crates/cal/src/table.rs"), &table).len(), 0);
    }

    #[test]
    fn a_crate_may_have_10_000_lines_and_half_of_its_files_200() {
        let package = |files: &[usize]| {
            let files = files.iter().enumerate().map(|(n, lines)| (n.to_string().into(), *lines)).collect();
            BTreeMap::from([(PathBuf::from("crates/cal"), files)])
        };
        let many = package(&[200; 50]);
        assert_eq!(faults_of_size(&many, &[]), [""; 0]);
        assert_eq!(faults_of_size(&many, &["crates/cal"]).len(), 1);
        assert_eq!(faults_of_size(&package(&[200; 51]), &[]).len(), 1);
        assert_eq!(faults_of_size(&package(&[200; 51]), &["crates/cal"]), [""; 0]);
        assert_eq!(faults_of_size(&package(&[10, 201, 201]), &[]).len(), 1);
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
