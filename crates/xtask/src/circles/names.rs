//! What a path means in a module of its crate: re-exports are followed to where a thing is defined.

use std::collections::{BTreeMap, BTreeSet};

use syn::{ImplItem, Item};

use crate::syntax::{Crate, Kind, Mention, attributes_of, name_of, only_in_tests, type_path};

/// A thing: the module that defines it, and its name there.
pub type Thing = (usize, String);

/// The names of one module.
#[derive(Default)]
struct Scope {
    own: BTreeSet<String>,
    modules: BTreeMap<String, usize>,
    imports: BTreeMap<String, Vec<Vec<String>>>,
    globs: Vec<Vec<String>>,
}

/// What a path leads to.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// A module.
    pub module: Option<usize>,
    /// A thing that is no module; a name can be both.
    pub thing: Option<Thing>,
    /// What of that thing, where the path goes on: a variant, a function of a type.
    pub part: Option<String>,
}

/// The names of a crate.
pub struct Names<'a> {
    tree: &'a Crate,
    scopes: Vec<Scope>,
    /// The modules in which a type has functions of a name.
    parts: BTreeMap<(Thing, String), Vec<usize>>,
}

impl<'a> Names<'a> {
    /// The names of a crate, by the mentions in each of its modules.
    pub fn of(tree: &'a Crate, mentions: &[Vec<Mention>]) -> Self {
        let scopes = tree.modules.iter().zip(mentions).map(|(module, mentions)| {
            let children = module.children.iter().map(|&child| (tree.modules[child].name.clone(), child));
            let own = module.items.iter().filter(|item| !only_in_tests(attributes_of(item))).filter_map(name_of);
            let mut scope = Scope { own: own.collect(), modules: children.collect(), ..Scope::default() };
            for mention in mentions {
                match &mention.kind {
                    Kind::Import { name: Some(name), .. } => {
                        scope.imports.entry(name.clone()).or_default().push(mention.path.clone());
                    }
                    Kind::Import { name: None, .. } => scope.globs.push(mention.path.clone()),
                    Kind::Path | Kind::Method => {}
                }
            }
            scope
        });
        let mut names = Self { tree, scopes: scopes.collect(), parts: BTreeMap::new() };
        for (place, module) in tree.modules.iter().enumerate() {
            for item in &module.items {
                names.take_parts(place, item);
            }
        }
        names
    }

    /// What a path means in a module.
    pub fn resolve(&self, module: usize, path: &[String]) -> Found {
        self.follow(module, path, &mut BTreeSet::new())
    }

    /// The modules in which a type's function of this name is; usually one.
    pub fn places_of(&self, thing: &Thing, part: &str) -> &[usize] {
        self.parts.get(&(thing.clone(), part.to_owned())).map_or(&[], Vec::as_slice)
    }

    /// Notes where the functions of a type are.
    fn take_parts(&mut self, place: usize, item: &Item) {
        let Item::Impl(block) = item else { return };
        let Some(path) = type_path(&block.self_ty) else { return };
        if block.trait_.is_some() || only_in_tests(&block.attrs) {
            return;
        }
        let Some(thing) = self.resolve(place, &path).thing else { return };
        for part in &block.items {
            let name = match part {
                ImplItem::Fn(it) if !only_in_tests(&it.attrs) => it.sig.ident.to_string(),
                ImplItem::Const(it) => it.ident.to_string(),
                _ => continue,
            };
            self.parts.entry((thing.clone(), name)).or_default().push(place);
        }
    }

    fn follow(&self, module: usize, path: &[String], seen: &mut BTreeSet<Thing>) -> Found {
        let mut found = Found { module: Some(module), ..Found::default() };
        for (place, part) in path.iter().enumerate() {
            let Some(here) = found.module else {
                // Beyond a thing is a part of it, beyond what is not ours nothing.
                found.part = found.thing.is_some().then(|| part.clone());
                return found;
            };
            found = match part.as_str() {
                "crate" if place == 0 => Found { module: Some(0), ..Found::default() },
                "self" => Found { module: Some(here), ..Found::default() },
                "super" => Found { module: self.tree.modules[here].parent, ..Found::default() },
                name => self.lookup(here, name, seen),
            };
            // A name that is a module and a function: the module, where the path goes on.
            if place + 1 < path.len() && found.module.is_some() {
                found.thing = None;
            }
        }
        found
    }

    fn lookup(&self, module: usize, name: &str, seen: &mut BTreeSet<Thing>) -> Found {
        let thing = (module, name.to_owned());
        if !seen.insert(thing.clone()) {
            return Found::default();
        }
        let scope = &self.scopes[module];
        let mut found = Found { module: scope.modules.get(name).copied(), ..Found::default() };
        if scope.own.contains(name) {
            found.thing = Some(thing);
            return found;
        }
        for path in scope.imports.get(name).into_iter().flatten() {
            found.take(self.follow(module, path, seen));
        }
        if found == Found::default() {
            for path in &scope.globs {
                let Some(there) = self.follow(module, path, seen).module.filter(|there| *there != module) else {
                    continue;
                };
                found.take(self.lookup(there, name, seen));
            }
        }
        found
    }
}

impl Found {
    fn take(&mut self, other: Self) {
        self.module = self.module.or(other.module);
        if self.thing.is_none() {
            (self.thing, self.part) = (other.thing, other.part);
        }
    }
}
