//! A serial line, 8 bits, no parity, one stop bit. It has no connection to be made anew: it is listened to until it is quiet.

use std::io::{self, Read, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use serialport::{ClearBuffer, SerialPort};

use super::Line;

/// How long bytes may take to leave, and how long a look takes.
const LOOK: Duration = Duration::from_millis(20);
/// A line that is never quiet is listened to no longer than so many times the quiet that was asked for.
const MOST_QUIETS: u32 = 5;

/// A serial line.
pub struct SerialLine {
    path: PathBuf,
    baud: u32,
    port: Option<Box<dyn SerialPort>>,
}

impl SerialLine {
    /// A line on a port, opened when it is needed.
    #[must_use]
    pub const fn new(path: PathBuf, baud: u32) -> Self {
        Self { path, baud, port: None }
    }

    fn port(&mut self) -> io::Result<&mut Box<dyn SerialPort>> {
        let port = match self.port.take() {
            Some(port) => port,
            None => serialport::new(self.path.to_string_lossy(), self.baud).timeout(LOOK).open()?,
        };
        Ok(self.port.insert(port))
    }
}

impl Line for SerialLine {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let port = self.port()?;
        let sent = port.write_all(bytes).and_then(|()| port.flush());
        if sent.is_err() {
            self.port = None;
        }
        sent
    }

    fn receive(&mut self, into: &mut Vec<u8>, wait: Duration) -> io::Result<bool> {
        let port = self.port()?;
        let mut buffer = [0; 512];
        let heard = port.set_timeout(wait.max(Duration::from_millis(1))).map_err(io::Error::from).and_then(|()| {
            match port.read(&mut buffer) {
                Ok(0) => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the port is gone")),
                Ok(length) => Ok(length),
                Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::Interrupted) => Ok(0),
                Err(error) => Err(error),
            }
        });
        match heard {
            Ok(length) => {
                into.extend_from_slice(&buffer[..length]);
                Ok(length > 0)
            }
            Err(error) => {
                self.port = None;
                Err(error)
            }
        }
    }

    fn drop_heard(&mut self, quiet: Duration) {
        if let Some(port) = &mut self.port {
            // A port without a buffer has nothing to drop.
            let _ = port.clear(ClearBuffer::Input);
        }
        if !quiet.is_zero() {
            self.renew(quiet);
        }
    }

    fn renew(&mut self, quiet: Duration) {
        let began = Instant::now();
        let mut heard_last = began;
        let mut dropped = Vec::new();
        while heard_last.elapsed() < quiet && began.elapsed() < quiet * MOST_QUIETS {
            match self.receive(&mut dropped, LOOK) {
                Ok(true) => heard_last = Instant::now(),
                Ok(false) => {}
                // The next send opens it and says what is wrong.
                Err(_) => return,
            }
            dropped.clear();
        }
    }
}
