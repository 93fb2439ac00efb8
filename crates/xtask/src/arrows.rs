//! Holds the crates to the arrows of ARCHITECTURE.md: A -> B, A uses B; what is not drawn must not be.
//!
//! The arrows are read from that page, so that the page and the check cannot disagree.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context, Result, ensure};
use toml::Table;

use crate::steps::Outcome;
use crate::workspace::Workspace;

/// Arrows that tests have and products have not: bench's tests hold the driver's frames against sim's own decoder, and
/// device's tests cut the power of sim's flash.
const IN_TESTS: [(&str, &str); 2] = [("bench", "max5494"), ("device", "sim")];

/// Dependencies on the world outside that a crate must not have, each under "Never" in ARCHITECTURE.md.
const NEVER: [(&str, &[&str]); 3] = [
    ("core", &["embedded-hal", "embedded-hal-async", "embedded-storage", "thiserror"]),
    ("max5494", &["heapless", "postcard", "serde"]),
    ("cal", &["clap", "indicatif", "tokio", "axum", "datafusion"]),
];

/// What one crate may use of others, by folder: all of it, or one module.
type Uses = BTreeMap<String, Option<String>>;

/// A crate of the workspace.
struct Member {
    folder: String,
    package: String,
    manifest: Table,
    is_binary: bool,
}

/// Checks every manifest, and the sources where an arrow points at one module only.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let arrows = arrows(&workspace.read("ARCHITECTURE.md")?)?;
    let members = members(workspace)?;
    let nothing = Uses::new();
    let mut faults = Vec::new();
    for member in &members {
        let allowed = arrows.get(&member.folder).unwrap_or(&nothing);
        faults.extend(manifest_faults(member, &members, allowed));
        faults.extend(source_faults(workspace, member, &members, allowed)?);
    }
    ensure!(faults.is_empty(), "{} forbidden arrows\n    {}", faults.len(), faults.join("\n    "));
    println!("    {} crates keep to {} arrows", members.len(), arrows.values().map(Uses::len).sum::<usize>());
    Ok(Outcome::Passed)
}

fn members(workspace: &Workspace) -> Result<Vec<Member>> {
    let member = |folder: String| {
        let path = Path::new("crates").join(&folder);
        let named = || format!("crates/{folder}/Cargo.toml");
        let manifest: Table = workspace.read(path.join("Cargo.toml"))?.parse().with_context(named)?;
        let package = manifest.get("package").and_then(|package| package.get("name")?.as_str());
        let package = package.with_context(named)?.to_owned();
        let is_binary = workspace.root.join(path).join("src/main.rs").is_file();
        Ok(Member { folder, package, manifest, is_binary })
    };
    workspace.crates()?.into_iter().map(member).collect()
}

/// What a manifest names and must not.
fn manifest_faults(member: &Member, members: &[Member], allowed: &Uses) -> Vec<String> {
    let folder = member.folder.as_str();
    let never = NEVER.iter().find(|(who, _)| *who == folder).map_or(&[][..], |(_, what)| *what);
    let mut faults = Vec::new();
    for (dependency, only_tests) in dependencies(&member.manifest) {
        let ours = members.iter().find(|ours| ours.package == dependency).map(|ours| ours.folder.as_str());
        let in_tests = |ours| only_tests && IN_TESTS.contains(&(folder, ours));
        if let Some(ours) = ours.filter(|ours| !allowed.contains_key(*ours) && !in_tests(ours)) {
            faults.push(format!("no arrow {folder} -> {ours}"));
        }
        if never.contains(&dependency.as_str()) {
            faults.push(format!("{folder} must not know {dependency}"));
        }
        if dependency == "anyhow" && !member.is_binary {
            faults.push("anyhow is for binaries; give the error a type".to_owned());
        }
    }
    faults.into_iter().map(|fault| format!("crates/{folder}/Cargo.toml: {fault}")).collect()
}

/// Where the sources reach beyond the one module that an arrow points at.
fn source_faults(workspace: &Workspace, member: &Member, members: &[Member], allowed: &Uses) -> Result<Vec<String>> {
    let mut faults = Vec::new();
    for used in members {
        let Some(Some(module)) = allowed.get(&used.folder) else {
            continue;
        };
        for (path, text) in workspace.sources(Path::new("crates").join(&member.folder))? {
            let lines = uses_beyond(&text, &used.package.replace('-', "_"), module).into_iter();
            let allowed = format!("of {} only {module} may be used", used.package);
            faults.extend(lines.map(|line| format!("{}:{line}: {allowed}", path.display())));
        }
    }
    Ok(faults)
}

/// The arrows drawn in the code block below the heading "Arrows".
fn arrows(page: &str) -> Result<BTreeMap<String, Uses>> {
    let section = page.split("\n## Arrows").nth(1).context("ARCHITECTURE.md has no section `## Arrows`")?;
    let drawing = section.split("```").nth(1).context("the section Arrows of ARCHITECTURE.md has no code block")?;
    let mut arrows: BTreeMap<String, Uses> = BTreeMap::new();
    // Arrows stand side by side, two spaces or more between them.
    for arrow in drawing.lines().flat_map(|line| line.split("  ")).map(str::trim).filter(|arrow| !arrow.is_empty()) {
        let (user, used) =
            arrow.split_once(" -> ").with_context(|| format!("ARCHITECTURE.md, Arrows: `{arrow}` is not `A -> B`"))?;
        for used in used.split(',').map(str::trim) {
            let (used, module) = match used.split_once("::") {
                Some((used, module)) => (used, Some(module.to_owned())),
                None => (used, None),
            };
            arrows.entry(user.to_owned()).or_default().insert(used.to_owned(), module);
        }
    }
    Ok(arrows)
}

/// The packages a manifest names, and whether tests alone use them; target-specific ones included.
fn dependencies(manifest: &Table) -> BTreeSet<(String, bool)> {
    let targets = manifest.get("target").and_then(|targets| targets.as_table());
    let per_target = targets.into_iter().flat_map(Table::values).filter_map(|target| target.as_table());
    let mut found = BTreeSet::new();
    for place in std::iter::once(manifest).chain(per_target) {
        for (section, only_tests) in
            [("dependencies", false), ("build-dependencies", false), ("dev-dependencies", true)]
        {
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
    text.lines().enumerate().filter(|(_, line)| is_fault(line)).map(|(index, _)| index + 1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_are_read_side_by_side_and_with_modules() {
        let page = "# A\n\n## Arrows\nA -> B.\n\n```\ndevice -> core, max5494   sim -> core::units\ncal -> core\n```\n";
        let arrows = arrows(page).unwrap();
        assert_eq!(arrows.len(), 3);
        assert_eq!(arrows["device"].keys().collect::<Vec<_>>(), ["core", "max5494"]);
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
        assert_eq!(dependencies(&manifest), expected.map(|(name, tests)| (name.to_owned(), tests)).into());
    }

    fn member(folder: &str, manifest: &str) -> Member {
        let package = format!("zerorate-{folder}");
        Member { folder: folder.into(), package, manifest: manifest.parse().unwrap(), is_binary: false }
    }

    #[test]
    fn a_manifest_may_name_what_an_arrow_points_at_and_nothing_else_of_ours() {
        let members = [member("cal", "[dependencies]\nzerorate-core = '1'\nclap = '4'\ncsv = '1'"), member("core", "")];
        let drawn = Uses::from([("core".to_owned(), None)]);
        assert_eq!(manifest_faults(&members[0], &members, &drawn), ["crates/cal/Cargo.toml: cal must not know clap"]);
        assert_eq!(manifest_faults(&members[0], &members, &Uses::new()).len(), 2);
    }

    #[test]
    fn anyhow_is_for_binaries() {
        let library = member("sim", "[dependencies]\nanyhow = '1'");
        assert_eq!(manifest_faults(&library, &[], &Uses::new()).len(), 1);
        let binary = Member { is_binary: true, ..library };
        assert_eq!(manifest_faults(&binary, &[], &Uses::new()).len(), 0);
    }

    #[test]
    fn only_the_module_an_arrow_points_at_may_be_named() {
        let faults = |line| uses_beyond(line, "zerorate_core", "units");
        assert_eq!(faults("use zerorate_core::units::Counts; // not zerorate_core::drift"), [0; 0]);
        assert_eq!(faults("use zerorate_core::units;"), [0; 0]);
        assert_eq!(faults("\nuse zerorate_core::drift::Drift;"), [2]);
        assert_eq!(faults("use zerorate_core::{units, trim};"), [1]);
        assert_eq!(faults("use zerorate_core as units;"), [1]);
        assert_eq!(faults("zerorate_core::units_of_mine::f()"), [1]);
    }
}
