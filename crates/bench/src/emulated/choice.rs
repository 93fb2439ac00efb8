//! Where the firmware is.

use std::path::{Path, PathBuf};

/// Where `cargo xtask firmware` leaves the emulated board's firmware, from the project's folder.
const BUILT: &str = "firmware/target/thumbv7em-none-eabihf/release/zerorate-mps2-an386";

/// There is no firmware to run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: `cargo xtask firmware` in Zerorate's sources builds it; --firmware FILE, or the variable ZERORATE_FIRMWARE, names another", match .0 {
    Some(path) => format!("there is no firmware at {}", path.display()),
    None => format!("no firmware was found: there is no {BUILT} here or in a folder above"),
})]
pub struct FirmwareMissing(Option<PathBuf>);

/// The firmware for the emulated board: the one named, here or in `ZERORATE_FIRMWARE`, or what was built in the sources
/// that we stand in or were built from.
///
/// # Errors
/// [`FirmwareMissing`].
pub fn find_firmware(named: Option<&Path>) -> Result<PathBuf, FirmwareMissing> {
    let variable = std::env::var_os("ZERORATE_FIRMWARE").map(PathBuf::from);
    if let Some(path) = named.or(variable.as_deref()) {
        return if path.is_file() { Ok(path.into()) } else { Err(FirmwareMissing(Some(path.into()))) };
    }
    let places = [std::env::current_dir(), std::env::current_exe()];
    let folders = places.iter().flatten().flat_map(|place| place.ancestors());
    folders.map(|folder| folder.join(BUILT)).find(|path| path.is_file()).ok_or(FirmwareMissing(None))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_firmware_that_is_not_there_is_named_with_the_command_that_builds_it() {
        let error = find_firmware(Some(Path::new("/no/such.elf"))).unwrap_err().to_string();
        assert!(error.contains("/no/such.elf") && error.contains("cargo xtask firmware"), "{error}");
        assert!(FirmwareMissing(None).to_string().contains("--firmware FILE"));
    }
}
