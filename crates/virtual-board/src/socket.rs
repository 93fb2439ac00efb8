//! Where a virtual board listens: TCP, or a pseudo-terminal that looks like a serial port.

use std::fmt;
use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

/// How long an exchange waits for bytes: short against a group, long against a loop that does nothing.
const WAIT: Duration = Duration::from_millis(2);

/// Where a virtual board is to listen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ListenOn {
    /// An address, its port 0 for any free one.
    Tcp(String),
    /// A pseudo-terminal, and a name to find it by.
    Pty(Option<PathBuf>),
}

/// A text that names no such place.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no place to listen: give tcp:ADDRESS:PORT (port 0: any free one), pty, or pty:NAME")]
pub struct UnknownPlace(String);

impl ListenOn {
    /// The same kind of place, any that is free.
    #[must_use]
    pub fn at_any_port(&self) -> Self {
        match self {
            Self::Tcp(address) => Self::Tcp(format!("{}:0", address.rsplit_once(':').map_or("", |(host, _)| host))),
            Self::Pty(_) => Self::Pty(None),
        }
    }
}

impl FromStr for ListenOn {
    type Err = UnknownPlace;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.split_once(':') {
            None if text == "pty" => Ok(Self::Pty(None)),
            Some(("pty", name)) if !name.is_empty() => Ok(Self::Pty(Some(name.into()))),
            Some(("tcp", address)) if address.contains(':') => Ok(Self::Tcp(address.into())),
            _ => Err(UnknownPlace(text.into())),
        }
    }
}

impl fmt::Display for ListenOn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Pty(None) => f.write_str("pty"),
            Self::Pty(Some(name)) => write!(f, "pty:{}", name.display()),
        }
    }
}

/// A place with at most one host at a time.
pub(super) enum Socket {
    Tcp {
        listener: TcpListener,
        address: String,
        host: Option<TcpStream>,
    },
    #[cfg(unix)]
    Pty(pty::Pty),
}

impl Socket {
    pub(super) fn open(on: &ListenOn) -> io::Result<Self> {
        match on {
            ListenOn::Tcp(address) => {
                let listener = TcpListener::bind(address)?;
                listener.set_nonblocking(true)?;
                let address = format!("tcp:{}", listener.local_addr()?);
                Ok(Self::Tcp { listener, address, host: None })
            }
            #[cfg(unix)]
            ListenOn::Pty(name) => pty::Pty::open(name.clone()).map(Self::Pty),
            #[cfg(not(unix))]
            ListenOn::Pty(_) => Err(io::Error::new(io::ErrorKind::Unsupported, "there are no pseudo-terminals here")),
        }
    }

    pub(super) fn address(&self) -> String {
        match self {
            Self::Tcp { address, .. } => address.clone(),
            #[cfg(unix)]
            Self::Pty(pty) => pty.address(),
        }
    }

    /// Whether somebody may be listening.
    pub(super) fn is_connected(&self) -> bool {
        match self {
            Self::Tcp { host, .. } => host.is_some(),
            #[cfg(unix)]
            Self::Pty(_) => true,
        }
    }

    /// The same for a line beside the board's, which is waited for already.
    pub(super) fn look(&mut self, incoming: &mut Vec<u8>, outgoing: &mut Vec<u8>) -> io::Result<()> {
        self.exchange_within(Duration::ZERO, incoming, outgoing)
    }

    /// Takes what has come and gives what can be given, without waiting longer than [`WAIT`].
    pub(super) fn exchange(&mut self, incoming: &mut Vec<u8>, outgoing: &mut Vec<u8>) -> io::Result<()> {
        self.exchange_within(WAIT, incoming, outgoing)
    }

    fn exchange_within(&mut self, wait: Duration, incoming: &mut Vec<u8>, outgoing: &mut Vec<u8>) -> io::Result<()> {
        let lost = match self {
            Self::Tcp { listener, host, .. } => {
                if host.is_none() {
                    *host = accept(listener)?;
                    // Neither half a question of the last host nor an answer to it is the next one's.
                    incoming.clear();
                    outgoing.clear();
                }
                let Some(stream) = host else {
                    std::thread::sleep(wait);
                    return Ok(());
                };
                let lost = pass(stream, incoming, outgoing).is_err();
                if lost {
                    *host = None;
                } else if incoming.is_empty() {
                    std::thread::sleep(wait);
                }
                lost
            }
            #[cfg(unix)]
            Self::Pty(pty) => return pty.exchange(incoming, outgoing),
        };
        if lost {
            outgoing.clear();
        }
        Ok(())
    }
}

fn accept(listener: &TcpListener) -> io::Result<Option<TcpStream>> {
    match listener.accept() {
        Ok((stream, _)) => {
            stream.set_nonblocking(true)?;
            stream.set_nodelay(true)?;
            Ok(Some(stream))
        }
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
        Err(error) => Err(error),
    }
}

/// Both directions once; an error means that the host is gone.
fn pass(stream: &mut (impl Read + Write), incoming: &mut Vec<u8>, outgoing: &mut Vec<u8>) -> io::Result<()> {
    let only_waiting = |error: &io::Error| {
        matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted)
    };
    let mut buffer = [0; 4096];
    match stream.read(&mut buffer) {
        Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
        Ok(length) => incoming.extend_from_slice(&buffer[..length]),
        Err(error) if only_waiting(&error) => {}
        Err(error) => return Err(error),
    }
    if !outgoing.is_empty() {
        match stream.write(outgoing) {
            Ok(written) => drop(outgoing.drain(..written)),
            Err(error) if only_waiting(&error) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

#[cfg(unix)]
mod pty {
    use std::io;
    use std::path::PathBuf;

    use serialport::{SerialPort, TTYPort};

    use super::{WAIT, pass};

    /// Both ends of a pseudo-terminal. The host's end is held open here too, so that hosts may come and go.
    pub struct Pty {
        board: TTYPort,
        host: TTYPort,
        name: Option<PathBuf>,
    }

    impl Pty {
        pub fn open(name: Option<PathBuf>) -> io::Result<Self> {
            // Neither end of a fresh pair is locked: another program can open the host's.
            let (mut board, host) = TTYPort::pair()?;
            board.set_timeout(WAIT)?;
            if let Some(name) = &name {
                if name.is_symlink() {
                    std::fs::remove_file(name)?;
                }
                std::os::unix::fs::symlink(host.name().unwrap_or_default(), name)?;
            }
            Ok(Self { board, host, name })
        }

        pub fn address(&self) -> String {
            let path = self.name.as_ref().map(|name| name.display().to_string());
            format!("serial:{}", path.or_else(|| self.host.name()).unwrap_or_default())
        }

        pub fn exchange(&mut self, incoming: &mut Vec<u8>, outgoing: &mut Vec<u8>) -> io::Result<()> {
            pass(&mut self.board, incoming, outgoing)
        }
    }

    impl Drop for Pty {
        fn drop(&mut self) {
            if let Some(name) = &self.name {
                // It leads nowhere any more; if somebody has taken it away, all the better.
                let _ = std::fs::remove_file(name);
            }
        }
    }
}
