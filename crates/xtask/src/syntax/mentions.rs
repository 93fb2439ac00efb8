//! The names that a piece of code mentions, with the lines they stand on.
//!
//! What a macro is given is no syntax yet: there every run of names with `::` between them is taken for a path. A string
//! that looks like a path is one in serde's attributes (`with = "form"`), and so is a name in the braces of a format.

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, ExprMethodCall, ImplItem, Item, ItemMod, ItemUse, Macro, Meta, Path, Stmt, UseTree, Visibility};

use super::attributes::{attributes_of, only_in_tests};

/// A name in the code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mention {
    /// `["crate", "fit", "Fit"]` for `crate::fit::Fit`.
    pub path: Vec<String>,
    /// Its line, from 1.
    pub line: usize,
    /// What it is there for.
    pub kind: Kind,
}

/// What a name is there for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    /// It stands for what it names.
    Path,
    /// Something is called by it, on a value: `value.name()`.
    Method,
    /// `use path as name`; no name for a glob.
    Import {
        /// What it is called here.
        name: Option<String>,
        /// Whether others see it too: `pub use`.
        is_reexport: bool,
    },
}

/// Collects mentions; what is for tests alone is left out, and so are modules within.
#[derive(Debug, Default)]
pub struct Mentions(Vec<Mention>);

impl Mentions {
    /// What `visit` goes through.
    pub fn of(visit: impl FnOnce(&mut Self)) -> Vec<Mention> {
        let mut mentions = Self::default();
        visit(&mut mentions);
        mentions.0
    }

    fn push(&mut self, path: Vec<String>, line: usize, kind: Kind) {
        self.0.push(Mention { path, line, kind });
    }

    fn import(&mut self, tree: &UseTree, mut path: Vec<String>, is_reexport: bool) {
        let (ident, name) = match tree {
            UseTree::Path(part) => {
                path.push(part.ident.to_string());
                return self.import(&part.tree, path, is_reexport);
            }
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.import(tree, path.clone(), is_reexport));
            }
            UseTree::Glob(glob) => {
                let line = glob.star_token.spans[0].start().line;
                return self.push(path, line, Kind::Import { name: None, is_reexport });
            }
            UseTree::Name(name) => (&name.ident, &name.ident),
            UseTree::Rename(rename) => (&rename.ident, &rename.rename),
        };
        let mut name = name.to_string();
        // `use fit::{self}` is `use fit`.
        if ident == "self" {
            name = path.last().cloned().unwrap_or_default();
        } else {
            path.push(ident.to_string());
        }
        self.push(path, ident.span().start().line, Kind::Import { name: Some(name), is_reexport });
    }

    /// What a macro is given.
    fn tokens(&mut self, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            at += 1;
            match token {
                TokenTree::Ident(first) => {
                    let mut path = vec![first.to_string()];
                    let is_method = at > 1 && is_point(&tokens[at - 2], '.');
                    while let [colon, other, TokenTree::Ident(next), ..] = &tokens[at..]
                        && is_point(colon, ':')
                        && is_point(other, ':')
                    {
                        path.push(next.to_string());
                        at += 3;
                    }
                    let is_called = || matches!(tokens.get(at), Some(TokenTree::Group(_)));
                    let line = first.span().start().line;
                    match is_method {
                        false => self.push(path, line, Kind::Path),
                        true if is_called() => self.push(path, line, Kind::Method),
                        true => {} // A field.
                    }
                }
                TokenTree::Group(group) => self.tokens(group.stream()),
                TokenTree::Literal(literal) => {
                    let line = literal.span().start().line;
                    names_in_braces(&literal.to_string()).for_each(|name| self.push(vec![name], line, Kind::Path));
                }
                TokenTree::Punct(_) => {}
            }
        }
    }

    /// The strings of an attribute that look like paths.
    fn strings(&mut self, tokens: TokenStream) {
        for token in tokens {
            match token {
                TokenTree::Group(group) => self.strings(group.stream()),
                TokenTree::Literal(literal) => {
                    let text = literal.to_string();
                    let path: Vec<String> = text.trim_matches('"').split("::").map(str::to_owned).collect();
                    if path.iter().all(|part| is_name(part)) {
                        self.push(path, literal.span().start().line, Kind::Path);
                    }
                }
                TokenTree::Ident(_) | TokenTree::Punct(_) => {}
            }
        }
    }
}

impl Visit<'_> for Mentions {
    fn visit_item(&mut self, item: &Item) {
        if !only_in_tests(attributes_of(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item(&mut self, item: &ImplItem) {
        let attributes = match item {
            ImplItem::Fn(it) => &it.attrs[..],
            ImplItem::Const(it) => &it.attrs,
            ImplItem::Type(it) => &it.attrs,
            ImplItem::Macro(it) => &it.attrs,
            _ => &[],
        };
        if !only_in_tests(attributes) {
            visit::visit_impl_item(self, item);
        }
    }

    fn visit_stmt(&mut self, statement: &Stmt) {
        let attributes = match statement {
            Stmt::Local(it) => &it.attrs[..],
            Stmt::Macro(it) => &it.attrs,
            _ => &[],
        };
        if !only_in_tests(attributes) {
            visit::visit_stmt(self, statement);
        }
    }

    fn visit_item_use(&mut self, item: &ItemUse) {
        self.import(&item.tree, Vec::new(), !matches!(item.vis, Visibility::Inherited));
    }

    // A module has its own names.
    fn visit_item_mod(&mut self, _: &ItemMod) {}

    // `pub(in crate::fit)` uses nothing.
    fn visit_visibility(&mut self, _: &Visibility) {}

    fn visit_path(&mut self, path: &Path) {
        let names = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        let line = path.segments.first().map_or(0, |segment| segment.ident.span().start().line);
        self.push(names, line, Kind::Path);
        visit::visit_path(self, path);
    }

    fn visit_expr_method_call(&mut self, call: &ExprMethodCall) {
        self.push(vec![call.method.to_string()], call.method.span().start().line, Kind::Method);
        visit::visit_expr_method_call(self, call);
    }

    fn visit_macro(&mut self, called: &Macro) {
        self.visit_path(&called.path);
        self.tokens(called.tokens.clone());
    }

    fn visit_attribute(&mut self, attribute: &Attribute) {
        if let Meta::List(list) = &attribute.meta
            && !list.path.is_ident("cfg")
        {
            self.tokens(list.tokens.clone());
            if list.path.is_ident("serde") {
                self.strings(list.tokens.clone());
            }
        }
    }
}

fn is_point(token: &TokenTree, point: char) -> bool {
    matches!(token, TokenTree::Punct(found) if found.as_char() == point)
}

fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '_') && text.chars().all(|c| c.is_alphanumeric() || c == '_')
}

/// The names in the braces of a format's text: `N` of `"{N} lines of {text:?}"`, and `text`.
fn names_in_braces(text: &str) -> impl Iterator<Item = String> {
    let after_brace = text.split('{').skip(1);
    let names = after_brace.map(|rest| rest.split(['}', ':']).next().unwrap_or_default());
    names.filter(|name| is_name(name)).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Vec<Mention> {
        let file = syn::parse_file(text).unwrap();
        Mentions::of(|mentions| mentions.visit_file(&file))
    }

    fn paths(text: &str) -> Vec<String> {
        of(text).iter().filter(|mention| mention.kind == Kind::Path).map(|mention| mention.path.join("::")).collect()
    }

    #[test]
    fn paths_are_found_in_types_expressions_macros_and_attributes() {
        assert_eq!(paths("fn f(x: a::B) -> c::D<e::F> { g::h(x) }"), ["a::B", "c::D", "e::F", "g::h", "x"]);
        assert_eq!(
            paths("const A: B = c!(d::e(f::G { h: i::J }), \"{K}\");"),
            ["B", "c", "d::e", "f::G", "h", "i::J", "K"]
        );
        assert!(paths("struct A { #[serde(with = \"b::c\")] d: D }").contains(&"b::c".to_owned()));
        assert!(paths("pub(in crate::a) fn f() {}").is_empty());
    }

    #[test]
    fn what_is_called_on_a_value_is_told_from_what_is_named() {
        let methods = |text: &str| -> Vec<String> {
            of(text)
                .into_iter()
                .filter(|mention| mention.kind == Kind::Method)
                .flat_map(|mention| mention.path)
                .collect()
        };
        assert_eq!(methods("fn f() { a.b(c.d()).e; g!(h.i(j.k)) }"), ["b", "d", "i"]);
    }

    #[test]
    fn imports_keep_the_name_they_have_here() {
        let found = of("pub use a::{self, b as c};\nuse d::*;");
        let import = |path: &[&str], line, name: Option<&str>, is_reexport| Mention {
            path: path.iter().map(|&part| part.to_owned()).collect(),
            line,
            kind: Kind::Import { name: name.map(str::to_owned), is_reexport },
        };
        let expected = [
            import(&["a"], 1, Some("a"), true),
            import(&["a", "b"], 1, Some("c"), true),
            import(&["d"], 2, None, false),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn what_is_for_tests_alone_is_not_read() {
        let text = "#[cfg(test)] use a::b; impl C { #[cfg(test)] fn d() { e() } } #[cfg(test)] mod tests { use f::g; }";
        assert_eq!(paths(text), ["C"]);
        assert_eq!(of(text).len(), 1);
    }
}
