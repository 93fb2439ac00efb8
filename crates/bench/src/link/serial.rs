//! A serial line.

use std::path::Path;
use std::time::Duration;

use serialport::ClearBuffer;

use super::threaded::LISTEN;
use super::{Link, LinkError, ThreadedLink};

/// The boards' rate: 11 520 bytes a second, twice what groups of 500 samples with every sample streamed need.
pub const BAUD: u32 = 115_200;
/// Their rate on the second line: a scan's frame of 20 bytes takes 0.43 ms, a seventh of a scan period.
pub const SCAN_BAUD: u32 = 460_800;
/// How long a frame may take to leave.
const SEND: Duration = Duration::from_secs(1);

/// Opens a serial port, 8 bits, no parity, one stop bit. What came before is dropped.
///
/// # Errors
/// [`LinkError::NotOpened`], with what to do.
pub fn open(path: &Path, baud: u32) -> Result<Box<dyn Link>, LinkError> {
    let failed = |error: serialport::Error| LinkError::NotOpened {
        line: format!("the serial port {}", path.display()),
        remedy: remedy(&error, path),
        reason: reason(error),
    };
    let mut reader = serialport::new(path.to_string_lossy(), baud).timeout(LISTEN).open().map_err(failed)?;
    let mut writer = reader.try_clone().map_err(failed)?;
    reader.set_timeout(LISTEN).and_then(|()| writer.set_timeout(SEND)).map_err(failed)?;
    // Half a frame from before we listened would only be counted as damaged. A port without a buffer has none of it.
    let _ = reader.clear(ClearBuffer::Input);
    Ok(Box::new(ThreadedLink::new(reader, writer)))
}

fn reason(error: serialport::Error) -> String {
    let text = error.description;
    text.split(" (os error").next().unwrap_or(&text).to_owned()
}

fn remedy(error: &serialport::Error, path: &Path) -> &'static str {
    use serialport::ErrorKind::{Io, NoDevice};
    use std::io::ErrorKind::{NotFound, PermissionDenied};
    let text = error.description.to_lowercase();
    match error.kind {
        NoDevice | Io(NotFound) if !path.exists() => "is the board plugged in? `ls /dev/serial/by-id` shows what is",
        Io(PermissionDenied) => "you may not use it: join the group that owns it (dialout, say), or give rights to it",
        _ if text.contains("busy") || text.contains("lock") => "another program has it open: end that one first",
        _ if path.is_file() || path.is_dir() => "this is no serial port: give the port's path",
        _ => "check that it is a serial port and that the board is plugged in",
    }
}
