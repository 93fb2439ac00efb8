//! What earlier runs have done: the batches of one that was ended, and the rows of one that was finished.

use std::collections::HashMap;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use zerorate_cal::quality::{Reason, ReasonKind};

use super::{RunError, parts};
use crate::dataset::Found;
use crate::models::{self, Beside, ModelRow};

/// Rows of earlier runs by their recording, and the place for this one's.
pub(super) struct Earlier {
    folder: PathBuf,
    /// Held while the run lasts; the system lets go of it when the process ends.
    _lock: File,
    next: usize,
    rows: HashMap<String, Vec<ModelRow>>,
}

impl Earlier {
    /// Reads what is there for the model asked for; nothing of it for a fresh run.
    pub(super) fn open(out: &Path, asked: &str, fresh: bool) -> Result<Self, RunError> {
        let folder = parts(out);
        let failed = |source| RunError::Parts { path: folder.display().to_string(), source };
        fs::create_dir_all(&folder).map_err(failed)?;
        let lock = File::create(folder.join("lock")).map_err(failed)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(RunError::Busy { path: out.display().to_string() }),
            Err(TryLockError::Error(source)) => return Err(failed(source)),
        }
        let mut earlier = Self { folder, _lock: lock, next: 0, rows: HashMap::new() };
        if fresh {
            for part in earlier.parts() {
                // What stays is read by no one.
                let _ = fs::remove_file(part);
            }
            return Ok(earlier);
        }
        earlier.read(out, asked);
        for part in earlier.parts() {
            earlier.read(&part, asked);
            let number = part.file_stem().and_then(|stem| stem.to_str()?.strip_prefix("part-")?.parse::<usize>().ok());
            earlier.next = earlier.next.max(number.map_or(0, |number| number + 1));
        }
        Ok(earlier)
    }

    /// The batches that are there, in order.
    fn parts(&self) -> Vec<PathBuf> {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let mut parts: Vec<PathBuf> =
            entries.filter(|path| path.extension().is_some_and(|kind| kind == "parquet")).collect();
        parts.sort();
        parts
    }

    /// A part that was being written when its run was ended is no file that can be read: its units are done again.
    fn read(&mut self, file: &Path, asked: &str) {
        for row in models::read(file).unwrap_or_default().into_iter().filter(|row| row.model_asked == asked) {
            let rows = self.rows.entry(row.file.clone()).or_default();
            // The latest run's.
            rows.retain(|own| own.axis != row.axis);
            rows.push(row);
        }
    }

    /// The rows of a recording that was fitted as it is now.
    pub(super) fn take(&mut self, found: &Found) -> Option<Vec<ModelRow>> {
        let now = state(found);
        // Of rows of an earlier version nobody knows whether they are of a copy.
        let same = |row: &ModelRow| state_of(row) == now && !row.readings_sha256.is_empty();
        let mut rows = self.rows.remove(&found.file).filter(|rows| rows.len() == 2 && rows.iter().all(same))?;
        rows.iter_mut().for_each(|row| rejudge(row, found.serial_reason.as_ref()));
        rows.sort_by(|a, b| a.axis.cmp(&b.axis));
        Some(rows)
    }

    /// Keeps a batch of this run.
    pub(super) fn keep(&mut self, rows: &[ModelRow]) -> Result<(), RunError> {
        models::write(&self.folder.join(format!("part-{:06}.parquet", self.next)), rows, &Beside::default())?;
        self.next += 1;
        Ok(())
    }

    /// The run is whole: its batches are no longer needed.
    pub(super) fn finish(self) {
        // What stays is read by the next run and changes nothing.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// When a recording was written, and its bytes, a whole number as a row has them: by these it is told from what it was.
pub(super) fn state(found: &Found) -> (String, u64) {
    (found.meta.last_modified.to_rfc3339(), (found.meta.size as f64).to_bits())
}

/// The same of the recording that a row came of, as it was then.
pub(super) fn state_of(row: &ModelRow) -> (String, u64) {
    (row.file_modified.clone(), row.file_bytes.to_bits())
}

/// What is judged by the other files, which may have changed since: a serial anew, copies when all rows are there.
fn rejudge(row: &mut ModelRow, serial: Option<&Reason>) {
    let by_others = [ReasonKind::WrongSerial, ReasonKind::DuplicateSerial, ReasonKind::Copied];
    let own = row.reason_list().into_iter().filter(|reason| !by_others.contains(&reason.kind));
    let reasons: Vec<Reason> = own.chain(serial.cloned()).collect();
    row.judge(&reasons);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_serial_is_judged_anew_and_nothing_else() {
        let cut = Reason::new(ReasonKind::CutRun, "cut");
        let twice = Reason::new(ReasonKind::DuplicateSerial, "twice");
        let mut row = ModelRow { reasons: serde_json::to_string(&[&twice]).unwrap(), ..ModelRow::default() };
        rejudge(&mut row, None);
        assert_eq!((row.verdict.as_str(), row.reason_list().len()), ("good", 0));
        let copied = Reason::new(ReasonKind::Copied, "copied");
        row.reasons = serde_json::to_string(&[&cut, &copied]).unwrap();
        rejudge(&mut row, Some(&twice));
        assert_eq!((row.verdict.as_str(), row.reason_list()), ("rejected", vec![cut, twice]));
    }
}
