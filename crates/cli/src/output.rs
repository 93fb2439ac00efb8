//! Where a command writes: looked at before the work begins, so that nothing is computed for a place that cannot be.

mod kept;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use zerorate_cal::source::whole_file::write_whole;

pub use kept::Force;

/// Refuses a place without a folder, a folder in a file's place, and the place of something that the command reads.
pub fn check(option: &str, path: &Path, inputs: &[&Path]) -> Result<()> {
    let shown = path.display();
    let folder = folder_of(path);
    match fs::metadata(folder) {
        Ok(found) => ensure!(
            found.is_dir(),
            "{option} {shown}: {} is a file, not a folder: give another place",
            folder.display()
        ),
        Err(_) => bail!(
            "{option} {shown}: there is no folder {}: make it first (mkdir -p {}), or give another place",
            folder.display(),
            argument(folder)
        ),
    }
    ensure!(!path.is_dir(), "{option} {shown}: this is a folder: give the name of a file in it");
    for input in inputs {
        let same = fs::canonicalize(path).ok().zip(fs::canonicalize(input).ok()).is_some_and(|(a, b)| a == b);
        ensure!(!same, "{option} {shown}: this is the file that is read, and it would be lost: give another place");
    }
    Ok(())
}

/// Looks at all places of a command that writes to several, an option each: each as [`check`] does, and no two are one.
pub fn check_all(places: &[(&str, Option<&Path>)], inputs: &[&Path]) -> Result<()> {
    let mut seen: Vec<(&str, PathBuf)> = Vec::new();
    for (option, path) in places.iter().filter_map(|(option, path)| Some((*option, (*path)?))) {
        check(option, path, inputs)?;
        let file = file(path);
        if let Some((first, _)) = seen.iter().find(|(_, other)| *other == file && !is_device(path)) {
            bail!("{first} and {option} are one file, {}, and one would be lost: give each its own", path.display());
        }
        seen.push((option, file));
    }
    Ok(())
}

/// Which file a path is, whether it is there or not; its folder is.
fn file(path: &Path) -> PathBuf {
    let folder =
        || fs::canonicalize(folder_of(path)).ok().zip(path.file_name()).map(|(folder, name)| folder.join(name));
    fs::canonicalize(path).ok().or_else(folder).unwrap_or_else(|| path.to_owned())
}

/// Whether all that is written there is gone, or goes on, as in `/dev/null` and a pipe.
fn is_device(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|there| !there.is_file())
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Writes a text whole or not at all.
pub fn write(path: &Path, text: &str) -> Result<()> {
    write_bytes(path, text.as_bytes())
}

/// Writes bytes whole or not at all.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    write_whole(path, bytes)
        .with_context(|| format!("{}: cannot be written, and what was there before is as it was", path.display()))
}

/// A path as it is typed in a shell.
pub fn argument(path: &Path) -> String {
    let text = path.display().to_string();
    // What begins with a hyphen would be taken for an option.
    let text = if text.starts_with('-') { format!("./{text}") } else { text };
    word(&text)
}

/// Any word as it is typed in a shell.
pub fn word(text: &str) -> String {
    let plain = |letter: char| letter.is_alphanumeric() || "/._-+=:,@%".contains(letter);
    let is_plain = !text.is_empty() && text.chars().all(plain);
    if is_plain { text.to_owned() } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_with_a_space_is_quoted_for_the_shell() {
        assert_eq!(argument(Path::new("logs/a-1.csv")), "logs/a-1.csv");
        assert_eq!(argument(Path::new("my log.csv")), "'my log.csv'");
        assert_eq!(argument(Path::new("it's.csv")), r"'it'\''s.csv'");
        assert_eq!(argument(Path::new("-log.csv")), "./-log.csv");
        assert_eq!(word("--out"), "--out");
    }

    #[test]
    fn the_file_that_is_read_is_not_written_to_under_another_name_either() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("log.csv");
        fs::write(&log, "1,2\n").unwrap();
        let again = folder.path().join("./log.csv");
        assert!(check("--out", &again, &[&log]).unwrap_err().to_string().contains("would be lost"));
        assert!(check("--out", &folder.path().join("new.csv"), &[&log]).is_ok());
    }
}
