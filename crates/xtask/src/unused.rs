//! What is public in a library and used by nobody: the compiler cannot say so, for it does not see who else is there.
//!
//! Everything is looked for by its name, in all code of the project that is no test: the firmware, the fuzz targets, the
//! examples and the C header too. A name that is used for something else as well is taken for used, so what is found is
//! unused, and not all is found. What only something unused mentions is unused.

mod definitions;
mod kept;
mod uses;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::lines;
use crate::steps::Outcome;
use crate::syntax::packages;
use crate::workspace::Workspace;
use definitions::{Definition, definitions};
use kept::KEPT;
use uses::{Uses, mentioned};

/// Crates whose public names are for others than us.
const PUBLISHED: [&str; 2] = ["crates/max5494", "crates/imu-logs"];

/// A crate that stands in for a bench in tests too: what other crates' tests use of it is used.
const FOR_TESTS: &str = "crates/sim";

/// Folders of crates with unused names still. A clean one must not stand here: this list gets shorter, never longer.
const NOT_YET_CLEAN: [&str; 0] = [];

/// Checks the public names of every crate in crates/.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let files = Files::read(workspace)?;
    let mut faults = Vec::new();
    let unused = files.unused();
    let is_kept = |found: &Definition| KEPT.iter().any(|(path, name, _)| found.is(path, name));
    for (path, name, _) in KEPT.iter().filter(|(path, name, _)| !unused.iter().any(|found| found.is(path, name))) {
        faults.push(format!("{}: {name} is used or gone, take it out of KEPT", path));
    }
    let mut by_crate: BTreeMap<PathBuf, Vec<String>> = BTreeMap::new();
    for found in unused.into_iter().filter(|found| !is_kept(found)) {
        let by = if files.is_tested(found) { "by tests alone" } else { "by nobody" };
        let text = format!("{}:{}: {} is used {by}", found.path.display(), found.line, found.full_name());
        by_crate.entry(crate_of(&found.path)).or_default().push(text);
    }
    for folder in NOT_YET_CLEAN {
        match by_crate.remove(Path::new(folder)) {
            Some(found) => println!("    {folder}: not yet clean, {}\n    {}", found.len(), found.join("\n    ")),
            None => faults.push(format!("{folder}: all of it is used, take it out of NOT_YET_CLEAN")),
        }
    }
    faults.extend(by_crate.into_values().flatten());
    ensure!(faults.is_empty(), "{} faults\n    {}", faults.len(), faults.join("\n    "));
    println!("    {} public names", files.definitions.len());
    Ok(Outcome::Passed)
}

/// The project's code, read.
struct Files {
    definitions: Vec<Definition>,
    uses: Uses,
    /// The words of tests and of the pages that are tested, by crate.
    tests: BTreeMap<PathBuf, BTreeSet<String>>,
}

impl Files {
    fn read(workspace: &Workspace) -> Result<Self> {
        let uses = Uses::between(packages(workspace)?);
        let mut found = Self { definitions: Vec::new(), uses, tests: BTreeMap::new() };
        let mut parsed = Vec::new();
        for (path, text) in workspace.sources(".")? {
            // An example shows how something is used, and so it is.
            if lines::is_test(&path) && !path.iter().any(|part| part == "examples") {
                found.tests.entry(crate_of(&path)).or_default().extend(words(&text));
                continue;
            }
            let tests = lines::only_tests(&text).with_context(|| path.display().to_string())?;
            found.tests.entry(crate_of(&path)).or_default().extend(words(&tests));
            parsed.push((path.clone(), syn::parse_file(&text).with_context(|| path.display().to_string())?));
        }
        for (path, file) in &parsed {
            let is_ours = path.starts_with("crates") && !PUBLISHED.iter().any(|published| path.starts_with(published));
            if is_ours && path.iter().nth(2).is_some_and(|folder| folder == "src") {
                found.definitions.extend(definitions(path, &file.items));
            }
        }
        for (path, file) in &parsed {
            found.uses.take(path, &file.items, &found.definitions);
        }
        for path in workspace.files(".")? {
            let extension = path.extension().and_then(|extension| extension.to_str());
            match extension {
                Some("h" | "c") => found.uses.take_words(words(&workspace.read(&path)?)),
                Some("md") => found.tests.entry(crate_of(&path)).or_default().extend(words(&workspace.read(&path)?)),
                _ => {}
            }
        }
        Ok(found)
    }

    /// What nobody uses, and what only that mentions.
    fn unused(&self) -> Vec<&Definition> {
        let mut unused = BTreeSet::new();
        loop {
            let is_unused = |place: &usize| {
                !self.is_for_tests(&self.definitions[*place])
                    && !mentioned(&self.uses, &self.definitions, *place, &unused)
            };
            let found: BTreeSet<usize> = (0..self.definitions.len()).filter(is_unused).collect();
            if found == unused {
                break;
            }
            unused = found;
        }
        // Of a type that is unused, the type is told and not each of its functions.
        let of_unused = |found: &Definition| {
            let mut types = unused.iter().map(|&place| &self.definitions[place]).filter(|found| found.owner.is_none());
            types.any(|unused| found.owner.as_ref() == Some(&unused.name))
        };
        unused.iter().map(|&place| &self.definitions[place]).filter(|found| !of_unused(found)).collect()
    }

    fn is_tested(&self, found: &Definition) -> bool {
        self.tests.values().any(|words| words.contains(&found.name))
    }

    fn is_for_tests(&self, found: &Definition) -> bool {
        let mut of_others = self.tests.iter().filter(|(folder, _)| **folder != Path::new(FOR_TESTS));
        found.path.starts_with(FOR_TESTS) && of_others.any(|(_, words)| words.contains(&found.name))
    }
}

/// `crates/cal` for a file of that crate.
fn crate_of(path: &Path) -> PathBuf {
    path.iter().take(2).collect()
}

fn words(text: &str) -> impl Iterator<Item = String> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty()).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names that are unused in files below crates/a/src.
    fn unused(files: &[(&str, &str)]) -> Vec<String> {
        let mut found = Files { definitions: Vec::new(), uses: Uses::default(), tests: BTreeMap::new() };
        let parsed: Vec<_> = files
            .iter()
            .map(|(name, text)| (Path::new("crates/a/src").join(name), syn::parse_file(text).unwrap().items))
            .collect();
        parsed.iter().for_each(|(path, items)| found.definitions.extend(definitions(path, items)));
        parsed.iter().for_each(|(path, items)| found.uses.take(path, items, &found.definitions));
        found.unused().into_iter().map(Definition::full_name).collect()
    }

    #[test]
    fn what_is_used_elsewhere_is_used_and_what_is_used_by_itself_is_not() {
        let a = "pub fn f() {} pub fn g() { g() } pub const H: u8 = 1; pub struct I; impl I { pub fn j() -> I { I } }";
        assert_eq!(unused(&[("lib.rs", a)]), ["f", "g", "H", "I"]);
        let b = "use a::{f, I}; fn k() { f(); a::g(); println!(\"{H}\"); let _: I; } const H: u8 = 2;";
        assert_eq!(unused(&[("lib.rs", a), ("b.rs", b)]), ["H", "I::j"]);
    }

    #[test]
    fn a_reexport_and_an_import_are_no_use_and_neither_is_a_variable_of_the_name() {
        let a = "pub fn f() {} pub trait T { fn g(&self); }";
        assert_eq!(
            unused(&[("lib.rs", a), ("b.rs", "pub use a::{f, T};"), ("c.rs", "fn k(f: u8) { h(f, i.g) }")]),
            ["f", "T"]
        );
        assert_eq!(unused(&[("lib.rs", a), ("b.rs", "use a::{f as k, T}; fn l(x: X) { x.g() }")]), [""; 0]);
        assert_eq!(unused(&[("lib.rs", a), ("b.rs", "pub use a::{f, T}; fn l(x: impl T) { f(x.g()) }")]), [""; 0]);
    }

    #[test]
    fn what_only_something_unused_mentions_is_unused() {
        let a = "pub fn f() { g(); } pub fn g() { h::<I>() } fn h<X>() {} pub struct I;";
        assert_eq!(unused(&[("lib.rs", a)]), ["f", "g", "I"]);
        assert_eq!(unused(&[("lib.rs", &format!("{a} fn main() {{ f() }}"))]), [""; 0]);
    }

    #[test]
    fn what_tests_use_is_not_used_and_what_c_calls_is() {
        let a = "pub fn f() {} #[cfg(test)] mod tests { fn t() { super::f() } } #[unsafe(no_mangle)] pub fn g() {}";
        assert_eq!(unused(&[("lib.rs", a)]), ["f"]);
    }
}
