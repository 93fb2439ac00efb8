//! Connections that have not said yet what they want. Where there are too many of them the oldest makes room: who has opened them to
//! keep others out holds none for long.

use std::collections::BTreeMap;
use std::io;
use std::net::{Shutdown, TcpStream};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Them, in the order in which they came.
#[derive(Default)]
pub struct Unheard(Mutex<Came>);

#[derive(Default)]
struct Came {
    next: u64,
    waiting: BTreeMap<u64, TcpStream>,
}

impl Unheard {
    /// Takes one in, and returns its place.
    ///
    /// # Errors
    /// The system has no more of something.
    pub fn enter(&self, stream: &TcpStream) -> io::Result<u64> {
        let own = stream.try_clone()?;
        let mut came = self.lock();
        let place = came.next;
        came.next += 1;
        came.waiting.insert(place, own);
        Ok(place)
    }

    /// It has said what it wants, or is gone.
    pub fn leave(&self, place: u64) {
        self.lock().waiting.remove(&place);
    }

    /// Ends the oldest, if there is one.
    pub fn end_oldest(&self) -> bool {
        let oldest = self.lock().waiting.pop_first();
        // One that is gone has made room already.
        oldest.map(|(_, stream)| stream.shutdown(Shutdown::Both)).is_some()
    }

    fn lock(&self) -> MutexGuard<'_, Came> {
        // Nothing is left half done in it.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
