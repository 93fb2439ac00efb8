//! No circle between the files of a crate: who follows the arrows from a file never comes back to it.
//!
//! An arrow goes from a file to each that defines what it uses, re-exports followed; what is called on a value is not seen,
//! for no type is known here. A file and those below it are a family, in which it may use them and they it: a circle is
//! none where one of its files is around all others. Tests are left out.

mod components;
mod names;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

use anyhow::{Result, ensure};
use syn::Item;
use syn::visit::Visit;

use crate::steps::Outcome;
use crate::syntax::{Crate, Kind, Mention, Mentions, packages, type_path};
use crate::workspace::Workspace;
use names::Names;

/// Folders of crates that still have circles. A clean one must not stand here: this list gets shorter, never longer.
const NOT_YET_CLEAN: [&str; 0] = [];

/// From file to file, by their places in the crate: the lines that make an arrow, and what they use.
type Arrows = BTreeMap<(usize, usize), Vec<(usize, String)>>;

/// Checks every crate of the project's workspaces.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let read = |path: &Path| workspace.read(path).ok();
    let (mut crates, mut files) = (0, 0);
    let mut told = Vec::new();
    for package in packages(workspace)? {
        let mut circles = Vec::new();
        for root in &package.roots {
            let tree = Crate::read(root, &read)?;
            circles.extend(circles_of(&tree));
            crates += 1;
            files += tree.files.len();
        }
        let is_listed = NOT_YET_CLEAN.iter().any(|folder| package.folder == Path::new(folder));
        if is_listed && circles.is_empty() {
            told.push(format!("{}: no circle any more, take it out of NOT_YET_CLEAN", package.folder.display()));
        } else if is_listed {
            println!("    {}: not yet clean\n    {}", package.folder.display(), circles.join("\n    "));
        } else {
            told.append(&mut circles);
        }
    }
    ensure!(told.is_empty(), "{} circles\n    {}", told.len(), told.join("\n    "));
    println!("    {files} files of {crates} crates");
    Ok(Outcome::Passed)
}

/// A text for each circle of a crate.
fn circles_of(tree: &Crate) -> Vec<String> {
    let arrows = arrows(tree);
    let parents: Vec<Option<usize>> = (0..tree.files.len()).map(|file| tree.file_around(file)).collect();
    // The file that is next below `around` on the way to `file`, if it is below.
    let family = |around: usize, file: usize| {
        std::iter::successors(Some(file), |&file| parents[file]).find(|&file| parents[file] == Some(around))
    };
    let mut told = Vec::new();
    for around in 0..tree.files.len() {
        let families: Vec<Option<usize>> = (0..tree.files.len()).map(|file| family(around, file)).collect();
        let mut next = vec![Vec::new(); tree.files.len()];
        for (from, to) in arrows.keys().filter(|(from, to)| families[*from].is_some() && families[*to].is_some()) {
            next[*from].push(*to);
        }
        for circle in components::circles(&next) {
            let met: BTreeSet<usize> = circle.iter().filter_map(|&file| families[file]).collect();
            if met.len() > 1 {
                let crosses = |(from, to): &(usize, usize)| {
                    circle.contains(from) && circle.contains(to) && families[*from] != families[*to]
                };
                told.push(text_of(tree, &met, circle.len(), arrows.iter().filter(|(arrow, _)| crosses(arrow))));
            }
        }
    }
    told
}

/// A circle by the families that it goes through, and every arrow from one to another.
fn text_of<'a>(
    tree: &Crate,
    families: &BTreeSet<usize>,
    files: usize,
    arrows: impl Iterator<Item = (&'a (usize, usize), &'a Vec<(usize, String)>)>,
) -> String {
    let shown = |file: usize| tree.files[file].display().to_string();
    let names: Vec<String> = families.iter().map(|&file| shown(file)).collect();
    let mut text = format!("{files} files in a circle through {}", names.join(", "));
    for ((from, to), lines) in arrows {
        let used: Vec<String> = lines.iter().map(|(line, thing)| format!("{thing} (line {line})")).collect();
        // Writing to a String cannot fail.
        let _ = write!(text, "\n        {} -> {}: {}", shown(*from), shown(*to), used.join(", "));
    }
    text
}

/// All arrows of a crate. Each thing is named once an arrow, where it is met first.
fn arrows(tree: &Crate) -> Arrows {
    let mentions: Vec<Vec<Mention>> =
        tree.modules.iter().map(|module| module.items.iter().flat_map(mentions_of).collect()).collect();
    let names = Names::of(tree, &mentions);
    let mut arrows = Arrows::new();
    for (place, (module, mentions)) in tree.modules.iter().zip(&mentions).enumerate() {
        for mention in mentions.iter().filter(|mention| mention.kind != Kind::Method) {
            let found = names.resolve(place, &mention.path);
            let Some(thing) = found.thing else { continue };
            let mut homes = vec![thing.clone()];
            if let Some(part) = found.part {
                let whole = format!("{}::{part}", thing.1);
                homes.extend(names.places_of(&thing, &part).iter().map(|&home| (home, whole.clone())));
            }
            let is_reexport = matches!(mention.kind, Kind::Import { is_reexport: true, .. });
            for (home, name) in homes {
                let (from, to) = (module.file, tree.modules[home].file);
                let is_below = tree.ancestors(home).any(|above| above == place);
                if from == to || is_reexport && is_below {
                    continue;
                }
                let lines = arrows.entry((from, to)).or_default();
                if lines.iter().all(|(_, known)| *known != name) {
                    lines.push((mention.line, name));
                }
            }
        }
    }
    arrows
}

/// What an item mentions; `Self` stands for the type it is.
fn mentions_of(item: &Item) -> Vec<Mention> {
    let mut mentions = Mentions::of(|mentions| mentions.visit_item(item));
    if let Item::Impl(block) = item
        && let Some(path) = type_path(&block.self_ty)
    {
        for mention in mentions.iter_mut().filter(|mention| mention.path[0] == "Self") {
            mention.path.splice(..1, path.iter().cloned());
        }
    }
    mentions
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The circles of a crate with these files below src/.
    fn circles(files: &[(&str, &str)]) -> Vec<String> {
        let read = |path: &Path| {
            let found = files.iter().find(|(name, _)| path == Path::new("src").join(name));
            found.map(|(_, text)| (*text).to_owned())
        };
        circles_of(&Crate::read(Path::new("src/lib.rs"), &read).unwrap())
    }

    #[test]
    fn two_files_that_use_each_other_are_a_circle_and_each_arrow_is_named() {
        let found = circles(&[
            ("lib.rs", "mod a; mod b;"),
            ("a.rs", "use crate::b::B;\npub struct A;"),
            ("b.rs", "pub struct B;\n\nfn f() -> super::a::A { todo!() }"),
        ]);
        let [circle] = &found[..] else { panic!("{found:?}") };
        for part in ["2 files in", "src/a.rs -> src/b.rs: B (line 1)", "src/b.rs -> src/a.rs: A (line 3)"] {
            assert!(circle.contains(part), "{circle}");
        }
    }

    #[test]
    fn a_family_may_use_each_other_up_and_down() {
        let files = [
            ("lib.rs", "mod a;"),
            ("a.rs", "mod b; mod c; pub use b::B; pub struct A; fn f() -> c::C {}"),
            ("a/b.rs", "pub struct B; fn f(_: super::A) {}"),
            ("a/c.rs", "use super::{A, B}; pub struct C;"),
        ];
        assert!(circles(&files).is_empty());
        let sister = [files[0], files[1], ("a/b.rs", "use super::c::C; pub struct B;"), files[3]];
        assert_eq!(circles(&sister).len(), 1, "through the parent's re-export and back");
    }

    #[test]
    fn a_circle_through_families_is_found_whichever_way_it_goes() {
        // From o to a, down to b and back; from o to b, up to a and back; and up in one family, down in the other.
        for (a, b, o, p, files) in [
            (
                "mod b; pub fn f() { b::g() }",
                "pub fn g() { crate::o::h() }",
                "mod p; pub fn h() { crate::a::f() }",
                "",
                3,
            ),
            (
                "pub mod b; pub fn f() { crate::o::h() }",
                "pub fn g() { super::f() }",
                "mod p; pub fn h() { crate::a::b::g() }",
                "",
                3,
            ),
            (
                "mod b; pub fn f() { b::g() }",
                "pub fn g() { crate::o::p::i() }",
                "pub mod p; pub fn h() { crate::a::f() }",
                "pub fn i() { super::h() }",
                4,
            ),
        ] {
            let found = circles(&[("lib.rs", "mod a; mod o;"), ("a.rs", a), ("a/b.rs", b), ("o.rs", o), ("o/p.rs", p)]);
            let [circle] = &found[..] else { panic!("{found:?}") };
            assert!(circle.starts_with(&format!("{files} files in a circle through src/a.rs, src/o.rs")), "{circle}");
        }
    }

    #[test]
    fn a_circle_is_found_through_globs_functions_of_types_and_macros() {
        for b in [
            "use crate::a::*; fn f(_: A) {}",
            "fn f() { g!(crate::a::A) }",
            "use crate::a; fn f() { a::A::new() }",
            "struct C; #[derive(serde)] struct D { #[serde(with = \"crate::a::form\")] e: C }",
        ] {
            let a = "use crate::b::B; pub struct A; fn form() {}";
            assert_eq!(
                circles(&[("lib.rs", "mod a; mod b;"), ("a.rs", a), ("b.rs", &format!("{b} struct B;"))]).len(),
                1,
                "{b}"
            );
        }
        // What a type does may stand apart from it.
        let files = [
            ("lib.rs", "mod a; mod b; mod c;"),
            ("a.rs", "pub struct A;"),
            ("b.rs", "impl crate::a::A { pub fn new() -> Self { crate::c::f() } }"),
            ("c.rs", "use crate::a::A; pub fn f() { A::new(); }"),
        ];
        assert_eq!(circles(&files).len(), 1);
    }

    #[test]
    fn what_tests_use_makes_no_circle() {
        let a = "use crate::b::B; #[cfg(test)] mod tests { }";
        let b = "pub struct B; #[cfg(test)] use crate::a::A;";
        assert!(circles(&[("lib.rs", "mod a; mod b;"), ("a.rs", a), ("b.rs", b)]).is_empty());
    }
}
