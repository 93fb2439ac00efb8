//! Where names are used.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::visit::Visit;
use syn::{ImplItem, Item};

use super::definitions::{Definition, Kind};
use crate::syntax::{self, Mention, Mentions, Package, attributes_of, only_in_tests, type_path};

/// One use of a name.
#[derive(Debug)]
struct Use {
    path: PathBuf,
    how: How,
    /// The definitions that it stands within, by their places; one's own use of a name is none.
    within: Vec<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum How {
    /// `name`, where something of the name must be known in the file.
    Alone,
    /// The first part of a longer path.
    First,
    /// A part in the middle of a path.
    Middle,
    /// The last part of a path.
    Last,
    /// `value.name()`.
    Method,
    /// `use path::name`.
    Import,
    /// A word of another language.
    Word,
}

/// All uses, by name.
#[derive(Debug, Default)]
pub struct Uses {
    uses: BTreeMap<String, Vec<Use>>,
    /// The names that each file imports, and whether it imports all of something.
    imports: BTreeMap<PathBuf, (BTreeSet<String>, bool)>,
    /// The packages, for what is used where it cannot be known is another of the name.
    packages: Vec<Package>,
}

/// Whether a definition is used outside itself and outside what is in `unused`.
pub fn mentioned(uses: &Uses, definitions: &[Definition], place: usize, unused: &BTreeSet<usize>) -> bool {
    let sought = &definitions[place];
    let of_name = uses.uses.get(&sought.name).into_iter().flatten();
    let live = of_name.filter(|used| !used.within.iter().any(|around| *around == place || unused.contains(around)));
    live.filter(|used| used.how == How::Word || uses.can_reach(&used.path, &sought.path)).any(|used| {
        match (used.how, sought.kind) {
            (How::Word, _) => true,
            (How::Method | How::Middle, Kind::Part) | (How::Last, _) => true,
            (How::Middle, Kind::Type | Kind::Trait) | (How::Import, Kind::Trait) => true,
            (How::Alone, Kind::Value | Kind::Type | Kind::Trait) | (How::First, Kind::Type | Kind::Trait) => {
                uses.is_known(&used.path, sought)
            }
            _ => false,
        }
    })
}

impl Uses {
    /// None yet, between these packages.
    pub fn between(packages: Vec<Package>) -> Self {
        Self { packages, ..Self::default() }
    }

    /// Takes in a file.
    pub fn take(&mut self, path: &Path, items: &[Item], definitions: &[Definition]) {
        for item in items.iter().filter(|item| !only_in_tests(attributes_of(item))) {
            let of_item = |name: &str, owner: Option<&str>| {
                let is_it = |found: &Definition| found.name == name && found.owner.as_deref() == owner;
                let places = definitions.iter().enumerate().filter(|(_, found)| is_it(found));
                // A type's functions may stand in another file than the type.
                let places: Vec<usize> =
                    places.filter(|(_, found)| owner.is_none() || found.path == path).map(|(at, _)| at).collect();
                places
            };
            match item {
                Item::Mod(module) => {
                    module.content.iter().for_each(|(_, items)| self.take(path, items, definitions));
                }
                Item::Impl(block) => {
                    let owner = type_path(&block.self_ty).and_then(|path| path.last().cloned()).unwrap_or_default();
                    let within = of_item(&owner, None);
                    let head = Mentions::of(|mentions| {
                        mentions.visit_generics(&block.generics);
                        mentions.visit_type(&block.self_ty);
                        block.trait_.iter().for_each(|(_, path, _)| mentions.visit_path(path));
                    });
                    self.mentions(path, head, &within);
                    for part in &block.items {
                        let mentions = Mentions::of(|mentions| mentions.visit_impl_item(part));
                        let own = match part {
                            ImplItem::Fn(part) => of_item(&part.sig.ident.to_string(), Some(&owner)),
                            _ => Vec::new(),
                        };
                        self.mentions(path, mentions, &[&within[..], &own].concat());
                    }
                }
                item => {
                    let within = syntax::name_of(item).map_or_else(Vec::new, |name| of_item(&name, None));
                    let within: Vec<usize> = within.into_iter().filter(|&at| definitions[at].path == path).collect();
                    self.mentions(path, Mentions::of(|mentions| mentions.visit_item(item)), &within);
                }
            }
        }
    }

    /// Takes in the words of another language.
    pub fn take_words(&mut self, words: impl Iterator<Item = String>) {
        for word in words {
            self.push(word, Path::new(""), How::Word, &[]);
        }
    }

    fn mentions(&mut self, path: &Path, mentions: Vec<Mention>, within: &[usize]) {
        for Mention { path: mut names, kind, .. } in mentions {
            let Some(last) = names.pop() else { continue };
            match kind {
                syntax::Kind::Method => self.push(last, path, How::Method, within),
                syntax::Kind::Path => {
                    let is_alone = names.is_empty();
                    for (place, name) in names.into_iter().enumerate() {
                        self.push(name, path, if place == 0 { How::First } else { How::Middle }, within);
                    }
                    self.push(last, path, if is_alone { How::Alone } else { How::Last }, within);
                }
                syntax::Kind::Import { name, is_reexport } => {
                    let (imported, all) = self.imports.entry(path.to_owned()).or_default();
                    let Some(name) = name else {
                        *all = true;
                        continue;
                    };
                    // Under another name it is not found again.
                    let how = if name == last { How::Import } else { How::Last };
                    imported.insert(name);
                    if !is_reexport {
                        self.push(last, path, how, within);
                    }
                }
            }
        }
    }

    fn push(&mut self, name: String, path: &Path, how: How, within: &[usize]) {
        self.uses.entry(name).or_default().push(Use { path: path.to_owned(), how, within: within.to_vec() });
    }

    /// Whether the package of one file uses that of another.
    fn can_reach(&self, from: &Path, to: &Path) -> bool {
        let around = |path: &Path| {
            let around = self.packages.iter().filter(|package| path.starts_with(&package.folder));
            around.max_by_key(|package| package.folder.components().count())
        };
        match (around(from), around(to)) {
            (Some(from), Some(to)) => from.name == to.name || from.uses.contains(&to.name),
            _ => true,
        }
    }

    /// Whether a name alone can mean a definition in a file.
    fn is_known(&self, path: &Path, sought: &Definition) -> bool {
        path == sought.path || self.imports.get(path).is_some_and(|(names, all)| *all || names.contains(&sought.name))
    }
}
