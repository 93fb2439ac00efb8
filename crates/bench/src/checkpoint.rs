//! What a run of days keeps of itself: the results of each procedure that was carried through, so that a run that was
//! stopped goes on after them.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use zerorate_cal::source::whole_file::write_whole;

use crate::error::BenchError;
use crate::run::{Extent, Recorder};

/// The folder inside the run's in which it keeps them.
const FOLDER: &str = "finished";
/// The file that says whose they are.
const WHOSE: &str = "run.txt";

/// Whether a run keeps what it has finished.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// It is over in seconds, and does not.
    Nothing,
    /// It does, and begins anew.
    Anew,
    /// It does, and goes on after what was finished before.
    Resume,
}

/// The procedures that were carried through.
#[derive(Debug)]
pub struct Checkpoints {
    folder: Option<PathBuf>,
    is_resumed: bool,
}

impl Checkpoints {
    /// Keeps nothing.
    #[must_use]
    pub const fn none() -> Self {
        Self { folder: None, is_resumed: false }
    }

    /// Opens what is kept in the folder of a run. `whose` is what a run must share with the one that is resumed: its
    /// unit and set-up.
    ///
    /// # Errors
    /// [`BenchError::Unfinished`] and [`BenchError::OtherRun`]; [`BenchError::Write`].
    pub fn open(in_progress: &Path, keep: Keep, whose: &str) -> Result<Self, BenchError> {
        let folder = in_progress.join(FOLDER);
        let file = folder.join(WHOSE);
        let is_resumed = !is_nothing_finished(&folder);
        match (fs::read_to_string(&file), keep) {
            (Err(_), Keep::Nothing) => return Ok(Self::none()),
            // A simulated run would take the place of what a real one has finished.
            (Ok(_), Keep::Anew | Keep::Nothing) => {
                return Err(BenchError::Unfinished { folder: in_progress.display().to_string() });
            }
            (Ok(before), _) if before != whose => {
                return Err(BenchError::OtherRun { folder: in_progress.display().to_string() });
            }
            (Ok(_), _) => {}
            // Nothing to go on with: then it begins.
            (Err(_), _) => {
                fs::create_dir_all(&folder).map_err(cannot(&folder))?;
                write_whole(&file, whose.as_bytes()).map_err(cannot(&file))?;
            }
        }
        Ok(Self { folder: Some(folder), is_resumed })
    }

    /// Whether a part of the run was finished before it was stopped.
    #[must_use]
    pub const fn is_resumed(&self) -> bool {
        self.is_resumed
    }

    /// How far a recording had got when a procedure was done with it; `None` while it is not.
    #[must_use]
    pub fn extent(&self, procedure: &str) -> Option<Extent> {
        let bytes = fs::read(self.file(procedure)?).ok()?;
        postcard::take_from_bytes(&bytes).ok().map(|(extent, _)| extent)
    }

    /// The results of a procedure: those kept, or what `run` comes to, which is then kept.
    ///
    /// # Errors
    /// What `run` says; [`BenchError::Write`] when the results cannot be kept.
    pub fn once<T: Serialize + DeserializeOwned>(
        &self,
        procedure: &str,
        recorder: &mut Recorder,
        run: impl FnOnce(&mut Recorder) -> Result<T, BenchError>,
    ) -> Result<T, BenchError> {
        let Some(file) = self.file(procedure) else { return run(recorder) };
        let kept = fs::read(&file).ok().and_then(|bytes| postcard::from_bytes::<(Extent, T)>(&bytes).ok());
        if let Some((_, results)) = kept {
            return Ok(results);
        }
        let results = run(recorder)?;
        let bytes = postcard::to_stdvec(&(recorder.extent(), &results)).map_err(std::io::Error::other);
        bytes.and_then(|bytes| write_whole(&file, &bytes)).map_err(cannot(&file))?;
        Ok(results)
    }

    /// What a procedure came to cannot be used: a run that goes on runs it again.
    pub fn withdraw(&self, procedure: &str) {
        if let Some(file) = self.file(procedure) {
            // If it cannot be removed, the next run comes to the same and tries again.
            let _ = fs::remove_file(file);
        }
    }

    fn file(&self, procedure: &str) -> Option<PathBuf> {
        self.folder.as_ref().map(|folder| folder.join(format!("{procedure}.bin")))
    }
}

/// Removes what is kept where nothing was carried through yet.
pub(crate) fn forget_nothing(in_progress: &Path) {
    let folder = in_progress.join(FOLDER);
    if is_nothing_finished(&folder) {
        let _ = fs::remove_file(folder.join(WHOSE));
        let _ = fs::remove_dir(folder);
    }
}

fn is_nothing_finished(folder: &Path) -> bool {
    fs::read_dir(folder).into_iter().flatten().flatten().all(|file| file.file_name() == WHOSE)
}

/// The run in a folder is whole: nothing is kept of it any more.
pub(crate) fn forget(in_progress: &Path) {
    // What cannot be removed is in nobody's way but the next run's, which says so.
    let _ = fs::remove_dir_all(in_progress.join(FOLDER));
}

fn cannot(path: &Path) -> impl FnOnce(std::io::Error) -> BenchError {
    let path = path.display().to_string();
    move |source| BenchError::Write { path, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn once(kept: &Checkpoints, value: u32) -> u32 {
        kept.once("ramp", &mut Recorder::discarding(), |_| Ok(value)).unwrap()
    }

    #[test]
    fn what_was_finished_is_not_run_again_and_what_failed_is() {
        let folder = tempfile::tempdir().unwrap();
        let kept = Checkpoints::open(folder.path(), Keep::Anew, "unit 1").unwrap();
        let failed = kept.once("ramp", &mut Recorder::discarding(), |_| {
            Err::<u32, _>(BenchError::Compose("the line is gone".into()))
        });
        assert!(failed.is_err() && kept.extent("ramp").is_none());
        assert_eq!((once(&kept, 7), once(&kept, 8)), (7, 7));
        let resumed = Checkpoints::open(folder.path(), Keep::Resume, "unit 1").unwrap();
        assert!(resumed.extent("ramp").is_some());
        assert_eq!(once(&resumed, 9), 7);
        resumed.withdraw("ramp");
        assert_eq!((resumed.extent("ramp"), once(&resumed, 8)), (None, 8));
        forget(folder.path());
        assert_eq!(once(&Checkpoints::open(folder.path(), Keep::Anew, "unit 1").unwrap(), 9), 9);
    }

    #[test]
    fn an_unfinished_run_is_neither_thrown_away_nor_mixed_with_another() {
        let folder = tempfile::tempdir().unwrap();
        Checkpoints::open(folder.path(), Keep::Anew, "unit 1").unwrap();
        let anew = Checkpoints::open(folder.path(), Keep::Anew, "unit 1").unwrap_err().to_string();
        assert!(anew.contains("`resume`"), "{anew}");
        let simulated = Checkpoints::open(folder.path(), Keep::Nothing, "unit 1").unwrap_err();
        assert!(matches!(simulated, BenchError::Unfinished { .. }), "{simulated}");
        let other = Checkpoints::open(folder.path(), Keep::Resume, "unit 2").unwrap_err();
        assert!(matches!(other, BenchError::OtherRun { .. }), "{other}");
    }
}
