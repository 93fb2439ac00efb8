//! Where to listen.

use std::fmt;
use std::io;
use std::net::{IpAddr, SocketAddr, TcpListener, ToSocketAddrs};
use std::str::FromStr;

/// An address of this machine: a name or a number, and a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listen {
    host: String,
    port: u16,
}

/// A text that names no place to listen.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no place to listen: give ADDRESS:PORT, as 127.0.0.1:5495 (port 0: any free one)")]
pub struct UnknownListen(String);

impl Listen {
    /// The same address at any free port.
    #[must_use]
    pub fn at_any_port(&self) -> Self {
        Self { host: self.host.clone(), port: 0 }
    }

    /// The same address at the port so many after it; a port 0 stays any free one.
    ///
    /// # Errors
    /// When there is no such port.
    pub fn after(&self, ports: usize) -> Result<Self, UnknownListen> {
        let next = u16::try_from(ports).ok().and_then(|ports| self.port.checked_add(ports));
        let port = if self.port == 0 {
            0
        } else {
            next.ok_or_else(|| UnknownListen(format!("{self} and the ports after it")))?
        };
        Ok(Self { host: self.host.clone(), port })
    }

    /// The name by which a browser may ask for it, where it was given by one.
    pub(crate) fn name(&self) -> Option<&str> {
        self.host.parse::<IpAddr>().is_err().then_some(self.host.as_str())
    }

    /// Listens there; says where that is.
    pub(crate) fn open(&self) -> io::Result<(TcpListener, SocketAddr)> {
        let places: Vec<SocketAddr> = (self.host.as_str(), self.port).to_socket_addrs()?.collect();
        let listener = TcpListener::bind(&places[..])?;
        let address = listener.local_addr()?;
        Ok((listener, address))
    }
}

impl FromStr for Listen {
    type Err = UnknownListen;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let unknown = || UnknownListen(text.into());
        let (host, port) = text.rsplit_once(':').ok_or_else(unknown)?;
        let in_brackets = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
        let host = in_brackets.unwrap_or(host);
        let is_one = !host.is_empty() && (in_brackets.is_some() || !host.contains(':'));
        let port = port.parse().map_err(|_| unknown())?;
        if is_one { Ok(Self { host: host.to_ascii_lowercase(), port }) } else { Err(unknown()) }
    }
}

impl fmt::Display for Listen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.host.contains(':') {
            write!(f, "[{}]:{}", self.host, self.port)
        } else {
            write!(f, "{}:{}", self.host, self.port)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_a_host_and_a_port() {
        for text in ["127.0.0.1:0", "localhost:5495", "[::1]:80", "0.0.0.0:5495"] {
            assert_eq!(text.parse::<Listen>().unwrap().to_string(), text);
        }
        for text in ["", "5495", ":5495", "127.0.0.1", "::1:5495", "127.0.0.1:http", "127.0.0.1:70000", "[]:1"] {
            assert!(text.parse::<Listen>().is_err(), "{text}");
        }
    }
}
