//! Holds the crates to the arrows of ARCHITECTURE.md: A -> B, A uses B; what is not drawn must not be.
//!
//! The arrows are read from that page, so that the page and the check cannot disagree.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context, Result, ensure};
use toml::Table;

use crate::steps::Outcome;
use crate::workspace::Workspace;

/// Arrows that tests have and products have not: bench's tests hold the driver's frames against sim's own decoder.
const IN_TESTS: [(&str, &str); 1] = [("bench", "max5494")];

/// Dependencies on the world outside that a crate must not have, each under "Never" in ARCHITECTURE.md.
const NEVER: [(&str, &[&str]); 3] = [
    (
        "core",
        &[
            "embedded-hal",
            "embedded-hal-async",
            "embedded-storage",
            "thiserror",
        ],
    ),
    ("max5494", &["heapless", "postcard", "serde"]),
    ("cal", &["clap", "indicatif", "tokio", "axum", "datafusion"]),
];

/// What one crate may use of another: all of it, or one module.
type Uses = BTreeMap<String, Option<String>>;

/// Checks every manifest, and the sources where an arrow points at one module only.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let arrows = arrows(&workspace.read("ARCHITECTURE.md")?)?;
    let folders = workspace.crates()?;
    let mut manifests = BTreeMap::new();
    for folder in &folders {
        let manifest: Table = workspace
            .read(Path::new("crates").join(folder).join("Cargo.toml"))?
            .parse()
            .with_context(|| format!("crates/{folder}/Cargo.toml"))?;
        manifests.insert(folder.as_str(), manifest);
    }
    let folder_of: BTreeMap<&str, &str> = manifests
        .iter()
        .filter_map(|(f, m)| Some((package(m)?, *f)))
        .collect();

    let mut faults = Vec::new();
    let nothing = Uses::new();
    for (folder, manifest) in &manifests {
        let allowed = arrows.get(*folder).unwrap_or(&nothing);
        for (dependency, only_tests) in dependencies(manifest) {
            match folder_of.get(dependency.as_str()) {
                Some(ours) => {
                    let drawn = allowed.contains_key(*ours)
                        || (only_tests && IN_TESTS.contains(&(*folder, *ours)));
                    if !drawn && ours != folder {
                        faults.push(format!(
                            "crates/{folder}/Cargo.toml: no arrow {folder} -> {ours}"
                        ));
                    }
                }
                None if NEVER
                    .iter()
                    .any(|(who, what)| who == folder && what.contains(&dependency.as_str())) =>
                {
                    faults.push(format!(
                        "crates/{folder}/Cargo.toml: {folder} must not know {dependency}"
                    ));
                }
                None => {}
            }
            let is_binary = workspace
                .root
                .join("crates")
                .join(folder)
                .join("src/main.rs")
                .is_file();
            if dependency == "anyhow" && !is_binary {
                faults.push(format!(
                    "crates/{folder}/Cargo.toml: anyhow is for binaries; give the error a type"
                ));
            }
        }
        for (used, module) in allowed
            .iter()
            .filter_map(|(used, module)| Some((used, module.as_ref()?)))
        {
            let Some(name) = manifests.get(used.as_str()).and_then(package) else {
                continue;
            };
            for (path, text) in workspace.sources(Path::new("crates").join(folder))? {
                let lines = uses_beyond(&text, &name.replace('-', "_"), module).into_iter();
                faults.extend(lines.map(|line| {
                    format!(
                        "{}:{line}: {folder} may use {used}::{module} and nothing else of {used}",
                        path.display()
                    )
                }));
            }
        }
    }
    ensure!(
        faults.is_empty(),
        "{} forbidden arrows\n    {}",
        faults.len(),
        faults.join("\n    ")
    );
    println!(
        "    {} crates keep to {} arrows",
        folders.len(),
        arrows.values().map(Uses::len).sum::<usize>()
    );
    Ok(Outcome::Passed)
}

/// The arrows drawn in the code block below the heading "Arrows".
fn arrows(page: &str) -> Result<BTreeMap<String, Uses>> {
    let section = page
        .split("\n## Arrows")
        .nth(1)
        .context("ARCHITECTURE.md has no section `## Arrows`")?;
    let drawing = section
        .split("```")
        .nth(1)
        .context("the section Arrows of ARCHITECTURE.md has no code block")?;
    let mut arrows: BTreeMap<String, Uses> = BTreeMap::new();
    // Arrows stand side by side, two spaces or more between them.
    for arrow in drawing
        .lines()
        .flat_map(|line| line.split("  "))
        .map(str::trim)
        .filter(|arrow| !arrow.is_empty())
    {
        let (user, used) = arrow
            .split_once(" -> ")
            .with_context(|| format!("ARCHITECTURE.md, Arrows: `{arrow}` is not `A -> B`"))?;
        for used in used.split(',').map(str::trim) {
            let (used, module) = match used.split_once("::") {
                Some((used, module)) => (used, Some(module.to_owned())),
                None => (used, None),
            };
            arrows
                .entry(user.to_owned())
                .or_default()
                .insert(used.to_owned(), module);
        }
    }
    Ok(arrows)
}

fn package(manifest: &Table) -> Option<&str> {
    manifest.get("package")?.get("name")?.as_str()
}

/// The packages a manifest names, and whether tests alone use them; target-specific ones included.
fn dependencies(manifest: &Table) -> BTreeSet<(String, bool)> {
    let targets = manifest
        .get("target")
        .and_then(|targets| targets.as_table());
    let per_target = targets
        .into_iter()
        .flat_map(Table::values)
        .filter_map(|target| target.as_table());
    let mut found = BTreeSet::new();
    for place in std::iter::once(manifest).chain(per_target) {
        for (section, only_tests) in [
            ("dependencies", false),
            ("build-dependencies", false),
            ("dev-dependencies", true),
        ] {
            let listed = place.get(section).and_then(|section| section.as_table());
            for (name, how) in listed.into_iter().flatten() {
                let renamed = how.get("package").and_then(|package| package.as_str());
                found.insert((renamed.unwrap_or(name).to_owned(), only_tests));
            }
        }
    }
    found
}

/// The numbers of the lines that use anything of the crate `name` but its module `module`.
///
/// `use name::{...}`, `use name as ...` and re-exports are faults too: what they bring in cannot be seen on the line.
fn uses_beyond(text: &str, name: &str, module: &str) -> Vec<usize> {
    let allowed = format!("::{module}");
    let is_fault = |line: &str| {
        let code = line.split("//").next().unwrap_or_default();
        code.match_indices(name).any(|(at, _)| {
            let rest = &code[at + name.len()..];
            let whole_module = rest
                .strip_prefix(&allowed)
                .is_some_and(|after| !after.starts_with(|c: char| c.is_alphanumeric() || c == '_'));
            !whole_module
        })
    };
    text.lines()
        .enumerate()
        .filter(|(_, line)| is_fault(line))
        .map(|(index, _)| index + 1)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_are_read_side_by_side_and_with_modules() {
        let page = "# A\n\n## Arrows\nA -> B.\n\n```\ndevice -> core, max5494   sim -> core::units\ncal -> core\n```\n";
        let arrows = arrows(page).unwrap();
        assert_eq!(arrows.len(), 3);
        assert_eq!(
            arrows["device"].keys().collect::<Vec<_>>(),
            ["core", "max5494"]
        );
        assert_eq!(arrows["sim"]["core"].as_deref(), Some("units"));
        assert_eq!(arrows["cal"]["core"], None);
    }

    #[test]
    fn a_drawing_that_is_not_of_arrows_is_an_error() {
        assert!(arrows("## No such section").is_err());
        assert!(arrows("\n## Arrows\n```\nsim uses core\n```").is_err());
    }

    #[test]
    fn dependencies_are_found_in_every_section_and_under_their_own_name() {
        let manifest: Table = "[dependencies]\na = '1'\nalias = { package = 'b', version = '1' }\n\
            [target.'cfg(unix)'.dev-dependencies]\nc.workspace = true\n[build-dependencies]\nd = '1'\n"
            .parse()
            .unwrap();
        let expected = [("a", false), ("b", false), ("c", true), ("d", false)];
        assert_eq!(
            dependencies(&manifest),
            expected
                .map(|(name, tests)| (name.to_owned(), tests))
                .into()
        );
    }

    #[test]
    fn only_the_module_an_arrow_points_at_may_be_named() {
        let faults = |line| uses_beyond(line, "zerorate_core", "units");
        assert_eq!(
            faults("use zerorate_core::units::Counts; // not zerorate_core::drift"),
            [0; 0]
        );
        assert_eq!(faults("use zerorate_core::units;"), [0; 0]);
        assert_eq!(faults("\nuse zerorate_core::drift::Drift;"), [2]);
        assert_eq!(faults("use zerorate_core::{units, trim};"), [1]);
        assert_eq!(faults("use zerorate_core as units;"), [1]);
        assert_eq!(faults("zerorate_core::units_of_mine::f()"), [1]);
    }
}
