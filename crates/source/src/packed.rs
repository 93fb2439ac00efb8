//! Files that are packed: gzip, and a zip with one file in it. What is inside is a source like another.
//!
//! Nothing is unpacked into memory or onto the disk: a packed file is read through, again from its beginning where it is
//! sought in, so that what a small file unpacks to may be larger than both.

use std::io::{self, BufReader, Read, Seek, SeekFrom};

use flate2::CrcReader;
use flate2::bufread::{DeflateDecoder, MultiGzDecoder};
use thiserror::Error;
use zip::{CompressionMethod, ZipArchive};

use crate::{Faulty, Source};

const GZIP_MAGIC: &[u8] = b"\x1F\x8B\x08";
/// Of a zip's first entry, and of a zip without one.
const ZIP_MAGIC: [&[u8]; 2] = [b"PK\x03\x04", b"PK\x05\x06"];
const MAGIC_BYTES: u64 = 4;

/// Why a packed file cannot be read.
#[derive(Debug, Error)]
pub enum PackedFault {
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    /// The zip's directory is damaged or not there.
    #[error("the zip cannot be read: {reason}: pack the log again, or unpack it and give it as it is")]
    Zip {
        /// What the reader said.
        reason: String,
    },
    /// There is not exactly one file in the zip.
    #[error("the zip holds {found}: unpack it and give the log that you mean")]
    NotOne {
        /// The files, or that there is none.
        found: String,
    },
    /// The entry is encrypted or packed by a method other than deflate.
    #[error("'{entry}' in the zip is {how}, which is not read: unpack it and give it as it is")]
    Method {
        /// The file in the zip.
        entry: String,
        /// What it is.
        how: &'static str,
    },
}

/// What is inside, if a source is packed; else the source itself. It keeps its name.
///
/// # Errors
/// When it cannot be read, or a zip does not hold exactly one file that can be unpacked.
pub fn unpacked(source: &Source) -> Result<Source, Faulty<PackedFault>> {
    let start = source.start(MAGIC_BYTES).map_err(|error| source.faulty(error))?;
    let raw = source.clone();
    if start.starts_with(GZIP_MAGIC) {
        return Ok(Source::new(source.name(), move || {
            let raw = raw.clone();
            Ok(Box::new(Unpacked::new(move || Ok(Box::new(MultiGzDecoder::new(BufReader::new(raw.open()?)))))?))
        }));
    }
    if ZIP_MAGIC.iter().any(|magic| start.starts_with(magic)) {
        let entry = Entry::only(source).map_err(|fault| source.faulty::<PackedFault>(fault))?;
        return Ok(Source::new(source.name(), move || {
            let raw = raw.clone();
            Ok(Box::new(Unpacked::new(move || entry.open(&raw))?))
        }));
    }
    Ok(raw)
}

/// Where a zip's one file lies in it.
#[derive(Debug, Clone, Copy)]
struct Entry {
    start: u64,
    packed: u64,
    crc_32: u32,
    is_deflated: bool,
}

impl Entry {
    fn only(source: &Source) -> Result<Self, PackedFault> {
        let damaged = |error: zip::result::ZipError| match error {
            zip::result::ZipError::Io(error) => PackedFault::Read(error),
            other => PackedFault::Zip { reason: other.to_string() },
        };
        let mut zip = ZipArchive::new(BufReader::new(source.open()?)).map_err(damaged)?;
        let mut entries = Vec::new();
        for (place, name) in zip.file_names().enumerate() {
            entries.extend(is_file(name).then(|| (place, name.to_owned())));
        }
        let [(place, name)] = &entries[..] else {
            let found = if entries.is_empty() { "no file".to_owned() } else { several(&entries) };
            return Err(PackedFault::NotOne { found });
        };
        let file = zip.by_index_raw(*place).map_err(damaged)?;
        let refused = |how| PackedFault::Method { entry: name.clone(), how };
        if file.encrypted() {
            return Err(refused("encrypted"));
        }
        let is_deflated = match file.compression() {
            CompressionMethod::Stored => false,
            CompressionMethod::Deflated => true,
            _ => return Err(refused("packed by a method other than deflate")),
        };
        let start = file.data_start().ok_or_else(|| refused("nowhere in the file"))?;
        Ok(Self { start, packed: file.compressed_size(), crc_32: file.crc32(), is_deflated })
    }

    fn open(self, source: &Source) -> io::Result<Box<dyn Read + Send>> {
        let mut raw = source.open()?;
        raw.seek(SeekFrom::Start(self.start))?;
        let raw = BufReader::new(raw.take(self.packed));
        Ok(if self.is_deflated {
            Box::new(Checked { reader: CrcReader::new(DeflateDecoder::new(raw)), crc_32: self.crc_32 })
        } else {
            Box::new(Checked { reader: CrcReader::new(raw), crc_32: self.crc_32 })
        })
    }
}

/// Whether an entry is a file that somebody packed, and not a folder or what an operating system adds.
fn is_file(name: &str) -> bool {
    !name.ends_with('/') && !name.starts_with("__MACOSX/") && !name.ends_with(".DS_Store")
}

/// The first names, and how many more there are.
fn several(entries: &[(usize, String)]) -> String {
    const SHOWN: usize = 5;
    let shown: Vec<&str> = entries.iter().take(SHOWN).map(|(_, name)| name.as_str()).collect();
    let more = entries.len() - shown.len();
    let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("several files ({}{rest})", shown.join(", "))
}

/// A zip's file, whose check sum must be right where it ends. (A gzip's reader looks at its own.)
struct Checked<R> {
    reader: CrcReader<R>,
    crc_32: u32,
}

impl<R: Read> Read for Checked<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.reader.read(into)?;
        if read == 0 && !into.is_empty() && self.reader.crc().sum() != self.crc_32 {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                "what is in the zip is damaged: its check sum is wrong",
            ));
        }
        Ok(read)
    }
}

/// How the packed bytes are read, from their beginning.
type Open = dyn Fn() -> io::Result<Box<dyn Read + Send>> + Send;

/// What is inside, as something that can be sought in: back by beginning anew, on by reading over it.
struct Unpacked {
    open: Box<Open>,
    reader: Box<dyn Read + Send>,
    place: u64,
}

impl Unpacked {
    fn new(open: impl Fn() -> io::Result<Box<dyn Read + Send>> + Send + 'static) -> io::Result<Self> {
        let reader = open()?;
        Ok(Self { open: Box::new(open), reader, place: 0 })
    }

    fn skip(&mut self, bytes: u64) -> io::Result<u64> {
        io::copy(&mut self.by_ref().take(bytes), &mut io::sink())
    }
}

impl Read for Unpacked {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.reader.read(into).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => {
                io::Error::new(error.kind(), "the packed file ends before its contents: copy it again, whole")
            }
            io::ErrorKind::InvalidInput => {
                io::Error::new(error.kind(), format!("the packed file is damaged ({error}): copy it again"))
            }
            _ => error,
        })?;
        self.place += read as u64;
        Ok(read)
    }
}

impl Seek for Unpacked {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let wanted = match to {
            SeekFrom::Start(place) => Some(place),
            SeekFrom::Current(by) => self.place.checked_add_signed(by),
            SeekFrom::End(by) => {
                self.skip(u64::MAX)?;
                self.place.checked_add_signed(by)
            }
        };
        let before = || io::Error::new(io::ErrorKind::InvalidInput, "sought before the beginning");
        let wanted = wanted.ok_or_else(before)?;
        if wanted < self.place {
            self.reader = (self.open)()?;
            self.place = 0;
        }
        self.skip(wanted - self.place)?;
        Ok(self.place)
    }
}

#[cfg(test)]
mod tests;
