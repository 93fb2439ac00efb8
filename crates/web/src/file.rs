//! A file of the page, read in slices.

use std::io::{self, BufReader, Read, Seek, SeekFrom};

use zerorate_cal::source::{ReadSeek, Source};

use crate::asked::AskedFile;

/// What is asked of the page at a time, bytes: a question costs as much as reading so many.
const SLICE: usize = 1 << 18;

/// How the page reads a slice: of the file at a place of its list, from a byte on; how many bytes came, or nothing.
pub type ReadSlice = fn(u32, u64, &mut [u8]) -> Option<usize>;

/// The page's file at a place of its list, as a source.
pub fn source(place: u32, file: &AskedFile, slice: ReadSlice) -> Source {
    let length = file.length;
    Source::new(file.name.clone(), move || {
        let file: Box<dyn ReadSeek> =
            Box::new(BufReader::with_capacity(SLICE, PageFile { place, length, at: 0, slice }));
        Ok(file)
    })
}

struct PageFile {
    place: u32,
    length: u64,
    at: u64,
    slice: ReadSlice,
}

impl Read for PageFile {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = (self.slice)(self.place, self.at, into).ok_or_else(|| {
            io::Error::other("the browser cannot read it: if it was changed or moved since, choose it again")
        })?;
        self.at += read as u64;
        Ok(read)
    }
}

impl Seek for PageFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let to = match to {
            SeekFrom::Start(to) => Some(to),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
            SeekFrom::End(by) => self.length.checked_add_signed(by),
        };
        self.at = to.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}
