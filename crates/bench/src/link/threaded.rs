//! A line in real time: a thread of its own listens, so that nothing is lost while nobody looks.
//!
//! A serial port's own buffer holds some seconds of groups; a person at a supply takes minutes.

use std::io::{self, Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use super::{Link, LinkError};

/// How long the client waits before it looks at the clock again.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// How long the listener waits before it sees that it should end. Readers are to be opened with this.
pub(super) const LISTEN: Duration = Duration::from_millis(50);

/// A line in real time.
pub struct ThreadedLink {
    writer: Box<dyn Write>,
    heard: Receiver<io::Result<Vec<u8>>>,
    end: Arc<AtomicBool>,
    listener: Option<JoinHandle<()>>,
    /// Why nothing can be sent any more: told after what was heard before.
    cut: Option<io::Error>,
}

impl ThreadedLink {
    /// A line on its two halves. The reader must return after some time although nothing came.
    pub fn new(mut reader: impl Read + Send + 'static, writer: impl Write + 'static) -> Self {
        let (tell, heard) = mpsc::channel();
        let end = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&end);
        let listener = thread::spawn(move || {
            let mut buffer = [0; 4096];
            while !ended.load(Ordering::Relaxed) {
                let told = match reader.read(&mut buffer) {
                    Ok(0) => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the other side closed it")),
                    Ok(length) => Ok(buffer[..length].to_vec()),
                    Err(error) if is_only_waiting(&error) => continue,
                    Err(error) => Err(error),
                };
                let is_over = told.is_err();
                if tell.send(told).is_err() || is_over {
                    break;
                }
            }
        });
        Self { writer: Box::new(writer), heard, end, listener: Some(listener), cut: None }
    }
}

fn is_only_waiting(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

impl Link for ThreadedLink {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        match self.writer.write_all(bytes) {
            // The other side takes nothing any more: whoever waits for its answer finds out how long that lasts.
            Err(error) if !is_only_waiting(&error) => self.cut = Some(error),
            _ => {}
        }
        Ok(())
    }

    fn receive(&mut self, into: &mut Vec<u8>) -> Result<(), LinkError> {
        match self.heard.recv_timeout(LOOK_EVERY) {
            Ok(Ok(bytes)) => into.extend(bytes),
            Ok(Err(error)) => return Err(LinkError::Gone(error)),
            Err(RecvTimeoutError::Timeout) => {
                return self.cut.take().map_or(Ok(()), |error| Err(LinkError::Gone(error)));
            }
            Err(RecvTimeoutError::Disconnected) => return Err(LinkError::Gone(io::ErrorKind::BrokenPipe.into())),
        }
        Ok(())
    }

    fn in_real_time(&self) -> bool {
        true
    }
}

impl Drop for ThreadedLink {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
        if let Some(listener) = self.listener.take() {
            // A port is free again only when its last handle is gone; a listener that panicked has none any more.
            let _ = listener.join();
        }
    }
}
