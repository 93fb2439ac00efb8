//! The line to a device: bytes, nothing more.

#[cfg(feature = "boards")]
pub mod serial;
pub mod tcp;
mod threaded;

use std::time::Instant;

pub use threaded::ThreadedLink;

/// Groups without a word after which a simulated board, whose time passes only while somebody waits, is given up: one
/// that works alone takes them without end, and says only what it was asked to.
pub(crate) const MOST_UNHEARD: u32 = 10_000;

/// A line that bytes are sent and received on.
pub trait Link {
    /// Sends bytes.
    ///
    /// # Errors
    /// [`LinkError`], when the line is gone.
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError>;

    /// Waits for bytes and appends them to `into`. A line [in real time](Self::in_real_time) returns without any after
    /// a tenth of a second, so that whoever waits can look at the clock; another waits until there are some.
    ///
    /// # Errors
    /// [`LinkError`], when the line is gone or stays silent.
    fn receive(&mut self, into: &mut Vec<u8>) -> Result<(), LinkError>;

    /// Whether time passes on the other side while nobody waits for it, and bytes may be lost on the way. Then what is
    /// not answered is sent again, and silence is an error.
    fn in_real_time(&self) -> bool {
        false
    }

    /// The clock by which silence is measured: the wall's, unless the line has one of its own, as in a test.
    fn now(&self) -> Instant {
        Instant::now()
    }
}

/// Why a line does not work.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// Nothing came for too long.
    #[error("the device says nothing: is it powered, and its acquisition running?")]
    Silent,
    /// The line is gone.
    #[error("the line to the device is gone: {0}. Check cable and power")]
    Gone(std::io::Error),
    /// The line cannot be opened.
    #[error("{line} cannot be opened: {reason}: {remedy}")]
    NotOpened {
        /// The line, as people write it.
        line: String,
        /// What the system says.
        reason: String,
        /// What to do.
        remedy: &'static str,
    },
}
