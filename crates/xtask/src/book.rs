//! The book of `docs/book`: its commands are run and print what it shows, its reference is made from the program, and its links
//! lead somewhere.

mod pages;
mod reference;

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::cargo;
use crate::provide;
use crate::python;
use crate::steps::Outcome;
use crate::workspace::Workspace;
use pages::Page;

/// Where it is written.
const BOOK: &str = "docs/book";

/// What makes a site of it.
const MDBOOK: [&str; 2] = ["mdbook", "0.5.4"];

/// Runs the commands of every page, in order and in a folder of the page's own.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let book = prepared(workspace)?;
    let (programs, runs) = (workspace.target.join("book/programs"), workspace.target.join("book/runs"));
    let has_lot = put_programs(workspace, &programs)?;
    let examples = workspace.target.join("book/examples");
    emptied(&examples)?;
    python::run(workspace, &[&workspace.root.join(python::SCRIPTS).join("example_logs.py"), &examples])?;
    emptied(&runs)?;
    let mut left_out = 0;
    for page in Page::all(&book.join("src"))? {
        page.check_links(&book.join("src"))?;
        let folder = runs.join(page.name.replace('/', "-"));
        fs::create_dir(&folder).with_context(|| folder.display().to_string())?;
        for log in fs::read_dir(&examples)? {
            let log = log?;
            fs::copy(log.path(), folder.join(log.file_name()))?;
        }
        let (run, left) = page.run(&folder, &programs, has_lot)?;
        left_out += left;
        if run > 0 {
            println!("    {}: {run} commands print what it shows", page.name);
        }
    }
    if left_out > 0 {
        println!(
            "    {left_out} commands of zerorate-lot were not run: it is not built (`cargo build -p zerorate-lot` does)"
        );
    }
    Ok(Outcome::Passed)
}

/// Makes a site of it.
pub fn build(workspace: &Workspace) -> Result<Outcome> {
    let book = prepared(workspace)?;
    let tools = workspace.target.join("tools");
    let mdbook = tools.join("bin").join(format!("{}{}", MDBOOK[0], env::consts::EXE_SUFFIX));
    if !mdbook.is_file() {
        println!("    installing {} {} to {}", MDBOOK[0], MDBOOK[1], tools.display());
        let install = ["install", MDBOOK[0], "--version", MDBOOK[1], "--locked", "--quiet", "--root"];
        provide::succeed(cargo::program().args(install).arg(&tools))?;
    }
    let site = workspace.target.join("book/site");
    provide::succeed(
        Command::new(mdbook).arg("build").arg(&book).arg("--dest-dir").arg(site.canonicalize().unwrap_or(site.clone())),
    )?;
    println!("    {}", site.join("index.html").display());
    Ok(Outcome::Passed)
}

/// The book as it is written, with its reference beside it, in a folder of its own.
fn prepared(workspace: &Workspace) -> Result<PathBuf> {
    let book = workspace.target.join("book/source");
    emptied(&book)?;
    for file in workspace.files(BOOK)? {
        let to = book.join(file.strip_prefix(BOOK)?);
        fs::create_dir_all(to.parent().context("a file without a folder")?)?;
        fs::copy(workspace.root.join(&file), &to).with_context(|| file.display().to_string())?;
    }
    let reference = book.join("src/reference");
    fs::create_dir_all(&reference)?;
    fs::write(reference.join("commands.md"), reference::commands(&workspace.zerorate()?)?)?;
    fs::write(reference.join("forms.md"), reference::forms(workspace)?)?;
    Ok(book)
}

/// The built programs in a folder alone; whether zerorate-lot is among them, which the tests have built.
fn put_programs(workspace: &Workspace, folder: &Path) -> Result<bool> {
    emptied(folder)?;
    let lot = workspace.target.join("debug").join(format!("zerorate-lot{}", env::consts::EXE_SUFFIX));
    let has_lot = lot.is_file();
    for program in [workspace.zerorate()?].into_iter().chain(has_lot.then_some(lot)) {
        let name = program.file_name().context("a program without a name")?;
        fs::copy(&program, folder.join(name)).with_context(|| program.display().to_string())?;
    }
    Ok(has_lot)
}

fn emptied(folder: &Path) -> Result<()> {
    if folder.is_dir() {
        fs::remove_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())
}
