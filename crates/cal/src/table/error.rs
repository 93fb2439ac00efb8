//! What can be wrong with a table, and what to do about it.

use std::io;

use thiserror::Error;

use crate::source::Faulty;
use crate::source::packed::PackedFault;

/// Why a table cannot be read, with its name.
pub type TableError = Faulty<TableFault>;

/// Why a table cannot be read.
#[derive(Debug, Error)]
pub enum TableFault {
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    /// The file is packed and cannot be unpacked.
    #[error(transparent)]
    Packed(#[from] PackedFault),
    /// The file has no row.
    #[error("the file is empty: give a log with at least one row")]
    Empty,
    /// The file is binary and not Parquet, or has no second column under any delimiter.
    #[error("neither Parquet nor text in columns (delimited by comma, semicolon, tab or space)")]
    NotATable,
    /// Text of two bytes a letter.
    #[error("text in UTF-16: save it as UTF-8 (a spreadsheet's \"CSV UTF-8\")")]
    Utf16,
    /// A row has more or fewer cells than the first.
    #[error("line {line}: {found} cells where the first line has {expected}: {likely}")]
    Ragged {
        /// The line, from 1.
        line: u64,
        /// Cells in the line.
        found: usize,
        /// Cells in the first line.
        expected: usize,
        /// What is likely wrong, and what to do.
        likely: &'static str,
    },
    /// Text stands where a number or a time should.
    #[error(
        "line {line}: column '{column}' holds '{text}' where {wanted} should be: correct it, or leave the cell empty"
    )]
    NotANumber {
        /// The line, from 1.
        line: u64,
        /// The column's name.
        column: String,
        /// The cell.
        text: String,
        /// What the column's other cells are, as "a number".
        wanted: &'static str,
    },
    /// A line without end.
    #[error("line {line} is longer than a megabyte: this is no table, or its line feeds are missing")]
    EndlessLine {
        /// The line, from 1.
        line: u64,
    },
    /// A Parquet column is not of a numeric type.
    #[error("column '{column}' is of type {kind}, not numbers: choose another column")]
    NotNumeric {
        /// The column's name.
        column: String,
        /// Its type.
        kind: String,
    },
    /// The Parquet file is damaged or of a kind that is not read.
    #[error("the Parquet file cannot be read: {reason}")]
    Parquet {
        /// What the reader said.
        reason: String,
    },
    /// A column was asked for that is not there.
    #[error("there is no column '{column}'; the columns are {columns}")]
    NoSuchColumn {
        /// The column asked for.
        column: String,
        /// Those there are.
        columns: String,
    },
    /// Two columns have one name.
    #[error(
        "columns {first} and {second} are both called '{column}', and a column is known by its name: give each a name of its own in the header"
    )]
    OneName {
        /// Their name.
        column: String,
        /// The place of the first, from 1.
        first: usize,
        /// The place of the second.
        second: usize,
    },
    /// A rate column was asked for twice.
    #[error("column '{column}' was asked for twice (`rate`): name it once")]
    AskedTwice {
        /// Its name.
        column: String,
    },
    /// The names do not make plain which column is which.
    #[error("{found} could be the {what}: say which (`{what}`); the columns are {columns}")]
    Unclear {
        /// What is looked for, as the parameter is called that says which.
        what: &'static str,
        /// How many columns could be it: "no column" or "more than one column".
        found: &'static str,
        /// The columns there are.
        columns: String,
    },
    /// A name says one unit, and the row of units below it another.
    #[error("column '{column}' says {name} by its name and {row} in the row of units: say which is true (`{what}`)")]
    TwoUnits {
        /// The column's name.
        column: String,
        /// The unit that its name says.
        name: String,
        /// The unit that the row says.
        row: String,
        /// The parameter that says which.
        what: &'static str,
    },
    /// A name says a unit that is not read.
    #[error("column '{column}' is in {unit}, by its name, and that unit is not read: convert it to {instead}")]
    OtherUnit {
        /// The column's name.
        column: String,
        /// The unit that its name says.
        unit: String,
        /// What it is to be in.
        instead: String,
    },
}

impl TableFault {
    /// What is wrong with a file's packing is wrong with its table.
    pub(super) fn named(error: Faulty<PackedFault>) -> TableError {
        Faulty { name: error.name, fault: error.fault.into() }
    }
}
