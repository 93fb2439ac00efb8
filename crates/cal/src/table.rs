//! Logs as tables: delimited text or Parquet, read as a stream of batches of columns.
//!
//! The format is recognised by content, never by name. A table is read several times rather than kept: what it holds in
//! memory is a batch.

mod columns;
mod dialect;
mod error;
mod parquet;
mod text;

use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

pub use columns::{Columns, RateUnit, Resolved, TimeUnit, UnitError};
use dialect::Dialect;
pub use error::TableError;

/// Rows in a batch.
const BATCH_ROWS: usize = 8192;

/// The first four bytes of every Parquet file.
const PARQUET_MAGIC: &[u8] = b"PAR1";

/// A log that was opened and recognised.
#[derive(Debug, Clone)]
pub struct TableFile {
    path: PathBuf,
    format: Format,
    names: Vec<String>,
}

#[derive(Debug, Clone)]
enum Format {
    Text(Dialect),
    Parquet,
}

/// Some rows of some columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Batch {
    /// The number of the first row, from 0, the header not counted.
    pub first_row: u64,
    /// One vector a column asked for, in the order asked for, all of one length. A cell that is empty or says nan, na,
    /// null or none is NaN.
    pub columns: Vec<Vec<f64>>,
    /// Where asked for, the text of every cell of every column, a vector a row.
    pub cells: Vec<Vec<String>>,
}

impl Batch {
    /// The number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(self.cells.len(), Vec::len)
    }
}

/// A stream of batches.
pub type Batches = Box<dyn Iterator<Item = Result<Batch, TableError>>>;

impl TableFile {
    /// Opens a file and finds out its format and column names. A text file without a header has `column_1`,
    /// `column_2`, and so on.
    ///
    /// # Errors
    /// When the file cannot be read, is empty, or is neither delimited text nor Parquet.
    pub fn open(path: &Path) -> Result<Self, TableError> {
        let unreadable = |source| TableError::Read { path: path.to_owned(), source };
        let mut file = File::open(path).map_err(unreadable)?;
        let mut start = Vec::new();
        file.by_ref().take(dialect::SAMPLE_BYTES).read_to_end(&mut start).map_err(unreadable)?;
        file.rewind().map_err(unreadable)?;
        let (format, names) = if start.starts_with(PARQUET_MAGIC) {
            (Format::Parquet, parquet::names(path, file)?)
        } else {
            let (dialect, names) = dialect::detect(path, &start)?;
            (Format::Text(dialect), names)
        };
        Ok(Self { path: path.to_owned(), format, names })
    }

    /// The file's path, as it was given.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The names of all columns, in the file's order.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The place of a column.
    ///
    /// # Errors
    /// When there is no such column; the error lists those there are.
    pub fn column(&self, name: &str) -> Result<usize, TableError> {
        self.names.iter().position(|own| own == name).ok_or_else(|| TableError::NoSuchColumn {
            path: self.path.clone(),
            column: name.to_owned(),
            columns: self.names.join(", "),
        })
    }

    /// Streams the numbers of some columns.
    ///
    /// # Errors
    /// When the file cannot be opened or a column holds no numbers; the stream gives an error where a cell is no number.
    pub fn batches(&self, columns: &[usize]) -> Result<Batches, TableError> {
        self.stream(columns, false)
    }

    /// Streams the numbers of some columns and the text of every cell of the table.
    ///
    /// # Errors
    /// As [`TableFile::batches`].
    pub fn batches_with_cells(&self, columns: &[usize]) -> Result<Batches, TableError> {
        self.stream(columns, true)
    }

    fn stream(&self, columns: &[usize], cells: bool) -> Result<Batches, TableError> {
        let file = File::open(&self.path).map_err(|source| TableError::Read { path: self.path.clone(), source })?;
        match &self.format {
            Format::Text(dialect) => {
                Ok(Box::new(text::TextBatches::new(&self.path, file, dialect, &self.names, columns, cells)))
            }
            Format::Parquet => Ok(Box::new(parquet::ParquetBatches::open(&self.path, file, columns, cells)?)),
        }
    }
}

#[cfg(test)]
mod tests;
