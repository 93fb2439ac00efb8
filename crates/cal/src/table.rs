//! Logs as tables: delimited text or Parquet, read as a stream of batches of columns.
//!
//! Text is as people have it: with commas, semicolons, tabs or spaces between cells, decimal commas where the cells leave
//! room for them, lines of comment (`#`), a row of units below the names, ISO times. The format is recognised by
//! content, never by name. A table is read several times rather than kept: what it holds in memory is a batch.

mod ahead;
mod cells;
mod columns;
mod dialect;
mod error;
mod lines;
mod parquet;
mod text;
mod value;
mod words;

pub use columns::{Columns, Resolved, ResolvedRate, ResolvedSensor};
use dialect::{Dialect, Heading};
pub use error::{TableError, TableFault};
use value::Notation;
pub use words::named_in;
pub(crate) use words::words;

use crate::recording::parquet_source::PARQUET_MAGIC;
use crate::source::Source;
use crate::source::packed::unpacked;
use crate::units::TimeUnit;

/// Rows in a batch.
const BATCH_ROWS: usize = 8192;

/// A log that was opened and recognised.
#[derive(Debug, Clone)]
pub struct Table {
    source: Source,
    format: Format,
    names: Vec<String>,
    /// The columns' units, where a row of them stands below the names; else empty.
    units: Vec<String>,
    /// Of each column of times that are told as such, what they are.
    clocks: Vec<Option<Clock>>,
}

/// What a column of times is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Clock {
    unit: TimeUnit,
    /// Whether they are of a zone that is known: of others only differences are.
    is_utc: bool,
}

#[derive(Debug, Clone)]
enum Format {
    Text(Dialect),
    Parquet,
}

impl Clock {
    fn of(notation: Notation) -> Option<Self> {
        match notation {
            Notation::Stamp => Some(Self { unit: TimeUnit::S, is_utc: true }),
            Notation::LocalStamp => Some(Self { unit: TimeUnit::S, is_utc: false }),
            Notation::Point | Notation::Comma => None,
        }
    }
}

/// Some rows of some columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Batch {
    /// The number of the first row, from 0, the header not counted.
    pub first_row: u64,
    /// One vector a column asked for, in the order asked for, all of one length. A cell that is empty or says nan, na,
    /// null or none is NaN.
    pub columns: Vec<Vec<f64>>,
    /// Where asked for, the text of every cell of every column, a vector a row: numbers with decimal points.
    pub cells: Vec<Vec<String>>,
    /// The number of the file's last line, where it ends without a line feed: its last number may be cut short, so it is
    /// not among the rows.
    pub cut_line: Option<u64>,
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

impl Table {
    /// Opens a file and finds out its format and column names. A text file without a header has `column_1`,
    /// `column_2`, and so on.
    ///
    /// # Errors
    /// When the file cannot be read, is empty, or is neither delimited text nor Parquet.
    pub fn open(source: &Source) -> Result<Self, TableError> {
        let faulty = |fault: TableFault| source.faulty(fault);
        let source = unpacked(source).map_err(TableFault::named)?;
        let start = source.start(dialect::SAMPLE_BYTES).map_err(|error| faulty(error.into()))?;
        if start.starts_with(PARQUET_MAGIC) {
            let (names, clocks) = parquet::columns(&source).map_err(faulty)?;
            let units = vec![String::new(); names.len()];
            return Ok(Self { source, format: Format::Parquet, names, units, clocks });
        }
        let Heading { dialect, names, units } = dialect::detect(&start).map_err(faulty)?;
        let clocks = dialect.notations.iter().map(|notation| Clock::of(*notation)).collect();
        Ok(Self { source, format: Format::Text(dialect), names, units, clocks })
    }

    /// Where it is read from.
    #[must_use]
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// The names of all columns, in the file's order.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The place of a column.
    ///
    /// # Errors
    /// When there is no such column (the error lists those there are), or there are two.
    pub fn column(&self, name: &str) -> Result<usize, TableError> {
        let mut places = (0..self.names.len()).filter(|&place| self.names[place] == name);
        let column = name.to_owned();
        match (places.next(), places.next()) {
            (Some(only), None) => Ok(only),
            (Some(first), Some(second)) => {
                Err(self.source.faulty(TableFault::OneName { column, first: first + 1, second: second + 1 }))
            }
            (None, _) => Err(self.source.faulty(TableFault::NoSuchColumn { column, columns: self.names.join(", ") })),
        }
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
    /// As [`Table::batches`].
    pub fn batches_with_cells(&self, columns: &[usize]) -> Result<Batches, TableError> {
        self.stream(columns, true)
    }

    /// Whether a column's numbers rise, or stay, as far as its first batch goes; not where it holds none.
    fn never_falls(&self, column: usize) -> Result<bool, TableError> {
        let Some(first) = self.batches(&[column])?.next().transpose()? else { return Ok(false) };
        let numbers: Vec<f64> = first.columns[0].iter().copied().filter(|number| number.is_finite()).collect();
        Ok(numbers.len() > 1 && numbers.is_sorted())
    }

    fn stream(&self, columns: &[usize], cells: bool) -> Result<Batches, TableError> {
        let source = self.source.clone();
        let faulty = |fault| self.source.faulty(fault);
        let named = move |batch: Result<Batch, TableFault>| batch.map_err(|fault| source.faulty(fault));
        match &self.format {
            Format::Text(dialect) => {
                let reader = self.source.open().map_err(|error| faulty(error.into()))?;
                let batches = text::TextBatches::new(reader, dialect, &self.names, columns, cells);
                Ok(ahead::ahead(batches.map(named)))
            }
            Format::Parquet => {
                let batches = parquet::ParquetBatches::open(&self.source, columns, cells).map_err(faulty)?;
                Ok(ahead::ahead(batches.map(named)))
            }
        }
    }
}

#[cfg(test)]
mod tests;
