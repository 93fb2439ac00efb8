//! The packages of the project and the files that their crates begin with.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use toml::{Table, Value};

use crate::workspace::Workspace;

/// A package of any of the project's workspaces.
#[derive(Debug)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// The packages that it uses, and those that they use; in tests as well.
    pub uses: BTreeSet<String>,
    /// Its folder, from the root.
    pub folder: PathBuf,
    /// The files that its library and its programs begin with, from the root; tests, benchmarks and examples have theirs
    /// beside.
    pub roots: Vec<PathBuf>,
}

/// Every package, sorted by its folder.
pub fn packages(workspace: &Workspace) -> Result<Vec<Package>> {
    let files = workspace.files(".")?;
    let mut found: Vec<Package> = Vec::new();
    for path in files.iter().filter(|path| path.file_name() == Some(OsStr::new("Cargo.toml"))) {
        let manifest: Table = workspace.read(path)?.parse().with_context(|| path.display().to_string())?;
        let Some(name) = manifest.get("package").and_then(|package| package.get("name")?.as_str()) else { continue };
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let roots = roots(&manifest).into_iter().map(|root| folder.join(root)).filter(|root| files.contains(root));
        let roots = roots.collect();
        found.push(Package { name: name.to_owned(), uses: used(&manifest), folder, roots });
    }
    // As often as arrows can stand one after another.
    for _ in 0..found.len() {
        let further: Vec<BTreeSet<String>> = found.iter().map(|package| package.uses.clone()).collect();
        let of = |name: &String| found.iter().position(|package| package.name == *name).map(|place| &further[place]);
        let all = |uses: &BTreeSet<String>| uses.iter().filter_map(of).flatten().cloned().collect::<BTreeSet<_>>();
        let more: Vec<BTreeSet<String>> = further.iter().map(all).collect();
        found.iter_mut().zip(more).for_each(|(package, more)| package.uses.extend(more));
    }
    Ok(found)
}

/// The dependencies that a manifest names, by the names that it calls them.
fn used(manifest: &Table) -> BTreeSet<String> {
    let targets = manifest.get("target").and_then(Value::as_table).into_iter().flat_map(Table::values);
    let places = std::iter::once(manifest).chain(targets.filter_map(Value::as_table));
    let sections = |place: &Table| {
        let of = |section: &str| place.get(section).and_then(Value::as_table).cloned().unwrap_or_default();
        ["dependencies", "dev-dependencies", "build-dependencies"].map(of)
    };
    places.flat_map(sections).flat_map(|section| section.into_iter().map(|(name, _)| name)).collect()
}

/// Where cargo looks for a library and programs, whether they are there or not.
fn roots(manifest: &Table) -> Vec<PathBuf> {
    let path = |target: &Value| target.get("path").and_then(Value::as_str).map(PathBuf::from);
    let library = manifest.get("lib").and_then(path);
    let mut roots = vec![library.unwrap_or_else(|| "src/lib.rs".into()), "src/main.rs".into()];
    let programs = manifest.get("bin").and_then(Value::as_array).into_iter().flatten();
    roots.extend(programs.filter_map(path));
    roots.sort();
    roots.dedup();
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_and_programs_are_where_the_manifest_says_or_where_cargo_looks() {
        let of = |text: &str| roots(&text.parse().unwrap());
        assert_eq!(of(""), ["src/lib.rs", "src/main.rs"].map(PathBuf::from));
        let text = "[lib]\npath = 'x.rs'\n[[bin]]\nname = 'a'\npath = 'src/main.rs'\n[[bin]]\npath = 'b.rs'\n";
        assert_eq!(of(text), ["b.rs", "src/main.rs", "x.rs"].map(PathBuf::from));
    }
}
