//! The names of items and types.

use syn::{Item, Type};

/// The path of a type, references and the like looked through.
pub fn type_path(kind: &Type) -> Option<Vec<String>> {
    match kind {
        Type::Path(it) => Some(it.path.segments.iter().map(|segment| segment.ident.to_string()).collect()),
        Type::Reference(it) => type_path(&it.elem),
        Type::Paren(it) => type_path(&it.elem),
        _ => None,
    }
}

/// The name of what an item defines; none for a module.
pub fn name_of(item: &Item) -> Option<String> {
    Some(match item {
        Item::Const(it) => it.ident.to_string(),
        Item::Enum(it) => it.ident.to_string(),
        Item::Fn(it) => it.sig.ident.to_string(),
        Item::Macro(it) => it.ident.as_ref()?.to_string(),
        Item::Static(it) => it.ident.to_string(),
        Item::Struct(it) => it.ident.to_string(),
        Item::Trait(it) => it.ident.to_string(),
        Item::Type(it) => it.ident.to_string(),
        Item::Union(it) => it.ident.to_string(),
        _ => return None,
    })
}
