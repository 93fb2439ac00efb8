//! The public names that a file defines.

use std::path::{Path, PathBuf};

use proc_macro2::{Ident, TokenTree};
use syn::{Attribute, ImplItem, Item, Meta, TraitItem, Visibility};

use crate::syntax::{attributes_of, only_in_tests, type_path};

/// What a name is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A function, a constant, a static: the last part of a path.
    Value,
    /// A type: any part of a path.
    Type,
    /// A trait: it can be used by being imported.
    Trait,
    /// A function or constant of a type or a trait.
    Part,
}

/// A public name.
#[derive(Debug)]
pub struct Definition {
    /// The name.
    pub name: String,
    /// What it is.
    pub kind: Kind,
    /// The type or trait whose part it is.
    pub owner: Option<String>,
    /// Where it stands, from the root.
    pub path: PathBuf,
    /// On which line.
    pub line: usize,
}

impl Definition {
    /// `Fit::new`, `median`.
    pub fn full_name(&self) -> String {
        self.owner.iter().chain([&self.name]).cloned().collect::<Vec<_>>().join("::")
    }

    /// Whether it is the one that a path and a name mean.
    pub fn is(&self, path: &str, full_name: &str) -> bool {
        self.path == Path::new(path) && self.full_name() == full_name
    }
}

/// The public names that items define; what is for tests alone is left out, and so is what C calls.
pub fn definitions(path: &Path, items: &[Item]) -> Vec<Definition> {
    let mut found = Vec::new();
    for item in items.iter().filter(|item| !only_in_tests(attributes_of(item)) && !is_for_c(attributes_of(item))) {
        let mut push = |name: &Ident, kind, owner: Option<&str>| {
            let line = name.span().start().line;
            let owner = owner.map(str::to_owned);
            found.push(Definition { name: name.to_string(), kind, owner, path: path.to_owned(), line });
        };
        let is_public = |visibility: &Visibility| matches!(visibility, Visibility::Public(_));
        match item {
            Item::Const(it) if is_public(&it.vis) => push(&it.ident, Kind::Value, None),
            Item::Fn(it) if is_public(&it.vis) => push(&it.sig.ident, Kind::Value, None),
            Item::Static(it) if is_public(&it.vis) => push(&it.ident, Kind::Value, None),
            Item::Enum(it) if is_public(&it.vis) => push(&it.ident, Kind::Type, None),
            Item::Struct(it) if is_public(&it.vis) => push(&it.ident, Kind::Type, None),
            Item::Type(it) if is_public(&it.vis) => push(&it.ident, Kind::Type, None),
            Item::Union(it) if is_public(&it.vis) => push(&it.ident, Kind::Type, None),
            Item::Trait(it) if is_public(&it.vis) => {
                push(&it.ident, Kind::Trait, None);
                for part in &it.items {
                    match part {
                        TraitItem::Fn(part) => push(&part.sig.ident, Kind::Part, Some(&it.ident.to_string())),
                        TraitItem::Const(part) => push(&part.ident, Kind::Part, Some(&it.ident.to_string())),
                        _ => {}
                    }
                }
            }
            Item::Impl(block) if block.trait_.is_none() => {
                let owner = type_path(&block.self_ty).and_then(|path| path.last().cloned()).unwrap_or_default();
                for part in &block.items {
                    match part {
                        ImplItem::Fn(part) if is_public(&part.vis) && !only_in_tests(&part.attrs) => {
                            push(&part.sig.ident, Kind::Part, Some(&owner));
                        }
                        ImplItem::Const(part) if is_public(&part.vis) => push(&part.ident, Kind::Part, Some(&owner)),
                        _ => {}
                    }
                }
            }
            Item::Mod(it) => {
                found.extend(it.content.iter().flat_map(|(_, items)| definitions(path, items)));
            }
            _ => {}
        }
    }
    found
}

/// Whether a name is kept as it is for a linker: `#[unsafe(no_mangle)]`.
fn is_for_c(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) => list
            .tokens
            .clone()
            .into_iter()
            .any(|token| matches!(token, TokenTree::Ident(word) if word == "no_mangle" || word == "export_name")),
        meta => meta.path().is_ident("no_mangle"),
    })
}
