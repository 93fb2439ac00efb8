//! Where things are: the workspace's folders and files.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::{env, fs};

use anyhow::{Context, Result};

/// The checked-out workspace.
pub struct Workspace {
    /// The folder with the workspace's Cargo.toml.
    pub root: PathBuf,
    /// Cargo's output folder.
    pub target: PathBuf,
}

impl Workspace {
    /// The workspace that cargo is running this program from.
    pub fn of_this_run() -> Result<Self> {
        let here = env::var_os("CARGO_MANIFEST_DIR").context("start this as `cargo xtask`")?;
        let root = Path::new(&here).ancestors().nth(2).context("xtask is expected in crates/xtask")?.to_owned();
        let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |target| root.join(target));
        Ok(Self { root, target })
    }

    /// The names of the folders in crates/, sorted.
    pub fn crates(&self) -> Result<Vec<String>> {
        let crates = self.root.join("crates");
        let mut names: Vec<String> = entries(&crates)?
            .into_iter()
            .filter(|path| path.join("Cargo.toml").is_file())
            .filter_map(|path| path.file_name()?.to_str().map(str::to_owned))
            .collect();
        names.sort();
        Ok(names)
    }

    /// A text file of the workspace, by its path from the root.
    pub fn read(&self, path: impl AsRef<Path>) -> Result<String> {
        let path = self.root.join(path);
        fs::read_to_string(&path).with_context(|| path.display().to_string())
    }

    /// The Rust sources below a folder, as path from the root and text.
    pub fn sources(&self, folder: impl AsRef<Path>) -> Result<Vec<(PathBuf, String)>> {
        let files = self.files(folder)?;
        let rust = files.into_iter().filter(|path| path.extension() == Some(OsStr::new("rs")));
        rust.map(|path| Ok((path.clone(), self.read(&path)?))).collect()
    }

    /// Every file below a folder that belongs to the project, as path from the root, sorted.
    ///
    /// Git is not asked: it may be missing where this runs.
    pub fn files(&self, folder: impl AsRef<Path>) -> Result<Vec<PathBuf>> {
        const MADE: [&str; 3] = [".git", "target", "__pycache__"];
        // `zerorate calibrate` writes it where it is called; a folder of sources may have the same name.
        let results = self.root.join("calibration");
        let mut found = Vec::new();
        let mut folders = vec![self.root.join(folder)];
        while let Some(folder) = folders.pop() {
            for path in entries(&folder)? {
                let name = path.file_name().unwrap_or_default();
                // In a worktree of git's, .git is a file.
                if path == results || MADE.iter().any(|made| name == *made) {
                    continue;
                }
                if path.is_dir() {
                    folders.push(path);
                } else if path.is_file() {
                    found.push(path.strip_prefix(&self.root)?.to_owned());
                }
            }
        }
        found.sort();
        Ok(found)
    }

    /// The built command, or why there is none.
    pub fn zerorate(&self) -> Result<PathBuf> {
        let path = self.target.join("release").join(format!("zerorate{}", env::consts::EXE_SUFFIX));
        anyhow::ensure!(path.is_file(), "{} is missing: `cargo build --release` makes it", path.display());
        Ok(path)
    }

    /// The recordings that are too large for the repository, where they are there: ../shared/data, or what
    /// ZERORATE_DATA names.
    pub fn data(&self) -> Option<PathBuf> {
        let folder = env::var_os("ZERORATE_DATA").map_or_else(|| self.root.join("../shared/data"), PathBuf::from);
        folder.is_dir().then_some(folder)
    }

    /// The recording of a real sensor through a chamber's cycle, where it is there.
    pub fn recording(&self) -> Option<PathBuf> {
        self.data().map(|data| data.join("imu-chamber-cycle/imu_raw_data.tsv")).filter(|recording| recording.is_file())
    }
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let named = || folder.display().to_string();
    fs::read_dir(folder).with_context(named)?.map(|entry| Ok(entry.with_context(named)?.path())).collect()
}
