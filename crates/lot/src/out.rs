//! Where results go: never over what they were made from, nor over what is no file.

use std::path::Path;

/// Why nothing is written to a place.
#[derive(Debug, thiserror::Error)]
pub enum OutError {
    /// It is a folder or a device.
    #[error("{path}: this is no file: give `out` the name of a file")]
    NoFile {
        /// The place.
        path: String,
    },
    /// It is what the results come from.
    #[error("{path}: this is one of the files that are read, and would be lost: give `out` another name")]
    Input {
        /// The place.
        path: String,
    },
    /// It holds something else.
    #[error("{path}: there is a file already that is not {wanted}, and it is kept: give `out` another name")]
    Other {
        /// The place.
        path: String,
        /// What may be written over, in words.
        wanted: &'static str,
    },
}

/// Whether results may go to `out`: a file that is there, if any, is none of the inputs.
///
/// # Errors
/// [`OutError`].
pub fn check<'a>(out: &Path, mut inputs: impl Iterator<Item = &'a Path>) -> Result<(), OutError> {
    let path = || out.display().to_string();
    if !out.exists() {
        return Ok(());
    }
    if !out.is_file() {
        return Err(OutError::NoFile { path: path() });
    }
    let same =
        |input: &Path| input.canonicalize().ok().is_some_and(|input| out.canonicalize().is_ok_and(|out| input == out));
    if inputs.any(same) { Err(OutError::Input { path: path() }) } else { Ok(()) }
}

/// Whether what is at `out`, if anything, is `wanted`, which the same command wrote before and may write over.
///
/// # Errors
/// [`OutError`].
pub fn check_kind(out: &Path, wanted: &'static str, is_one: impl FnOnce(&Path) -> bool) -> Result<(), OutError> {
    check(out, std::iter::empty())?;
    let empty = out.metadata().is_ok_and(|metadata| metadata.len() == 0);
    if !out.exists() || empty || is_one(out) {
        return Ok(());
    }
    Err(OutError::Other { path: out.display().to_string(), wanted })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_goes_over_a_folder_an_input_or_another_kind_of_file() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.parquet");
        let models = |out: &Path| check_kind(out, "models", crate::models::are_in);
        assert!(models(&file).is_ok());
        assert!(matches!(models(folder.path()), Err(OutError::NoFile { .. })));
        std::fs::write(&file, "").unwrap();
        assert!(models(&file).is_ok());
        std::fs::write(&file, "a recording, say").unwrap();
        let kept = models(&file).unwrap_err().to_string();
        assert!(kept.contains("is not models, and it is kept"), "{kept}");
        assert!(matches!(check(&file, [file.as_path()].into_iter()), Err(OutError::Input { .. })));
        assert!(check(&file, [folder.path()].into_iter()).is_ok());
    }
}
