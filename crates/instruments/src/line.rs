//! The line to an instrument: bytes, and a way to be rid of what is still on it.

pub mod serial;
pub mod tcp;

use std::io;
use std::time::Duration;

/// A line to an instrument.
pub trait Line: Send {
    /// Sends bytes; opens the line where it is not open.
    ///
    /// # Errors
    /// What the system says.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Waits for bytes and appends them; `false` when none came in time.
    ///
    /// # Errors
    /// What the system says; the line is then closed.
    fn receive(&mut self, into: &mut Vec<u8>, wait: Duration) -> io::Result<bool>;

    /// Drops what has come unasked, an answer that came twice, and what goes on coming until it was quiet for `quiet`.
    fn drop_heard(&mut self, quiet: Duration);

    /// Makes sure that no late answer is taken for the next: the connection is made anew, or the line listened to until it has
    /// been quiet for `quiet`.
    fn renew(&mut self, quiet: Duration);
}
