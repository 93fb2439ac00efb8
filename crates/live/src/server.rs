//! The server: a thread that listens, one that has the parts made, and one for each reader.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use crate::guard::Guard;
use crate::listen::Listen;
use crate::parts::Parts;
use crate::reader;
use crate::unheard::Unheard;

/// How often the parts are made while somebody looks on.
const EVERY: Duration = Duration::from_secs(2);
/// How long the last parts may take to everybody.
const LAST_WITHIN: Duration = Duration::from_secs(2);
/// Connections at a time, those among them that have not said what they want.
const MOST_CONNECTIONS: usize = 128;
/// How long to wait after a connection that could not be taken: the system has no more of something.
const AFTER_A_FAULT: Duration = Duration::from_millis(100);

/// Why nobody can look on.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// Nobody can listen there.
    #[error("cannot listen on {listen}: {source}")]
    Listen {
        /// Where.
        listen: Listen,
        /// What the system says.
        source: io::Error,
    },
    /// The system gives no random bits for a token.
    #[error("there are no random bits for a token, and without one nothing is served beyond this machine: {0}")]
    Token(getrandom::Error),
}

/// A page that is being served; with it the serving ends.
pub struct Live {
    shared: Arc<Shared>,
    address: SocketAddr,
    parts_made: Arc<dyn Fn() -> Vec<(&'static str, String)> + Send + Sync>,
}

struct Shared {
    guard: Guard,
    page: String,
    parts: Parts,
    connections: AtomicUsize,
    unheard: Unheard,
}

impl Live {
    /// Serves a page, and its parts by their ids as `parts` makes them, every two seconds while somebody looks on.
    ///
    /// # Errors
    /// [`LiveError`].
    pub fn open(
        listen: &Listen,
        page: String,
        parts: impl Fn() -> Vec<(&'static str, String)> + Send + Sync + 'static,
    ) -> Result<Self, LiveError> {
        let opened = listen.open();
        let (listener, address) = opened.map_err(|source| LiveError::Listen { listen: listen.clone(), source })?;
        let token = if address.ip().is_loopback() { None } else { Some(token().map_err(LiveError::Token)?) };
        let guard = Guard { token, name: listen.name().map(str::to_owned) };
        let (parts_shown, connections, unheard) = (Parts::default(), AtomicUsize::new(0), Unheard::default());
        let shared = Arc::new(Shared { guard, page, parts: parts_shown, connections, unheard });
        let parts_made: Arc<dyn Fn() -> Vec<(&'static str, String)> + Send + Sync> = Arc::new(parts);
        let own = Arc::clone(&shared);
        thread::spawn(move || accept(&listener, &own));
        let (own, make) = (Arc::clone(&shared), Arc::clone(&parts_made));
        thread::spawn(move || {
            while own.parts.are_wanted() {
                own.parts.put(make());
                own.parts.rest(EVERY);
            }
        });
        Ok(Self { shared, address, parts_made })
    }

    /// Where it listens.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// What to open in a browser, with the token where one is needed.
    #[must_use]
    pub fn url(&self) -> String {
        let host = self.shared.guard.name.as_ref().map_or_else(
            || SocketAddr::new(seen_from_elsewhere(self.address.ip()), self.address.port()).to_string(),
            |name| format!("{name}:{}", self.address.port()),
        );
        let token = self.shared.guard.token.as_ref().map(|token| format!("?token={token}")).unwrap_or_default();
        format!("http://{host}/{token}")
    }

    /// The parts are made a last time and sent to all that look on, with word that nothing comes after them. A reader that does
    /// not read is not waited for.
    pub fn finish(&self) {
        self.shared.parts.put_last((self.parts_made)());
        self.shared.parts.until_alone(LAST_WITHIN);
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.shared.parts.close();
        // Whoever listens looks up.
        let here = if self.address.is_ipv4() { IpAddr::from(Ipv4Addr::LOCALHOST) } else { Ipv6Addr::LOCALHOST.into() };
        let own = if self.address.ip().is_unspecified() { here } else { self.address.ip() };
        let _ = TcpStream::connect_timeout(&SocketAddr::new(own, self.address.port()), AFTER_A_FAULT);
    }
}

/// An address of this machine that others can open: who listens on all of them has none of its own.
fn seen_from_elsewhere(address: IpAddr) -> IpAddr {
    if !address.is_unspecified() {
        return address;
    }
    // Nothing is sent: the system only says by which address it would send there (RFC 5737, RFC 3849).
    let there: SocketAddr = match address {
        IpAddr::V4(_) => (Ipv4Addr::new(192, 0, 2, 1), 9).into(),
        IpAddr::V6(_) => (Ipv6Addr::new(0x2001, 0xdb8, 0, 0, 0, 0, 0, 1), 9).into(),
    };
    let socket =
        UdpSocket::bind((address, 0)).and_then(|socket| socket.connect(there).and_then(|()| socket.local_addr()));
    match (socket, address) {
        (Ok(own), _) => own.ip(),
        (Err(_), IpAddr::V4(_)) => Ipv4Addr::LOCALHOST.into(),
        (Err(_), IpAddr::V6(_)) => Ipv6Addr::LOCALHOST.into(),
    }
}

/// 128 random bits in hexadecimal digits.
fn token() -> Result<String, getrandom::Error> {
    let mut bits = [0; 16];
    getrandom::fill(&mut bits)?;
    Ok(bits.iter().map(|byte| format!("{byte:02x}")).collect())
}

fn accept(listener: &TcpListener, shared: &Arc<Shared>) {
    for stream in listener.incoming() {
        if shared.parts.is_closed() {
            return;
        }
        let Ok(stream) = stream else {
            thread::sleep(AFTER_A_FAULT);
            continue;
        };
        if shared.connections.load(Ordering::SeqCst) >= MOST_CONNECTIONS && !shared.unheard.end_oldest() {
            continue;
        }
        let Ok(place) = shared.unheard.enter(&stream) else { continue };
        shared.connections.fetch_add(1, Ordering::SeqCst);
        let own = Arc::clone(shared);
        let started = thread::Builder::new().name("looks on".into()).spawn(move || {
            let heard = || own.unheard.leave(place);
            // A reader that is gone is nobody's fault.
            let _ = reader::serve(stream, &own.guard, &own.page, &own.parts, heard);
            own.unheard.leave(place);
            own.connections.fetch_sub(1, Ordering::SeqCst);
        });
        if started.is_err() {
            shared.unheard.leave(place);
            shared.connections.fetch_sub(1, Ordering::SeqCst);
        }
    }
}
