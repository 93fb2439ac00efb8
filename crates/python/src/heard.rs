//! Work without Python's lock that Ctrl-C ends.

use std::io::{self, Read, Seek, SeekFrom};
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;
use zerorate_cal::source::{ReadSeek, Source};

/// How often Python's signals are looked at: a key is answered at once, and no work is slower for it.
const LOOK: Duration = Duration::from_millis(50);

/// Does the work on a thread of its own. After Ctrl-C the call is over at once, and the work at its next reading.
pub fn heard<T: Send + 'static>(
    py: Python<'_>,
    sources: &[Source],
    work: impl FnOnce(&[Source]) -> T + Send + 'static,
) -> PyResult<T> {
    let stop = Arc::new(AtomicBool::new(false));
    let stoppable = |source: &Source| {
        let stop = Arc::clone(&stop);
        source.read_through(move |reader| Box::new(Stoppable { reader, stop: Arc::clone(&stop) }))
    };
    let sources: Vec<Source> = sources.iter().map(stoppable).collect();
    let (done, mut result) = channel();
    // Nobody takes what comes after Ctrl-C.
    let worker = thread::spawn(move || drop(done.send(work(&sources))));
    loop {
        let waited = &mut result;
        match py.detach(move || waited.recv_timeout(LOOK)) {
            Ok(result) => return Ok(result),
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals().inspect_err(|_| stop.store(true, Ordering::Relaxed))?;
            }
            Err(RecvTimeoutError::Disconnected) => {
                let panic = worker.join().expect_err("a worker without a result has panicked");
                resume_unwind(panic);
            }
        }
    }
}

/// A reader that fails once it was stopped.
struct Stoppable {
    reader: Box<dyn ReadSeek>,
    stop: Arc<AtomicBool>,
}

impl Read for Stoppable {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(io::Error::other("stopped"));
        }
        self.reader.read(into)
    }
}

impl Seek for Stoppable {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.reader.seek(to)
    }
}
