//! A file as a window of bytes that moves forward over it, whatever the file's length.

use std::io::{self, Read, Seek};

use crate::Remark;

/// Bytes in the window: more than any message has.
const WINDOW_BYTES: usize = 1 << 20;

/// The bytes of a reader from some position on.
pub(super) struct Window<R> {
    reader: R,
    bytes: Vec<u8>,
    start: usize,
    end: usize,
    position: u64,
}

impl<R: Read> Window<R> {
    /// A window at the reader's position, which is called 0.
    pub(super) fn new(reader: R) -> Self {
        Self { reader, bytes: vec![0; WINDOW_BYTES], start: 0, end: 0, position: 0 }
    }

    /// How many bytes have been passed.
    pub(super) fn position(&self) -> u64 {
        self.position
    }

    /// The bytes from here on: at least as many as asked for, but for the end of the file.
    pub(super) fn peek(&mut self, least: usize) -> io::Result<&[u8]> {
        if self.end - self.start < least {
            self.bytes.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            self.start = 0;
            while self.end < least.min(WINDOW_BYTES) {
                match self.reader.read(&mut self.bytes[self.end..]) {
                    Ok(0) => break,
                    Ok(read) => self.end += read,
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(error) => return Err(error),
                }
            }
        }
        Ok(&self.bytes[self.start..self.end])
    }

    /// Passes some of the bytes that were peeked at.
    pub(super) fn pass(&mut self, bytes: usize) {
        let bytes = bytes.min(self.end - self.start);
        self.start += bytes;
        self.position += bytes as u64;
    }

    /// Passes bytes until one of a place is told by `found`, which is shown at least `least` bytes from each place on, or
    /// fewer at the end of the file. Gives the number of bytes passed.
    pub(super) fn seek(&mut self, least: usize, found: impl Fn(&[u8]) -> bool) -> io::Result<u64> {
        let begin = self.position;
        loop {
            let bytes = self.peek(least)?;
            if bytes.is_empty() {
                return Ok(self.position - begin);
            }
            let is_end = bytes.len() < least;
            let places = if is_end { bytes.len() } else { bytes.len() - least + 1 };
            let place = (0..places).find(|place| found(&bytes[*place..]));
            self.pass(place.unwrap_or(places));
            if place.is_some() {
                return Ok(self.position - begin);
            }
        }
    }
}

impl<R: Read + Seek> Window<R> {
    /// Goes back to the beginning of the file.
    pub(super) fn rewind(&mut self) -> io::Result<()> {
        self.reader.rewind()?;
        (self.start, self.end, self.position) = (0, 0, 0);
        Ok(())
    }
}

/// What a damaged or cut file lost.
#[derive(Debug, Default)]
pub(super) struct Damage {
    /// Bytes passed over because they are no message.
    pub(super) skipped: u64,
    /// Where the file ends in the middle of a message.
    pub(super) cut_at: Option<u64>,
}

impl Damage {
    /// Tells of it.
    pub(super) fn remarks(&self) -> impl Iterator<Item = Remark> {
        let damaged = (self.skipped > 0).then_some(Remark::Damaged { bytes: self.skipped });
        self.cut_at.map(|at| Remark::Cut { at }).into_iter().chain(damaged)
    }
}
