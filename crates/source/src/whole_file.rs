//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// Writes a file beside its place and moves it there when it is whole and on the disk: whoever reads `path` sees the
/// earlier file or the new one, never a part, and an error leaves the earlier one as it was.
///
/// # Errors
/// When the folder is not there or not writable, or the disk is full.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(bytes)?;
    file.finish()
}

/// A file that is being written beside its place. Until [`WholeFile::finish`] an earlier file there is as it was;
/// dropped before that, nothing is left.
#[derive(Debug)]
pub struct WholeFile {
    path: PathBuf,
    file: Written,
}

#[derive(Debug)]
enum Written {
    Beside(NamedTempFile),
    /// A device or a pipe must not be replaced by a file.
    There(File),
}

impl WholeFile {
    /// Starts the file that will be at `path`.
    ///
    /// # Errors
    /// When the folder is not there or not writable.
    pub fn create(path: &Path) -> io::Result<Self> {
        let is_special = fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir());
        let file = if is_special {
            Written::There(File::create(path)?)
        } else {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            Written::Beside(builder().tempfile_in(folder.unwrap_or(Path::new(".")))?)
        };
        Ok(Self { path: path.to_owned(), file })
    }

    /// Where what was written so far can be read; `None` of a device, which keeps nothing.
    #[must_use]
    pub fn written(&self) -> Option<&Path> {
        match &self.file {
            Written::Beside(file) => Some(file.path()),
            Written::There(_) => None,
        }
    }

    /// Moves the file to its place.
    ///
    /// # Errors
    /// When the disk is full or a folder is in its place.
    pub fn finish(self) -> io::Result<()> {
        if let Written::Beside(file) = self.file {
            // A rename can reach the disk before the contents do.
            file.as_file().sync_all()?;
            file.persist(&self.path)?;
        }
        Ok(())
    }
}

/// A temporary file with the permissions of any other new file.
fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.suffix(".partial");
    #[cfg(unix)]
    builder.permissions(<fs::Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666));
    builder
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.file {
            Written::Beside(file) => file.write(bytes),
            Written::There(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.file {
            Written::Beside(file) => file.flush(),
            Written::There(file) => file.flush(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_earlier_file_is_replaced_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("calibration.json");
        write_whole(&path, b"first").unwrap();
        write_whole(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_file_that_cannot_be_put_in_place_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        // A folder that is not empty cannot be replaced by a file.
        let path = folder.path().join("taken");
        fs::create_dir(&path).unwrap();
        fs::write(path.join("inside"), "earlier").unwrap();
        assert!(write_whole(&path, b"new").is_err());
        assert_eq!(fs::read(path.join("inside")).unwrap(), b"earlier");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        assert!(write_whole(&folder.path().join("missing/calibration.json"), b"new").is_err());
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_device_is_written_to_and_not_replaced_and_a_full_disk_is_an_error() {
        use std::os::unix::fs::FileTypeExt;
        let full = Path::new("/dev/full");
        let error = write_whole(full, b"anything").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        assert!(fs::metadata(full).unwrap().file_type().is_char_device());
        write_whole(Path::new("/dev/null"), b"anything").unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    }

    #[test]
    fn a_file_that_was_not_finished_leaves_the_earlier_one_and_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("corrected.csv");
        write_whole(&path, b"earlier").unwrap();
        WholeFile::create(&path).unwrap().write_all(b"half").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"earlier");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
