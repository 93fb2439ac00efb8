//! A line over TCP: a board behind a serial server, or a virtual one.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use super::threaded::LISTEN;
use super::{Link, LinkError, ThreadedLink};

/// How long each address of a host is tried.
const CONNECT: Duration = Duration::from_secs(2);
/// How long a frame may take to leave.
const SEND: Duration = Duration::from_secs(1);

/// Connects to `host:port`.
///
/// # Errors
/// [`LinkError::NotOpened`], with what to do.
pub fn open(address: &str) -> Result<Box<dyn Link>, LinkError> {
    let failed = |error: io::Error, remedy| {
        let reason = error.to_string();
        let reason = reason.split(" (os error").next().unwrap_or(&reason).to_owned();
        LinkError::NotOpened { line: format!("tcp:{address}"), reason, remedy }
    };
    let found = address.to_socket_addrs().map_err(|error| failed(error, "check the host's name"))?;
    let unreachable = |error: io::Error| {
        let remedy = match error.kind() {
            io::ErrorKind::ConnectionRefused => {
                "nothing listens there: start the board's server first, or check the port"
            }
            _ => "check host, port and network",
        };
        failed(error, remedy)
    };
    let mut last = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
    // Two addresses are enough for a host that answers at all (IPv6 and IPv4), and keep the wait under five seconds.
    for socket in found.take(2) {
        match TcpStream::connect_timeout(&socket, CONNECT).and_then(halves) {
            Ok((reader, writer)) => return Ok(Box::new(ThreadedLink::new(reader, writer))),
            Err(error) => last = error,
        }
    }
    Err(unreachable(last))
}

fn halves(stream: TcpStream) -> io::Result<(TcpStream, TcpStream)> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(LISTEN))?;
    stream.set_write_timeout(Some(SEND))?;
    Ok((stream.try_clone()?, stream))
}
