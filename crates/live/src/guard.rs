//! Who may look on.

use std::net::{IpAddr, SocketAddr};

/// What a request must know and name.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Guard {
    /// What must stand in the address; nothing on loopback.
    pub token: Option<String>,
    /// A name of this machine, beside its numbers.
    pub name: Option<String>,
}

impl Guard {
    /// Whether this is the token, in a time that does not tell how much of it is right.
    pub(crate) fn knows(&self, given: Option<&str>) -> bool {
        let Some(token) = &self.token else { return true };
        let given = given.unwrap_or_default();
        let differences = token.bytes().zip(given.bytes()).fold(0, |all, (own, other)| all | (own ^ other));
        token.len() == given.len() && differences == 0
    }

    /// Whether the host that a request names is this one. A page of another site that has its name point here names its own.
    /// The port is another one through a tunnel.
    pub(crate) fn is_here(&self, authority: &str, local: SocketAddr) -> bool {
        let Some(host) = host_of(authority) else { return false };
        let local = local.ip().to_canonical();
        match host.parse::<IpAddr>() {
            Ok(number) => number.to_canonical() == local || (number.is_loopback() && local.is_loopback()),
            Err(_) => host == "localhost" && local.is_loopback() || self.name.as_ref().is_some_and(|own| *own == host),
        }
    }
}

/// The host of `host`, `host:port` or `[v6]:port`, in lower case.
fn host_of(authority: &str) -> Option<String> {
    let host = match authority.strip_prefix('[') {
        Some(rest) => {
            let (host, port) = rest.split_once(']')?;
            is_port(port).then_some(host)?
        }
        None => match authority.split_once(':') {
            Some((host, port)) => port.bytes().all(|digit| digit.is_ascii_digit()).then_some(host)?,
            None => authority,
        },
    };
    (!host.is_empty()).then(|| host.to_ascii_lowercase())
}

/// Whether this is what may stand behind a bracket: nothing, or a colon and a number.
fn is_port(text: &str) -> bool {
    text.is_empty() || text.strip_prefix(':').is_some_and(|port| port.bytes().all(|digit| digit.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_its_own_names_are_here() {
        let loopback: SocketAddr = "127.0.0.1:5495".parse().unwrap();
        let lan: SocketAddr = "192.168.1.7:5495".parse().unwrap();
        let guard = Guard { token: None, name: Some("bench-3".into()) };
        for authority in ["127.0.0.1:5495", "localhost", "LOCALHOST:8000", "[::1]:5495", "bench-3:5495"] {
            assert!(guard.is_here(authority, loopback), "{authority}");
        }
        for authority in
            ["", ":80", "evil.example", "127.0.0.1.evil.example:5495", "localhost:x", "[::1", "192.168.1.7"]
        {
            assert!(!guard.is_here(authority, loopback), "{authority}");
        }
        assert!(guard.is_here("192.168.1.7:5495", lan) && guard.is_here("Bench-3", lan));
        assert!(!guard.is_here("localhost:5495", lan) && !guard.is_here("127.0.0.1", lan));
        // Who listens on all addresses of both kinds sees the old numbers in the new form.
        assert!(guard.is_here("10.0.0.2", "[::ffff:10.0.0.2]:80".parse().unwrap()));
    }

    #[test]
    fn a_token_is_known_whole_or_not_at_all() {
        let guard = Guard { token: Some("0123abcd".into()), name: None };
        assert!(guard.knows(Some("0123abcd")));
        for given in [None, Some(""), Some("0123abc"), Some("0123abcd0"), Some("1123abcd")] {
            assert!(!guard.knows(given), "{given:?}");
        }
        assert!(Guard::default().knows(None));
    }
}
