//! Puts the files of a run in their folder's place by one rename, so that whoever looks there sees one run or the other.
//!
//! The whole set is made in a folder beside. Then the folder that is there is moved aside, the new one into its place, and
//! what else there was, a user's own files, back from the one to the other. A process that is killed in between leaves
//! every set whole and every file somewhere; [`recover`] finishes what it began.
//!
//! A folder that cannot be moved (a mounted one, one whose parent cannot be written, the one that we are in) gets its files
//! one by one, and they stay whole in the run's own folder until the last is there.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::IN_PROGRESS;
use crate::checkpoint::forget;

/// How the name of a folder ends in which a set is made.
const NEXT: &str = "next";
/// How the name of a folder ends that was moved aside.
const EARLIER: &str = "earlier";

/// Asked before every change of the disk, so that a test can end everything there.
pub(super) type Moment<'a> = &'a mut dyn FnMut() -> io::Result<()>;

/// Puts the files of the run in `folder`/in-progress in their places in `folder`. Returns the folder where something else
/// that was there is now, if it could not be moved back.
pub(super) fn publish(folder: &Path, files: &[&str], at: Moment) -> io::Result<Option<PathBuf>> {
    let folder = fs::canonicalize(folder)?;
    match beside(&folder, files, at) {
        // The set is in its place, whatever becomes of the earlier folder. The next run tries again.
        Ok(Some(earlier)) => Ok(settle(&earlier, &folder, at).is_err().then_some(earlier)),
        Ok(None) | Err(_) => one_by_one(&folder, files, at).map(|()| None),
    }
}

/// Finishes what a process that was killed had begun.
pub(super) fn recover(folder: &Path, at: Moment) -> io::Result<()> {
    let folder = absolute(folder);
    for next in siblings(&folder, NEXT)? {
        if folder.exists() {
            // It had not come so far: the run's own folder has all of it.
            remove_known(&next, &folder.join(IN_PROGRESS), at)?;
        } else if next.with_extension(EARLIER).is_dir() {
            // The earlier one is moved aside only when this is whole.
            at()?;
            fs::rename(&next, &folder)?;
        }
    }
    for earlier in siblings(&folder, EARLIER)? {
        if folder.exists() {
            // What cannot be moved was told of when it could not be the first time; it is in no run's way.
            let _ = settle(&earlier, &folder, at);
        } else {
            at()?;
            fs::rename(&earlier, &folder)?;
        }
    }
    Ok(())
}

/// Makes the set in a folder beside and puts that in place; returns where the earlier folder is then, or nothing where no
/// folder can be moved.
fn beside(folder: &Path, files: &[&str], at: Moment) -> io::Result<Option<PathBuf>> {
    let (Some(next), Some(earlier)) = (sibling(folder, NEXT), sibling(folder, EARLIER)) else { return Ok(None) };
    // Whoever is in it would be in a folder that is gone.
    if std::env::current_dir().and_then(fs::canonicalize).is_ok_and(|here| here.starts_with(folder)) {
        return Ok(None);
    }
    at()?;
    fs::create_dir(&next)?;
    let made = make(folder, &next, files, at).and_then(|()| {
        at()?;
        fs::rename(folder, &earlier)?;
        at().and_then(|()| fs::rename(&next, folder)).inspect_err(|_| {
            // If it cannot go back either, `recover` finds both.
            let _ = at().and_then(|()| fs::rename(&earlier, folder));
        })
    });
    if made.is_err() {
        let _ = remove_known(&next, &folder.join(IN_PROGRESS), at);
    }
    made.map(|()| Some(earlier))
}

/// The whole set in the folder `next`, and on the disk.
fn make(folder: &Path, next: &Path, files: &[&str], at: Moment) -> io::Result<()> {
    let in_progress = folder.join(IN_PROGRESS);
    for file in files {
        let (from, to) = (in_progress.join(file), next.join(file));
        at()?;
        // No second copy where the file system can do without.
        fs::hard_link(&from, &to).or_else(|_| fs::copy(&from, &to).map(drop))?;
        // A rename can reach the disk before the contents do.
        File::open(&to)?.sync_all()?;
    }
    fs::set_permissions(next, fs::metadata(folder)?.permissions())
}

/// Takes what only the earlier folder has over into the new one, and removes the earlier.
fn settle(earlier: &Path, folder: &Path, at: Moment) -> io::Result<()> {
    let run = earlier.join(IN_PROGRESS);
    if run.is_dir() {
        clear(&run, folder, at)?;
    }
    let mut failed = Ok(());
    for entry in fs::read_dir(earlier)? {
        let entry = entry?;
        let to = folder.join(entry.file_name());
        let is_folder = entry.file_type()?.is_dir();
        at()?;
        if fs::symlink_metadata(&to).is_err() {
            // One that cannot be moved (somebody else's folder) keeps no other from it.
            failed = failed.and(fs::rename(entry.path(), &to));
        } else if !is_folder {
            fs::remove_file(entry.path())?;
        }
    }
    failed?;
    at()?;
    fs::remove_dir(earlier)
}

/// Takes out of a run's own folder what is in place now, and what was kept to go on with; removes it if that is all. What
/// is left over from a run that was cut is not ours to throw away.
fn clear(run: &Path, folder: &Path, at: Moment) -> io::Result<()> {
    at()?;
    forget(run);
    remove_known(run, folder, at)
}

/// Removes the files that another folder has too, and the folder if nothing else is in it.
fn remove_known(folder: &Path, other: &Path, at: Moment) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_file() && other.join(entry.file_name()).is_file() {
            at()?;
            fs::remove_file(entry.path())?;
        }
    }
    at()?;
    // With something in it, it stays.
    let _ = fs::remove_dir(folder);
    Ok(())
}

/// Each file into its place by a rename of its own.
fn one_by_one(folder: &Path, files: &[&str], at: Moment) -> io::Result<()> {
    let run = folder.join(IN_PROGRESS);
    for file in files {
        let (from, to) = (run.join(file), folder.join(file));
        let second = folder.join(format!("{file}.{}.partial", std::process::id()));
        at()?;
        // A second name, so that the run's own folder has all of them until the last is in place.
        match fs::hard_link(&from, &second) {
            Ok(()) => {
                at()?;
                fs::rename(&second, &to)?;
            }
            Err(_) => fs::rename(&from, &to)?,
        }
    }
    clear(&run, folder, at)
}

/// `calibration.4711.next` beside `calibration`, 4711 being our process.
fn sibling(folder: &Path, end: &str) -> Option<PathBuf> {
    let name = folder.file_name()?.to_str()?;
    Some(folder.with_file_name(format!("{name}.{}.{end}", std::process::id())))
}

/// The folders of such names, of any process.
fn siblings(folder: &Path, end: &str) -> io::Result<Vec<PathBuf>> {
    let (Some(parent), Some(name)) = (folder.parent(), folder.file_name().and_then(OsStr::to_str)) else {
        return Ok(Vec::new());
    };
    let is_one = |found: OsString| {
        let number = found.to_str()?.strip_prefix(name)?.strip_prefix('.')?.strip_suffix(end)?.strip_suffix('.')?;
        (!number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())).then_some(())
    };
    let Ok(entries) = fs::read_dir(parent) else { return Ok(Vec::new()) };
    let mut found = Vec::new();
    for entry in entries {
        let entry = entry?;
        if entry.file_type()?.is_dir() && is_one(entry.file_name()).is_some() {
            found.push(entry.path());
        }
    }
    found.sort();
    Ok(found)
}

/// The folder's true path, whether it is there or not.
fn absolute(folder: &Path) -> PathBuf {
    fs::canonicalize(folder).or_else(|_| std::path::absolute(folder)).unwrap_or_else(|_| folder.to_owned())
}

#[cfg(test)]
mod tests;
