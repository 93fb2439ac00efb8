//! The packages of the project and the files that their crates begin with.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use toml::{Table, Value};

use crate::workspace::Workspace;

/// A package of any of the project's workspaces.
pub struct Package {
    /// Its folder, from the root.
    pub folder: PathBuf,
    /// The files that its library and its programs begin with, from the root; tests, benchmarks and examples have theirs
    /// beside.
    pub roots: Vec<PathBuf>,
}

/// Every package, sorted by its folder.
pub fn packages(workspace: &Workspace) -> Result<Vec<Package>> {
    let files = workspace.files(".")?;
    let mut found = Vec::new();
    for path in files.iter().filter(|path| path.file_name() == Some(OsStr::new("Cargo.toml"))) {
        let manifest: Table = workspace.read(path)?.parse().with_context(|| path.display().to_string())?;
        if !manifest.contains_key("package") {
            continue;
        }
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let roots = roots(&manifest).into_iter().map(|root| folder.join(root)).filter(|root| files.contains(root));
        let roots = roots.collect();
        found.push(Package { folder, roots });
    }
    Ok(found)
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
