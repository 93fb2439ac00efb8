#![doc = include_str!("../README.md")]

pub mod packed;
// A browser has no files to write.
#[cfg(not(target_family = "wasm"))]
pub mod whole_file;

use std::fmt;
use std::fs::File;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use thiserror::Error;

/// Something that reads and seeks, on any thread.
pub trait ReadSeek: Read + Seek + Send {}

impl<R: Read + Seek + Send> ReadSeek for R {}

/// How a source is opened, from its beginning, as often as it is asked for.
type Open = dyn Fn() -> io::Result<Box<dyn ReadSeek>> + Send + Sync;

/// Something that can be read, again and again.
#[derive(Clone)]
pub struct Source {
    name: String,
    /// Where a file is.
    path: Option<PathBuf>,
    open: Arc<Open>,
}

/// A fault of something that was read, with its name in front.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{name}: {fault}")]
pub struct Faulty<F: fmt::Display> {
    /// The source's name.
    pub name: String,
    /// What is wrong with it.
    pub fault: F,
}

/// What a parser says of a file, with quotes around names that stand in the file: backticks are for parameters.
#[must_use]
pub fn in_quotes(said: &str) -> String {
    said.replace('`', "'")
}

/// The line of a text, from 1, that a byte of it stands in: where a parser stopped.
#[must_use]
pub fn line_at(text: &str, byte: usize) -> usize {
    1 + text.bytes().take(byte).filter(|byte| *byte == b'\n').count()
}

impl Source {
    /// A file.
    #[must_use]
    pub fn file(path: &Path) -> Self {
        let own = path.to_owned();
        let name = path.display().to_string();
        Self { path: Some(path.to_owned()), ..Self::new(name, move || Ok(Box::new(File::open(&own)?))) }
    }

    /// Bytes in memory.
    #[must_use]
    pub fn bytes(name: impl Into<String>, bytes: impl Into<Arc<[u8]>>) -> Self {
        let bytes = bytes.into();
        Self::new(name, move || Ok(Box::new(Cursor::new(Arc::clone(&bytes)))))
    }

    /// Whatever `open` gives, each time from its beginning.
    #[must_use]
    pub fn new(
        name: impl Into<String>,
        open: impl Fn() -> io::Result<Box<dyn ReadSeek>> + Send + Sync + 'static,
    ) -> Self {
        Self { name: name.into(), path: None, open: Arc::new(open) }
    }

    /// The same, read through what `wrap` makes of each reader: one that can be stopped, one that counts.
    #[must_use]
    pub fn read_through(&self, wrap: impl Fn(Box<dyn ReadSeek>) -> Box<dyn ReadSeek> + Send + Sync + 'static) -> Self {
        let open = Arc::clone(&self.open);
        Self { open: Arc::new(move || open().map(&wrap)), ..self.clone() }
    }

    /// The name for messages: a file's path as it was given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The name without folders.
    #[must_use]
    pub fn short_name(&self) -> &str {
        Path::new(&self.name).file_name().and_then(|name| name.to_str()).unwrap_or(&self.name)
    }

    /// Opens it from its beginning.
    ///
    /// # Errors
    /// What the system says.
    pub fn open(&self) -> io::Result<Box<dyn ReadSeek>> {
        (self.open)()
    }

    /// As many of its first bytes as there are, `most` at most.
    ///
    /// # Errors
    /// What the system says.
    pub fn start(&self, most: u64) -> io::Result<Vec<u8>> {
        let mut start = Vec::new();
        self.open()?.take(most).read_to_end(&mut start)?;
        Ok(start)
    }

    /// Its length, bytes.
    ///
    /// # Errors
    /// What the system says.
    pub fn length(&self) -> io::Result<u64> {
        self.open()?.seek(SeekFrom::End(0))
    }

    /// When a file was last changed, as its file system says.
    #[must_use]
    pub fn changed(&self) -> Option<SystemTime> {
        self.path.as_ref()?.metadata().ok()?.modified().ok()
    }

    /// A fault of this source, with its name.
    #[must_use]
    pub fn faulty<F: fmt::Display>(&self, fault: impl Into<F>) -> Faulty<F> {
        Faulty { name: self.name.clone(), fault: fault.into() }
    }
}

impl<P: AsRef<Path> + ?Sized> From<&P> for Source {
    fn from(path: &P) -> Self {
        Self::file(path.as_ref())
    }
}

impl fmt::Debug for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Source").field(&self.name).finish()
    }
}
