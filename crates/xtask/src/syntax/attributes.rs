//! What the attributes of an item say of it.

use proc_macro2::{TokenStream, TokenTree};
use syn::{Attribute, Item, Meta};

/// The attributes of an item.
pub fn attributes_of(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(it) => &it.attrs,
        Item::Enum(it) => &it.attrs,
        Item::ExternCrate(it) => &it.attrs,
        Item::Fn(it) => &it.attrs,
        Item::ForeignMod(it) => &it.attrs,
        Item::Impl(it) => &it.attrs,
        Item::Macro(it) => &it.attrs,
        Item::Mod(it) => &it.attrs,
        Item::Static(it) => &it.attrs,
        Item::Struct(it) => &it.attrs,
        Item::Trait(it) => &it.attrs,
        Item::TraitAlias(it) => &it.attrs,
        Item::Type(it) => &it.attrs,
        Item::Union(it) => &it.attrs,
        Item::Use(it) => &it.attrs,
        _ => &[],
    }
}

/// Whether what bears these attributes is compiled for tests alone: `cfg(test)`, `cfg(all(test, unix))`, not
/// `cfg(any(test, unix))`.
pub fn only_in_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) if list.path.is_ident("cfg") => needs_test(list.tokens.clone()),
        meta => meta.path().is_ident("test"),
    })
}

/// Whether a condition of `cfg` holds in tests only.
fn needs_test(condition: TokenStream) -> bool {
    let mut tokens = condition.into_iter();
    let Some(TokenTree::Ident(word)) = tokens.next() else { return false };
    let Some(TokenTree::Group(inner)) = tokens.next() else { return word == "test" };
    let mut parts = conditions(inner.stream()).into_iter();
    match word.to_string().as_str() {
        "all" => parts.any(needs_test),
        "any" => parts.all(needs_test),
        _ => false,
    }
}

/// The conditions that stand between commas.
fn conditions(list: TokenStream) -> Vec<TokenStream> {
    let mut parts = vec![TokenStream::new()];
    for token in list {
        match (&token, parts.last_mut()) {
            (TokenTree::Punct(comma), _) if comma.as_char() == ',' => parts.push(TokenStream::new()),
            (_, Some(part)) => part.extend([token]),
            (_, None) => {}
        }
    }
    parts.retain(|part| !part.is_empty());
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_for_tests_alone_is_told_from_what_is_for_tests_too() {
        let is_for_tests = |text: &str| only_in_tests(attributes_of(&syn::parse_str(text).unwrap()));
        for text in ["#[cfg(test)] mod a {}", "#[cfg(all(test, unix))] use a;", "#[test] fn a() {}"] {
            assert!(is_for_tests(text), "{text}");
        }
        for text in ["#[cfg(not(test))] fn a() {}", "#[cfg(any(test, unix))] fn a() {}", "#[cfg(unix)] fn a() {}"] {
            assert!(!is_for_tests(text), "{text}");
        }
    }
}
