//! The output folder: results appear in it whole, or not at all.
//!
//! A run writes into `in-progress` inside the folder, and its files take the earlier ones' places at once when it is whole.
//! A run that fails leaves earlier results untouched and what it had recorded in `in-progress`, readable up to the last
//! whole group.

mod place;

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use zerorate_cal::recording::{Recording, RecordingInfo, RecordingWriter, hold};

use crate::checkpoint::forget_nothing;
use crate::error::BenchError;
use crate::run::{Extent, Recorder};

/// The folder inside the output folder in which a run is written.
pub const IN_PROGRESS: &str = "in-progress";

/// An output folder during a run.
#[derive(Debug)]
pub struct OutputFolder {
    folder: PathBuf,
    in_progress: PathBuf,
    files: Vec<&'static str>,
    /// Nobody else opens the folder while this is held; none where a system cannot.
    _held: Option<File>,
}

impl OutputFolder {
    /// Opens the folder, making it where it is missing, and makes sure that it can be written. What a run that was killed
    /// had begun to put in place is finished.
    ///
    /// # Errors
    /// [`BenchError::Write`]; [`BenchError::GoesOn`] where another run is written there.
    pub fn open(folder: &Path) -> Result<Self, BenchError> {
        refuse_where_a_run_goes_on(folder)?;
        // One that was killed while it put its results in place may have left no folder: only then is it made.
        place::recover(folder, &mut || Ok(())).map_err(cannot(folder))?;
        let in_progress = folder.join(IN_PROGRESS);
        fs::create_dir_all(&in_progress).map_err(cannot(&in_progress))?;
        let held = held(folder)?;
        let probe = in_progress.join(".probe");
        fs::write(&probe, b"probe").and_then(|()| fs::remove_file(&probe)).map_err(cannot(&in_progress))?;
        Ok(Self { folder: folder.into(), in_progress, files: Vec::new(), _held: held })
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

    /// Goes on with a recording after what its finished procedures have put into it; starts it where there were none.
    /// What a procedure that was stopped had recorded is kept beside it.
    ///
    /// # Errors
    /// [`BenchError::Recording`].
    pub fn go_on(
        &mut self,
        file: &'static str,
        info: &RecordingInfo,
        extent: Option<Extent>,
    ) -> Result<Recorder, BenchError> {
        let path = self.in_progress.join(file);
        let stream = path.with_extension("arrows");
        let Some(extent) = extent else {
            self.set_aside(&path);
            return self.record(file, info);
        };
        if !stream.exists() {
            self.files.push(file);
            return Ok(Recorder::discarding());
        }
        let earlier = Recording::read(&(&stream).into())?;
        self.set_aside(&path);
        let info = RecordingInfo { started: earlier.info.started, ..info.clone() };
        let mut writer = RecordingWriter::create(&path, &info)?;
        for group in earlier.rows.chunk_by(|a, b| a.group == b.group).filter(|group| group[0].group < extent.0) {
            writer.write_group(group)?;
        }
        self.files.push(file);
        Ok(Recorder::after(writer, extent))
    }

    /// What was set aside before stays: the next recording that is cut takes another name.
    fn set_aside(&self, path: &Path) {
        let cut = path.with_extension("cut.arrows");
        let free = (1..).map(|number| path.with_extension(format!("cut-{number}.arrows"))).find(|free| !free.exists());
        if let Some(free) = free.filter(|_| cut.exists()) {
            // If it cannot be renamed, it cannot be replaced either, and that is told.
            let _ = fs::rename(cut, free);
        }
    }

    /// The folder that the run is written in.
    #[must_use]
    pub fn in_progress(&self) -> &Path {
        &self.in_progress
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

    /// Puts everything in place: the run is whole, and nothing is kept to go on with. Returns the folder where something
    /// else that was there is now, if it could not be moved back.
    ///
    /// # Errors
    /// [`BenchError::Write`].
    pub fn publish(self) -> Result<Option<PathBuf>, BenchError> {
        place::publish(&self.folder, &self.files, &mut || Ok(())).map_err(cannot(&self.folder))
    }
}

/// Removes what a run has left in its own folder that holds nothing: recordings without a group, folders without a file.
pub fn tidy(folder: &Path) {
    let in_progress = folder.join(IN_PROGRESS);
    for entry in fs::read_dir(&in_progress).into_iter().flatten().flatten() {
        let path = entry.path();
        let is_stream = path.extension().is_some_and(|end| end == "arrows");
        if is_stream && Recording::read(&(&path).into()).is_ok_and(|recording| recording.rows.is_empty()) {
            // What cannot be removed is in nobody's way.
            let _ = fs::remove_file(path);
        }
    }
    forget_nothing(&in_progress);
    // A folder with something in it stays.
    let _ = fs::remove_dir(in_progress);
}

fn cannot(path: &Path) -> impl FnOnce(std::io::Error) -> BenchError {
    let path = path.display().to_string();
    move |source| BenchError::Write { path, source }
}

/// A run is written into one folder by one program, and a second one would disturb the first's instruments as well: it is
/// refused before any is touched. Windows has no such lock of a folder.
///
/// # Errors
/// [`BenchError::GoesOn`].
pub fn refuse_where_a_run_goes_on(folder: &Path) -> Result<(), BenchError> {
    held(folder).map(drop)
}

/// Holds a folder until what this gives is dropped; nothing is given where there is none.
fn held(folder: &Path) -> Result<Option<File>, BenchError> {
    let Ok(file) = File::open(folder) else { return Ok(None) };
    if hold(&file) { Ok(Some(file)) } else { Err(BenchError::GoesOn { folder: folder.display().to_string() }) }
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

    #[cfg(unix)]
    #[test]
    fn a_folder_in_which_a_run_goes_on_is_left_to_it() {
        let folder = tempfile::tempdir().unwrap();
        let first = OutputFolder::open(folder.path()).unwrap();
        let error = OutputFolder::open(folder.path()).unwrap_err();
        assert!(matches!(error, BenchError::GoesOn { .. }), "{error}");
        drop(first);
        OutputFolder::open(folder.path()).unwrap();
    }

    #[test]
    fn what_a_run_had_put_together_when_it_was_killed_takes_its_place() {
        let parent = tempfile::tempdir().unwrap();
        // The folder was moved aside, and the new one not yet into its place.
        let of = |name: &str| parent.path().join(name);
        for (folder, text) in [("calibration.7.next", "new"), ("calibration.7.earlier", "old")] {
            fs::create_dir_all(of(folder)).unwrap();
            fs::write(of(folder).join("summary.json"), text).unwrap();
        }
        OutputFolder::open(&of("calibration")).unwrap();
        assert_eq!(fs::read_to_string(of("calibration").join("summary.json")).unwrap(), "new");
    }

    #[test]
    fn what_a_run_leaves_goes_where_it_holds_nothing() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("calibration");
        let mut output = OutputFolder::open(&folder).unwrap();
        let recorder = output.record("ramp.parquet", &RecordingInfo::default()).unwrap();
        drop((recorder, output));
        assert!(folder.join(IN_PROGRESS).join("ramp.arrows").exists());
        tidy(&folder);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
        OutputFolder::open(&folder).unwrap();
        fs::write(folder.join(IN_PROGRESS).join("ramp.cut.arrows"), "cut in its head").unwrap();
        tidy(&folder);
        assert!(folder.join(IN_PROGRESS).join("ramp.cut.arrows").exists(), "what cannot be read is not thrown away");
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
