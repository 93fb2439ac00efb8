//! A crate as the tree of its modules, each with the file that it stands in.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use syn::{Expr, ExprLit, Item, ItemMod, Lit, Meta};

use super::attributes::only_in_tests;

/// A module.
pub struct Module {
    /// Its name; none for the crate itself.
    pub name: String,
    /// Its file, by its place among those of the crate; several modules may share one.
    pub file: usize,
    /// The module around it, by its place in the crate.
    pub parent: Option<usize>,
    /// The modules within it, by their places in the crate.
    pub children: Vec<usize>,
    /// What it defines and imports, modules left out.
    pub items: Vec<Item>,
}

/// A library or a program.
pub struct Crate {
    /// Its files, from the root, the one it begins with first.
    pub files: Vec<PathBuf>,
    /// Its modules, parents before their children.
    pub modules: Vec<Module>,
}

impl Crate {
    /// Reads a crate from the file it begins with; `read` gives a file's text by its path from the root, or nothing for one
    /// that is missing.
    pub fn read(root: &Path, read: &dyn Fn(&Path) -> Option<String>) -> Result<Self> {
        let mut found = Self { files: Vec::new(), modules: Vec::new() };
        let folder = root.parent().unwrap_or(Path::new(""));
        found.file(root, folder, String::new(), None, read)?;
        Ok(found)
    }

    /// The modules around a module, from within outwards.
    pub fn ancestors(&self, module: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(self.modules[module].parent, |&parent| self.modules[parent].parent)
    }

    /// The file that declares the module that a file is.
    pub fn file_around(&self, file: usize) -> Option<usize> {
        let outermost = self.modules.iter().find(|module| module.file == file)?;
        Some(self.modules[outermost.parent?].file)
    }

    /// Takes in the module that a file is, whose children are in `folder`.
    fn file(
        &mut self,
        path: &Path,
        folder: &Path,
        name: String,
        parent: Option<usize>,
        read: &dyn Fn(&Path) -> Option<String>,
    ) -> Result<()> {
        let text = read(path).with_context(|| format!("{}: a module that is not there", path.display()))?;
        let syntax = syn::parse_file(&text)
            .with_context(|| format!("{}: cannot be read as Rust; `cargo check` says more", path.display()))?;
        self.files.push(path.to_owned());
        let file = self.files.len() - 1;
        self.module(syntax.items, file, folder, name, parent, read)
    }

    fn module(
        &mut self,
        items: Vec<Item>,
        file: usize,
        folder: &Path,
        name: String,
        parent: Option<usize>,
        read: &dyn Fn(&Path) -> Option<String>,
    ) -> Result<()> {
        let this = self.modules.len();
        if let Some(parent) = parent {
            self.modules[parent].children.push(this);
        }
        let (modules, items): (Vec<Item>, Vec<Item>) = items.into_iter().partition(|item| matches!(item, Item::Mod(_)));
        self.modules.push(Module { name, file, parent, children: Vec::new(), items });
        for module in modules {
            let Item::Mod(module) = module else { continue };
            if only_in_tests(&module.attrs) {
                continue;
            }
            let name = module.ident.to_string();
            let within = folder.join(&name);
            let elsewhere = path_attribute(&module);
            if let Some((_, items)) = module.content {
                self.module(items, file, &within, name, Some(this), read)?;
            } else if let Some(elsewhere) = elsewhere {
                let beside = self.files[file].parent().unwrap_or(Path::new(""));
                let path = without_dots(&beside.join(elsewhere));
                let folder = path.parent().unwrap_or(Path::new("")).to_owned();
                self.file(&path, &folder, name, Some(this), read)?;
            } else {
                let in_its_folder = within.join("mod.rs");
                let path = if read(&in_its_folder).is_some() { in_its_folder } else { within.with_extension("rs") };
                self.file(&path, &within, name, Some(this), read)?;
            }
        }
        Ok(())
    }
}

/// The file that `#[path = "..."]` names.
fn path_attribute(module: &ItemMod) -> Option<String> {
    module.attrs.iter().find_map(|attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("path") => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value()),
            _ => None,
        },
        _ => None,
    })
}

/// `fuzz/limits.rs` for `fuzz/fuzz_targets/../limits.rs`.
fn without_dots(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path {
        if part == ".." {
            plain.pop();
        } else if part != "." {
            plain.push(part);
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_are_found_in_files_in_folders_inline_and_where_an_attribute_says() {
        let read = |path: &Path| match path.to_str()? {
            "src/lib.rs" => Some("mod a;\nmod b;\n#[path = \"../c/d.rs\"] mod e;\n#[cfg(test)] mod tests;".to_owned()),
            "src/a.rs" => Some("mod f { mod g; }".to_owned()),
            "src/a/f/g.rs" | "src/b/mod.rs" | "c/d.rs" => Some("struct H;".to_owned()),
            _ => None,
        };
        let found = Crate::read(Path::new("src/lib.rs"), &read).unwrap();
        let files = ["src/lib.rs", "src/a.rs", "src/a/f/g.rs", "src/b/mod.rs", "c/d.rs"];
        assert_eq!(found.files, files.map(PathBuf::from));
        let names: Vec<&str> = found.modules.iter().map(|module| module.name.as_str()).collect();
        assert_eq!(names, ["", "a", "f", "g", "b", "e"]);
        assert_eq!(found.ancestors(3).collect::<Vec<_>>(), [2, 1, 0]);
        assert_eq!((found.file_around(2), found.file_around(0)), (Some(1), None));
        let missing = Crate::read(Path::new("src/a.rs"), &|_| Some("mod x;".to_owned()).filter(|_| false));
        assert!(missing.is_err_and(|error| error.to_string().contains("src/a.rs")));
    }
}
