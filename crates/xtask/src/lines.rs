//! How much Rust there is, tests left out: what [`crate::house`] holds to its limits, and `cargo xtask lines` prints.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use syn::Item;

use crate::steps::Outcome;
use crate::syntax::{only_in_tests, packages};
use crate::workspace::Workspace;

/// The lines of a package's files without their tests, by the file's path from the root.
pub type Files = BTreeMap<PathBuf, usize>;

/// Prints the lines of every package, and of all of them.
pub fn print(workspace: &Workspace) -> Result<Outcome> {
    let packages = by_package(workspace)?;
    println!("    {:26} {:>6} {:>6} {:>7} {:>8}", "", "lines", "files", "median", "longest");
    for (folder, files) in &packages {
        let lines: usize = files.values().sum();
        let longest = files.values().max().unwrap_or(&0);
        println!("    {:26} {lines:6} {:6} {:7} {longest:8}", folder.display(), files.len(), median(files));
    }
    println!("    {:26} {:6}", "in all, without tests", total(&packages));
    Ok(Outcome::Passed)
}

/// The lines of all packages.
pub fn total(packages: &BTreeMap<PathBuf, Files>) -> usize {
    packages.values().flat_map(BTreeMap::values).sum()
}

/// The middle one of the files' lengths; the lower one of two in the middle.
pub fn median(files: &Files) -> usize {
    let mut lines: Vec<usize> = files.values().copied().collect();
    lines.sort_unstable();
    lines.get(lines.len().saturating_sub(1) / 2).copied().unwrap_or(0)
}

/// The lines without tests of every Rust file, by the folder of its package: all lines, comments and empty ones too. Left
/// out are folders called tests, benches and examples, files called tests.rs or ending in _tests.rs, and in the others
/// the modules for tests.
pub fn by_package(workspace: &Workspace) -> Result<BTreeMap<PathBuf, Files>> {
    let packages = packages(workspace)?;
    let mut found: BTreeMap<PathBuf, Files> = BTreeMap::new();
    for (path, text) in workspace.sources(".")?.into_iter().filter(|(path, _)| !is_test(path)) {
        let around = packages.iter().filter(|package| path.starts_with(&package.folder));
        let folder = around.map(|package| &package.folder).max_by_key(|folder| folder.components().count());
        let folder = folder.cloned().unwrap_or_default();
        let lines = without_tests(&text).with_context(|| path.display().to_string())?;
        found.entry(folder).or_default().insert(path, lines);
    }
    Ok(found)
}

/// Whether a file is there for tests, benchmarks or as an example.
pub fn is_test(path: &Path) -> bool {
    let is_aside = |part: &OsStr| ["tests", "benches", "examples"].iter().any(|aside| part == *aside);
    let stem = path.file_stem().and_then(OsStr::to_str).unwrap_or_default();
    path.iter().any(is_aside) || stem == "tests" || stem.ends_with("_tests")
}

/// The lines of a file without its modules for tests.
fn without_tests(text: &str) -> Result<usize> {
    Ok(text.lines().count() - tests_in(text)?.into_iter().map(|lines| lines.count()).sum::<usize>())
}

/// The modules for tests of a file.
pub fn only_tests(text: &str) -> Result<String> {
    let lines: Vec<&str> = text.lines().collect();
    let of_tests = tests_in(text)?.into_iter().flat_map(|tests| lines.get(tests).unwrap_or_default());
    Ok(of_tests.copied().collect::<Vec<_>>().join("\n"))
}

/// The lines of the modules for tests of a file, counted from 0.
fn tests_in(text: &str) -> Result<Vec<Range<usize>>> {
    let mut found = Vec::new();
    syn::parse_file(text)?.items.iter().for_each(|item| take_tests(item, &mut found));
    Ok(found)
}

fn take_tests(item: &Item, found: &mut Vec<Range<usize>>) {
    let Item::Mod(module) = item else { return };
    let Some(began) = module.attrs.first().filter(|_| only_in_tests(&module.attrs)) else {
        return module.content.iter().flat_map(|(_, items)| items).for_each(|item| take_tests(item, found));
    };
    let end = match (&module.content, &module.semi) {
        (Some((brace, _)), _) => brace.span.close(),
        (None, Some(semicolon)) => semicolon.spans[0],
        (None, None) => module.ident.span(),
    };
    found.push(began.pound_token.spans[0].start().line - 1..end.end().line);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_module_for_tests_counts_from_its_attribute_to_its_brace() {
        let text = "//! Doc.\n\nfn f() {}\n\n#[cfg(test)]\nmod tests {\n    fn g() {}\n}\n";
        assert_eq!(without_tests(text).unwrap(), 4);
        assert_eq!(without_tests("mod a {\n    #[cfg(test)]\n    mod tests;\n}\n").unwrap(), 2);
        assert_eq!(without_tests("#[cfg(unix)]\nmod a {\n}\n").unwrap(), 3);
    }

    #[test]
    fn tests_benchmarks_and_examples_are_known_by_their_place() {
        for test in ["crates/cal/src/fit/tests.rs", "a/src/fit/tests/x.rs", "a/tests/b/mod.rs", "a/src/port_tests.rs"] {
            assert!(is_test(Path::new(test)), "{test}");
        }
        assert!(!is_test(Path::new("crates/bench/src/procedure/compensation_test.rs")));
        assert!(is_test(Path::new("crates/cal/benches/fit_kernel.rs")));
    }

    #[test]
    fn the_median_is_a_file_s() {
        let files = |lines: &[usize]| lines.iter().enumerate().map(|(n, l)| (n.to_string().into(), *l)).collect();
        assert_eq!(median(&files(&[500, 1, 7])), 7);
        assert_eq!(median(&files(&[500, 1, 7, 2])), 2);
        assert_eq!(median(&Files::new()), 0);
    }
}
