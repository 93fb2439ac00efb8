//! The crates that run on the board must do without an operating system.
//!
//! Their sources are read for it; where a bare-metal target is installed, they are compiled for it as well.

use std::path::Path;
use std::process::Command;

use anyhow::{Result, ensure};

use crate::cargo;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// The board's side: folder in crates/ and package.
const BOARD_SIDE: [(&str, &str); 4] = [
    ("core", "zerorate-core"),
    ("max5494", "max5494"),
    ("device", "zerorate-device"),
    ("lockstep", "zerorate-lockstep"),
];

/// Any target without std would do; this is the firmware's.
const BARE_TARGET: &str = "thumbv7em-none-eabihf";

/// Checks all crates of the board's side.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let mut faults = Vec::new();
    for (folder, _) in BOARD_SIDE {
        let root = Path::new("crates").join(folder).join("src");
        if !workspace.read(root.join("lib.rs"))?.lines().any(|line| line == "#![no_std]") {
            faults.push(format!("{}: is not #![no_std]", root.join("lib.rs").display()));
        }
        for (path, text) in workspace.sources(&root)? {
            if path.ends_with("tests.rs") {
                continue;
            }
            let lines = mentions_of_std(&text).into_iter();
            faults.extend(lines.map(|line| format!("{}:{line}: uses std or alloc", path.display())));
        }
    }
    ensure!(faults.is_empty(), "{} faults\n    {}", faults.len(), faults.join("\n    "));
    if !has_bare_target() {
        println!("    read only: `rustup target add {BARE_TARGET}` lets this step compile as well");
        return Ok(Outcome::Passed);
    }
    let mut arguments = vec!["check", "--target", BARE_TARGET];
    arguments.extend(BOARD_SIDE.iter().flat_map(|(_, package)| ["--package", package]));
    cargo::run(workspace, &arguments)
}

/// The numbers of the lines of shipped code that name std or alloc.
fn mentions_of_std(text: &str) -> Vec<usize> {
    const NAMES: [&str; 4] = ["std::", "alloc::", "extern crate std", "extern crate alloc"];
    let mut found = Vec::new();
    let mut only_in_tests = false;
    for (index, line) in text.lines().enumerate() {
        let code = line.split("//").next().unwrap_or_default();
        if only_in_tests && code.starts_with("mod ") {
            break; // The tests' module ends a file.
        }
        if !only_in_tests && NAMES.iter().any(|name| mentions(code, name)) {
            found.push(index + 1);
        }
        only_in_tests = code.trim() == "#[cfg(test)]";
    }
    found
}

/// Whether `code` has `path`, and not as the end of a longer name.
fn mentions(code: &str, path: &str) -> bool {
    code.match_indices(path).any(|(at, _)| !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_'))
}

fn has_bare_target() -> bool {
    let printed = Command::new("rustc").args(["--print", "target-libdir", "--target", BARE_TARGET]).output();
    printed.is_ok_and(|output| Path::new(String::from_utf8_lossy(&output.stdout).trim()).is_dir())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn std_in_shipped_code_is_found() {
        assert_eq!(mentions_of_std("use core::fmt;\n    let words: std::vec::Vec<u8>;\n"), [2]);
        assert_eq!(mentions_of_std("extern crate alloc;\n"), [1]);
    }

    #[test]
    fn std_in_comments_in_longer_names_and_for_tests_is_not_a_fault() {
        let text = "// std::fmt is not used\nuse no_std::x;\n#[cfg(test)]\nextern crate std;\n\
            #[cfg(test)]\nmod tests {\n    use std::vec;\n}\n";
        assert_eq!(mentions_of_std(text), [0; 0]);
    }
}
