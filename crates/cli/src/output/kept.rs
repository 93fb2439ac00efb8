//! What is there already where a command writes: kept, unless it is what the same command made of the same source before.
//!
//! A source is the same by its SHA-256. Where another of the same name was, it is most likely the user's own log, gone on: what
//! came of it is set aside, and the command goes on; so are the corrected rows of another log, which are quickly made
//! again and not quickly asked for. Whatever else is there is refused.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use zerorate_apply::apply::are_of_one_log;
use zerorate_cal::calibration::{Calibration, Origin};
use zerorate_cal::device_record::StoredRecord;

use crate::screen;

/// No page and no export is as large as this: what is there is something else.
const LARGEST_BYTES: u64 = 64 << 20;

/// Of a log of the same name: nothing tells one that has changed since from another.
const CHANGED: &str = "came of another log of this name, or of this one before it changed";

/// What is there.
enum There {
    /// What the same command made of the same source.
    Same,
    /// What it made before of something else, in words: it is set aside.
    Earlier(&'static str),
    /// Something else, in words.
    Other(String),
}

/// Whether what is there may go.
#[derive(Debug, Clone, Copy, Args)]
pub struct Force {
    /// Write over a file that came of another log or unit, or that zerorate has not written
    #[arg(long)]
    force: bool,
}

impl Force {
    /// Refuses the place of a calibration of other sources, or of another serial, or of no calibration.
    pub fn calibration(self, option: &str, path: &Path, sources: &[Origin], serial: Option<&str>) -> Result<()> {
        self.keep(option, path, || {
            let Ok(there) = Calibration::read(&path.into()) else { return There::Other("no calibration".into()) };
            let serials = there.unit_serial.as_deref().zip(serial);
            if let Some((own, _)) = serials.filter(|(own, new)| own != new) {
                return There::Other(format!("the calibration of unit {own}"));
            }
            if sorted(&there.sources, |source| &source.sha256) == sorted(sources, |source| &source.sha256) {
                There::Same
            } else if sorted(&there.sources, |source| &source.file) == sorted(sources, |source| &source.file) {
                There::Earlier(CHANGED)
            } else {
                There::Other(format!("the calibration of {}", named(&there.sources)))
            }
        })
    }

    /// Refuses the place of a page or an export, each of which names its sources by their SHA-256, of other sources, and
    /// of what zerorate has not written. Of an export that has nowhere to name them, `nameless`, only the same text is known.
    pub fn text(self, option: &str, path: &Path, sources: &[Origin], nameless: Option<&str>) -> Result<()> {
        self.keep(option, path, || {
            let there = text(path);
            if nameless.is_some() {
                let other = || There::Other("another table, which does not say what it came of".into());
                return if there.as_deref() == nameless { There::Same } else { other() };
            }
            if Calibration::read(&path.into()).is_ok() {
                return There::Other("a calibration".into());
            }
            let Some(text) = there.filter(|text| text.contains("zerorate")) else {
                return There::Other("something that zerorate has not written".into());
            };
            if sources.iter().all(|source| text.contains(&source.sha256)) {
                There::Same
            } else if sources.iter().all(|source| names(&text, &source.file)) {
                There::Earlier(CHANGED)
            } else {
                There::Other("what came of another source".into())
            }
        })
    }

    /// Refuses the place of what is not such a page already.
    pub fn page(self, option: &str, path: &Path, what: &str, is_one: impl Fn(&str) -> bool) -> Result<()> {
        self.keep(option, path, || match text(path) {
            Some(there) if is_one(&there) => There::Same,
            Some(_) | None => There::Other(format!("which is not {what}")),
        })
    }

    /// Refuses the place of another unit's device record, and of no device record.
    pub fn record(self, option: &str, path: &Path, unit: &str) -> Result<()> {
        self.keep(option, path, || match StoredRecord::read(&path.into()) {
            Ok(there) if there.record.unit.as_str() == unit => There::Same,
            Ok(there) if there.record.unit.as_str().is_empty() => {
                There::Other("the device record of another unit".into())
            }
            Ok(there) => There::Other(format!("the device record of unit {}", there.record.unit.as_str())),
            Err(_) => There::Other("no device record".into()),
        })
    }

    /// The same of what a board has stored, which may be all that is left of it: another one of this unit that was read before is set
    /// aside.
    pub fn backup(self, option: &str, path: &Path, unit: &str, new: &[u8]) -> Result<()> {
        self.record(option, path, unit)?;
        self.keep(option, path, || match fs::read(path) {
            Ok(there) if there == new => There::Same,
            _ => There::Earlier("is another calibration of this unit"),
        })
    }

    /// Refuses the place of anything: a recording that is there was recorded once.
    pub fn recording(self, option: &str, path: &Path) -> Result<()> {
        ensure!(
            !super::is_device(path),
            "{option} {}: this is no file, and a recording takes its place when it is finished: give the name of a file",
            path.display()
        );
        self.keep(option, path, || There::Other("what was recorded before".into()))
    }

    /// Refuses the place of what is no corrected log, before one is made for it.
    pub fn corrected_log(self, option: &str, path: &Path) -> Result<()> {
        self.keep(option, path, || {
            let mut head = String::new();
            let read =
                fs::File::open(path).and_then(|file| BufReader::new(file.take(LARGEST_BYTES)).read_line(&mut head));
            let is_one = read.is_ok() && ["predicted_", "corrected_"].iter().all(|column| head.contains(column));
            if is_one { There::Same } else { There::Other("no corrected log".into()) }
        })
    }

    /// Sets aside the corrected rows of another log than those of `new`, which was made for their place.
    pub fn corrected_log_of_another(self, option: &str, path: &Path, new: &Path) -> Result<()> {
        self.keep(option, path, || {
            let opened = fs::File::open(path).ok().zip(fs::File::open(new).ok());
            if opened.is_some_and(|(old, new)| are_of_one_log(old, new)) {
                There::Same
            } else {
                There::Earlier("are the corrected rows of another log")
            }
        })
    }

    /// Keeps what is in the way; `what` says what it is.
    fn keep(self, option: &str, path: &Path, what: impl FnOnce() -> There) -> Result<()> {
        // An empty file, as mktemp makes it, holds nothing; a device keeps nothing.
        if self.force || !fs::metadata(path).is_ok_and(|there| there.is_file() && there.len() > 0) {
            return Ok(());
        }
        match what() {
            There::Same => Ok(()),
            There::Earlier(what) => {
                let aside = set_aside(path).with_context(|| format!("{}: cannot be set aside", path.display()))?;
                screen::note(&format!("{}: what is there {what}; it is kept as {}", path.display(), aside.display()));
                Ok(())
            }
            There::Other(what) => bail!(
                "{option} {}: there is a file already, {what}, and it is kept: give another place, or --force to write over it",
                path.display()
            ),
        }
    }
}

/// A second name for a file whose place is wanted: `calibration.earlier.json`, or with the first free number.
fn set_aside(path: &Path) -> std::io::Result<PathBuf> {
    let end = path.extension().map(|end| format!(".{}", end.display())).unwrap_or_default();
    let named = |middle: &str| path.with_extension(format!("{middle}{end}").trim_start_matches('.'));
    let numbered = (2..).map(|number| named(&format!("earlier-{number}")));
    for aside in std::iter::once(named("earlier")).chain(numbered) {
        // It fails where there is such a file, and never replaces one. Some file systems know no second name.
        match fs::hard_link(path, &aside) {
            Ok(()) => return Ok(aside),
            Err(_) if aside.exists() => {}
            Err(_) => return fs::copy(path, &aside).map(|_| aside),
        }
    }
    Err(std::io::ErrorKind::AlreadyExists.into())
}

/// Whether a page or an export says that it came of a log of this name. In a page some letters are written otherwise.
fn names(text: &str, file: &str) -> bool {
    let written = file.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
    // "of" it in a page, "from" it in an export.
    let told = |word: &str, name: &str| text.contains(&format!("{word} {name}, SHA-256"));
    [file, &written].iter().any(|name| told("of", name) || told("from", name))
}

fn sorted<'o>(origins: &'o [Origin], of: impl Fn(&'o Origin) -> &'o str) -> Vec<&'o str> {
    let mut all: Vec<&str> = origins.iter().map(of).collect();
    all.sort_unstable();
    all
}

fn named(sources: &[Origin]) -> String {
    let names: Vec<&str> = sources.iter().map(|source| source.file.as_str()).collect();
    if names.is_empty() { "no log that it names".into() } else { names.join(" and ") }
}

fn text(path: &Path) -> Option<String> {
    let mut bytes = Vec::new();
    fs::File::open(path).and_then(|file| file.take(LARGEST_BYTES).read_to_end(&mut bytes)).ok()?;
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEEP: Force = Force { force: false };

    fn origin(sha256: &str) -> Origin {
        Origin {
            content: "log".into(),
            file: format!("{sha256}.csv"),
            sha256: sha256.into(),
            started: None,
            changed: None,
            rows: Vec::new(),
        }
    }

    #[test]
    fn what_came_of_a_log_before_it_changed_is_set_aside_each_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.report.html");
        for (sha256, before) in [("ab12", ""), ("cd34", "ab12"), ("ef56", "cd34")] {
            let log = Origin { file: "log.csv".into(), ..origin(sha256) };
            KEEP.text("--report", &path, &[log], None).unwrap();
            fs::remove_file(&path).ok();
            fs::write(&path, format!("by zerorate <li>of log.csv, SHA-256 <code>{sha256}</code></li>")).unwrap();
            let kept =
                fs::read_dir(folder.path()).unwrap().map(|file| fs::read_to_string(file.unwrap().path()).unwrap());
            assert!(before.is_empty() || kept.into_iter().any(|text| text.contains(before)), "{before} is gone");
        }
        assert!(folder.path().join("log.report.earlier.html").exists());
        assert!(folder.path().join("log.report.earlier-2.html").exists());
    }

    #[test]
    fn a_page_is_written_over_by_the_same_source_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.html");
        let refused = |sources: &[Origin]| KEEP.text("--report", &path, sources, None).err().map(|why| why.to_string());
        assert_eq!(refused(&[origin("ab12")]), None, "nothing is there");
        fs::write(&path, "").unwrap();
        assert_eq!(refused(&[origin("ab12")]), None, "an empty file holds nothing");
        fs::write(&path, "by zerorate, of ab12").unwrap();
        assert_eq!(refused(&[origin("ab12")]), None);
        assert!(refused(&[origin("cd34")]).unwrap().contains("another source"));
        assert!(refused(&[origin("ab12"), origin("cd34")]).unwrap().contains("--force"));
        fs::write(&path, "my own page about ab12").unwrap();
        assert!(refused(&[origin("ab12")]).unwrap().contains("has not written"));
        assert!(Force { force: true }.text("--report", &path, &[origin("cd34")], None).is_ok());
    }

    #[test]
    fn a_log_of_the_users_is_not_taken_for_a_corrected_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        fs::write(&path, "t,temperature,gx\n1,2,3\n").unwrap();
        assert!(KEEP.corrected_log("--out", &path).is_err());
        fs::write(&path, "t,temperature,gx,predicted_gx,corrected_gx\n1,2,3,4,5\n").unwrap();
        assert!(KEEP.corrected_log("--out", &path).is_ok());
    }

    #[test]
    fn a_table_that_names_no_source_is_written_over_by_itself_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("curve.csv");
        fs::write(&path, "temperature_c,\"gx bias, dps\"\n1,2\n").unwrap();
        let refused = |text: &str| KEEP.text("--out", &path, &[origin("ab12")], Some(text)).is_err();
        assert!(!refused("temperature_c,\"gx bias, dps\"\n1,2\n"));
        assert!(refused("temperature_c,\"gx bias, dps\"\n1,3\n"));
    }
}
