//! What can be wrong with a table, and what to do about it.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Why a table cannot be read.
#[derive(Debug, Error)]
pub enum TableError {
    /// The file cannot be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file has no row.
    #[error("{}: the file is empty: give a log with at least one row", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The file is binary and not Parquet, or has no second column under any delimiter.
    #[error("{}: neither Parquet nor text in columns (delimited by comma, semicolon, tab or space)", path.display())]
    NotATable {
        /// The file.
        path: PathBuf,
    },
    /// A row has more or fewer cells than the first.
    #[error("{}:{line}: {found} cells where the first line has {expected}: the line is cut off or damaged", path.display())]
    Ragged {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// Cells in the line.
        found: usize,
        /// Cells in the first line.
        expected: usize,
    },
    /// Text stands where a number should.
    #[error(
        "{}:{line}: column '{column}' holds '{text}' where a number should be: correct it, or leave the cell empty",
        path.display()
    )]
    NotANumber {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// The column's name.
        column: String,
        /// The cell.
        text: String,
    },
    /// A Parquet column is not of a numeric type.
    #[error("{}: column '{column}' is of type {kind}, not numbers: choose another column", path.display())]
    NotNumeric {
        /// The file.
        path: PathBuf,
        /// The column's name.
        column: String,
        /// Its type.
        kind: String,
    },
    /// The Parquet file is damaged or of a kind that is not read.
    #[error("{}: the Parquet file cannot be read: {reason}", path.display())]
    Parquet {
        /// The file.
        path: PathBuf,
        /// What the reader said.
        reason: String,
    },
    /// A column was asked for that is not there.
    #[error("{}: there is no column '{column}'; the columns are {columns}", path.display())]
    NoSuchColumn {
        /// The file.
        path: PathBuf,
        /// The column asked for.
        column: String,
        /// Those there are.
        columns: String,
    },
    /// The names do not make plain which column is which.
    #[error("{}: {found} could be the {what}: say which with {option}; the columns are {columns}", path.display())]
    Unclear {
        /// The file.
        path: PathBuf,
        /// What is looked for.
        what: &'static str,
        /// How many columns could be it: "no column" or "more than one column".
        found: &'static str,
        /// The option that says so.
        option: &'static str,
        /// The columns there are.
        columns: String,
    },
}
