//! The page that fits a log in a browser: its parts made one file, and tried in a browser.

mod trial;

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;

use crate::steps::Outcome;
use crate::targets;
use crate::workspace::Workspace;

pub use trial::check;

/// Where the page's parts are.
const PARTS: &str = "crates/web/page";

/// The report's style, which is the page's too.
const STYLE: &str = "crates/report/src/style.css";

/// Builds the page, and says where it is.
pub fn build_page(workspace: &Workspace) -> Result<Outcome> {
    let page = build(workspace)?;
    println!("    {}: {} kB; open it in a browser", page.display(), fs::metadata(&page)?.len() / 1000);
    Ok(Outcome::Passed)
}

/// Builds the page: one file.
fn build(workspace: &Workspace) -> Result<PathBuf> {
    let program = targets::page_program(workspace)?;
    let program = fs::read(&program).with_context(|| program.display().to_string())?;
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(&program)?;
    let part = |name: &str| workspace.read(format!("{PARTS}/{name}"));
    let parts = [
        ("style", workspace.read(STYLE)? + &part("page.css")?),
        ("worker", part("worker.js")?),
        ("script", part("page.js")?),
        ("wasm", BASE64_STANDARD.encode(packed.finish()?)),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    let page = workspace.target.join("web/zerorate.html");
    fs::create_dir_all(workspace.target.join("web"))?;
    fs::write(&page, assembled(part("page.html")?, &parts)?)?;
    Ok(page)
}

/// The page's frame with its parts in their places.
fn assembled(frame: String, parts: &[(&str, String)]) -> Result<String> {
    parts.iter().try_fold(frame, |page, (name, part)| {
        let place = format!("{{{name}}}");
        ensure!(page.contains(&place), "the page's frame has no place for {name}");
        // Where a script of ours ended early, the rest of it would be text.
        ensure!(!part.contains("</script"), "{name} has the end of a script in it");
        Ok(page.replace(&place, part))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_has_its_place_and_ends_no_script() {
        let part = |part: &str| [("script", part.to_owned())];
        let page = assembled("<script>{script}</script>".into(), &part("let a = {};"));
        assert_eq!(page.unwrap(), "<script>let a = {};</script>");
        assert!(assembled("<p></p>".into(), &part("")).is_err());
        assert!(assembled("{script}".into(), &part("'</script>'")).is_err());
    }
}
