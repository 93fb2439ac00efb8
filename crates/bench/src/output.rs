//! The output folder: results appear in it whole, or not at all.
//!
//! A run writes into `in-progress` inside the folder and moves its files up at the end. A run that fails leaves earlier
//! results untouched and what it had recorded in `in-progress`, readable up to the last whole group.

use std::fs;
use std::path::{Path, PathBuf};

use zerorate_cal::recording::{RecordingInfo, RecordingWriter};

use crate::error::BenchError;
use crate::run::Recorder;

/// The folder inside the output folder in which a run is written.
pub const IN_PROGRESS: &str = "in-progress";

/// An output folder during a run.
#[derive(Debug)]
pub struct OutputFolder {
    folder: PathBuf,
    in_progress: PathBuf,
    files: Vec<&'static str>,
}

impl OutputFolder {
    /// Opens the folder, making it where it is missing, and makes sure that it can be written.
    ///
    /// # Errors
    /// [`BenchError::Write`].
    pub fn open(folder: &Path) -> Result<Self, BenchError> {
        let in_progress = folder.join(IN_PROGRESS);
        fs::create_dir_all(&in_progress).map_err(cannot(&in_progress))?;
        let probe = in_progress.join(".probe");
        fs::write(&probe, b"probe").and_then(|()| fs::remove_file(&probe)).map_err(cannot(&in_progress))?;
        Ok(Self { folder: folder.into(), in_progress, files: Vec::new() })
    }

    /// Starts a recording.
    ///
    /// # Errors
    /// [`BenchError::Recording`].
    pub fn record(&mut self, file: &'static str, info: &RecordingInfo) -> Result<Recorder, BenchError> {
        let writer = RecordingWriter::create(&self.in_progress.join(file), info)?;
        self.files.push(file);
        Ok(Recorder::new(writer))
    }

    /// Writes a file.
    ///
    /// # Errors
    /// [`BenchError::Write`].
    pub fn write(&mut self, file: &'static str, bytes: &[u8]) -> Result<(), BenchError> {
        let path = self.in_progress.join(file);
        fs::write(&path, bytes).map_err(cannot(&path))?;
        self.files.push(file);
        Ok(())
    }

    /// Where a file of the run is until the run is whole.
    #[must_use]
    pub fn path(&self, file: &str) -> PathBuf {
        self.in_progress.join(file)
    }

    /// Moves everything up: the run is whole.
    ///
    /// # Errors
    /// [`BenchError::Write`].
    pub fn publish(self) -> Result<(), BenchError> {
        for file in &self.files {
            let to = self.folder.join(file);
            fs::rename(self.in_progress.join(file), &to).map_err(cannot(&to))?;
        }
        // Something left over from a run that was cut is not ours to throw away: then the folder stays.
        let _ = fs::remove_dir(&self.in_progress);
        Ok(())
    }
}

fn cannot(path: &Path) -> impl FnOnce(std::io::Error) -> BenchError {
    let path = path.display().to_string();
    move |source| BenchError::Write { path, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn earlier_results_stay_until_the_run_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("summary.json"), "earlier").unwrap();
        let mut output = OutputFolder::open(folder.path()).unwrap();
        output.write("summary.json", b"later").unwrap();
        let read = || fs::read_to_string(folder.path().join("summary.json")).unwrap();
        assert_eq!(read(), "earlier");
        output.publish().unwrap();
        assert_eq!(read(), "later");
        assert!(!folder.path().join(IN_PROGRESS).exists());
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_named_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = OutputFolder::open(&file).unwrap_err().to_string();
        assert!(error.contains("file") && error.contains("untouched"), "{error}");
    }
}
