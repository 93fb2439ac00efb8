//! The line to a device: bytes, nothing more.

/// A line that bytes are sent and received on.
pub trait Link {
    /// Sends bytes.
    ///
    /// # Errors
    /// [`LinkError`], when the line is gone.
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError>;

    /// Waits for bytes and appends them to `into`.
    ///
    /// # Errors
    /// [`LinkError`], when the line is gone or stays silent.
    fn receive(&mut self, into: &mut Vec<u8>) -> Result<(), LinkError>;
}

/// Why a line does not work.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// Nothing came for too long.
    #[error("the device says nothing: is it powered, and its acquisition running?")]
    Silent,
    /// The line is gone.
    #[error("the line to the device is gone: {0}")]
    Gone(std::io::Error),
}
