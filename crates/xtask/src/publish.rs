//! What would be published, as a registry would have it: packed, unpacked elsewhere, and built from nothing but that.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use toml::{Table, Value, toml};

use crate::cargo;
use crate::figures::{Comparison, Extent};
use crate::provide;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// The command, which people install.
const COMMAND: &str = "zerorate";

/// What a registry shows of a crate, beside its name and version.
const SHOWN: [&str; 6] = ["description", "license", "repository", "readme", "keywords", "categories"];

/// The driver and the readers of logs can be published alone.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    cargo::run(workspace, &["build", "--package", "max5494", "--no-default-features"])?;
    cargo::run(workspace, &["test", "--package", "max5494", "--all-features"])?;
    cargo::run(workspace, &["publish", "--dry-run", "--allow-dirty", "--package", "max5494", "--package", "imu-logs"])?;
    Ok(Outcome::Passed)
}

/// The command with all that it stands on can be installed from what would be published, and has the built command's figures to
/// the last digit. What others wrote is the built command's too, and not built again.
pub fn install(workspace: &Workspace) -> Result<Outcome> {
    let names = published(workspace)?;
    let mut package = vec!["package", "--quiet", "--no-verify", "--allow-dirty"];
    package.extend(names.iter().flat_map(|name| ["--package", name]));
    cargo::run(workspace, &package)?;
    let place = unpack(workspace, &names)?;
    println!("    cargo install zerorate, from what was packed");
    let mut install = cargo::program();
    cargo::share(workspace, &mut install, &workspace.target.join("installed"));
    install.current_dir(&place).args(["install", "--quiet", "--path", "zerorate", "--root", "."]);
    provide::succeed(&mut install)?;
    let (before, after) = (workspace.zerorate()?.canonicalize()?, place.join("bin/zerorate").canonicalize()?);
    Comparison { workspace, before, after, extent: Extent::Few, within: 0.0, held_out: false }.run()
}

/// The crates that are not kept from being published. Each tells a registry what it shows.
fn published(workspace: &Workspace) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for folder in workspace.crates()? {
        let path = format!("crates/{folder}/Cargo.toml");
        let manifest: Table = workspace.read(&path)?.parse().with_context(|| path.clone())?;
        let package =
            manifest.get("package").and_then(Value::as_table).with_context(|| format!("{path}: no package"))?;
        if package.get("publish").and_then(Value::as_bool) == Some(false) {
            continue;
        }
        for field in SHOWN {
            ensure!(package.contains_key(field), "{path}: `{field}` is missing, and a registry shows it");
        }
        names.push(package.get("name").and_then(Value::as_str).with_context(|| format!("{path}: no name"))?.to_owned());
    }
    Ok(names)
}

/// Unpacks all into one folder, and has the command take them where a registry would be asked.
fn unpack(workspace: &Workspace, names: &[String]) -> Result<PathBuf> {
    let packed = workspace.target.join("package");
    let place = packed.join("unpacked");
    if place.is_dir() {
        fs::remove_dir_all(&place)?;
    }
    fs::create_dir_all(&place)?;
    let mut patches = Table::new();
    for name in names {
        let folder = format!("{name}-{}", env!("CARGO_PKG_VERSION"));
        let archive = packed.join(format!("{folder}.crate"));
        // A packed file is of no time, and cargo would take what was built of the last packing for built of this one: with -m it
        // is of now.
        provide::succeed(Command::new("tar").arg("-xmzf").arg(archive).arg("-C").arg(&place))?;
        fs::rename(place.join(folder), place.join(name))?;
        if name != COMMAND {
            patches.insert(name.clone(), Table::from_iter([("path".to_owned(), name.as_str().into())]).into());
        }
    }
    let mut manifest = toml! { workspace = { resolver = "2", members = ["zerorate"] } };
    // Ours are optimised little: what is asked is whether all was packed, and no figure hangs on it.
    let little = names.iter().map(|name| (name.clone(), toml! { opt-level = 1 }.into()));
    let ours = Table::from_iter([("package".to_owned(), Table::from_iter(little).into())]);
    manifest.insert("profile".into(), Table::from_iter([("release".to_owned(), ours.into())]).into());
    manifest.insert("patch".into(), Table::from_iter([("crates-io".to_owned(), patches.into())]).into());
    fs::write(place.join("Cargo.toml"), manifest.to_string())?;
    // The same versions of what others wrote.
    fs::copy(workspace.root.join("Cargo.lock"), place.join("Cargo.lock"))?;
    Ok(place)
}
