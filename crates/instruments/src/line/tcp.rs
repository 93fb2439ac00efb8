//! A line over TCP. What comes late comes on a connection that is closed.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use super::Line;

/// How long a connection may take.
const CONNECT: Duration = Duration::from_secs(2);
/// How long bytes may take to leave.
const SEND: Duration = Duration::from_secs(1);

/// A line over TCP.
pub struct TcpLine {
    address: String,
    stream: Option<TcpStream>,
}

impl TcpLine {
    /// A line to `HOST:PORT`, opened when it is needed.
    #[must_use]
    pub const fn new(address: String) -> Self {
        Self { address, stream: None }
    }

    fn stream(&mut self) -> io::Result<&mut TcpStream> {
        let stream = match self.stream.take() {
            Some(stream) => stream,
            None => connect(&self.address)?,
        };
        Ok(self.stream.insert(stream))
    }
}

fn connect(address: &str) -> io::Result<TcpStream> {
    let mut last = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
    // IPv6 and IPv4.
    for socket in address.to_socket_addrs()?.take(2) {
        match TcpStream::connect_timeout(&socket, CONNECT) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                stream.set_write_timeout(Some(SEND))?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Reads once; `false` when nothing came in time.
fn read(stream: &mut TcpStream, into: &mut Vec<u8>, wait: Duration) -> io::Result<bool> {
    // A wait of nothing would be one without end.
    stream.set_read_timeout(Some(wait.max(Duration::from_millis(1))))?;
    let mut buffer = [0; 512];
    match stream.read(&mut buffer) {
        Ok(0) => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the instrument has closed the connection")),
        Ok(length) => {
            into.extend_from_slice(&buffer[..length]);
            Ok(true)
        }
        Err(error)
            if matches!(
                error.kind(),
                io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted
            ) =>
        {
            Ok(false)
        }
        Err(error) => Err(error),
    }
}

impl Line for TcpLine {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let sent = self.stream()?.write_all(bytes);
        if sent.is_err() {
            self.stream = None;
        }
        sent
    }

    fn receive(&mut self, into: &mut Vec<u8>, wait: Duration) -> io::Result<bool> {
        let heard = read(self.stream()?, into, wait);
        if heard.is_err() {
            self.stream = None;
        }
        heard
    }

    fn drop_heard(&mut self, quiet: Duration) {
        let Some(stream) = &mut self.stream else { return };
        let mut heard = Vec::new();
        while let Ok(true) = read(stream, &mut heard, quiet) {
            heard.clear();
        }
    }

    fn renew(&mut self, _: Duration) {
        self.stream = None;
    }
}
