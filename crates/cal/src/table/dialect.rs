//! How a text table is written, from its first lines: its delimiter, its heading, how its numbers are.

use super::TableFault;
use super::cells::{Splitter, text};
use super::lines::{Lines, without_mark};
use super::value::Notation;
use super::words::says_a_unit;

/// How much of a file is looked at.
pub(super) const SAMPLE_BYTES: u64 = 64 * 1024;

/// Delimiters, the least likely inside a cell first: where several fit, the first does. A semicolon comes before a
/// comma because some countries write numbers with a comma.
const DELIMITERS: [u8; 4] = *b"\t;, ";

/// How a text table is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Dialect {
    /// Between cells. Several spaces are one delimiter; several of another are empty cells.
    pub delimiter: u8,
    /// Lines before the first row, comments not counted: names, and units below them.
    pub heading: u64,
    /// How each column's numbers are written.
    pub notations: Vec<Notation>,
}

/// A dialect, and what the heading says.
#[derive(Debug)]
pub(super) struct Heading {
    pub dialect: Dialect,
    /// The columns' names.
    pub names: Vec<String>,
    /// The columns' units, where a row of them stands below the names; else empty.
    pub units: Vec<String>,
}

/// The dialect, the column names and the units.
pub(super) fn detect(start: &[u8]) -> Result<Heading, TableFault> {
    // Its marks of byte order; every other byte of plain text is a zero in it.
    if start.starts_with(b"\xFF\xFE") || start.starts_with(b"\xFE\xFF") {
        return Err(TableFault::Utf16);
    }
    if start.contains(&0) {
        return Err(TableFault::NotATable);
    }
    let Sample { comment, lines } = Sample::of(start)?;
    let first = lines.first().ok_or(TableFault::Empty)?;
    // The first two lines decide: a later line of another length is an error with its number, not another delimiter.
    let delimiter = DELIMITERS
        .into_iter()
        .find(|&delimiter| {
            let cells = Splitter::new(delimiter).split(first);
            cells > 1 && lines.get(1).is_none_or(|second| Splitter::new(delimiter).split(second) == cells)
        })
        .or_else(|| DELIMITERS.into_iter().find(|&delimiter| Splitter::new(delimiter).split(first) > 1))
        .ok_or(TableFault::NotATable)?;
    let mut splitter = Splitter::new(delimiter);
    let mut rows: Vec<Vec<String>> = lines.iter().map(|line| splitter.texts(line)).collect();
    let columns = rows[0].len();
    let mut heading = 0;
    let (mut names, mut units) = (Vec::new(), vec![String::new(); columns]);
    if rows[0].iter().any(|cell| !is_value(cell, delimiter)) {
        heading = 1;
        names = rows.remove(0);
    } else if let Some(comment) = comment {
        // As numpy.savetxt writes them.
        names = splitter.texts(&comment);
    }
    if heading == 1 && rows.first().is_some_and(|row| row.len() == columns && is_of_units(row, delimiter)) {
        heading = 2;
        units = rows.remove(0);
    }
    let names = if names.len() == columns && names.iter().any(|cell| !is_value(cell, delimiter)) {
        names.iter().map(|cell| name(cell)).collect()
    } else {
        (1..=columns).map(|place| format!("column_{place}")).collect()
    };
    Ok(Heading {
        dialect: Dialect { delimiter, heading, notations: notations(&rows, columns, delimiter) },
        names,
        units,
    })
}

/// The first lines of a text.
struct Sample {
    /// The last comment before the first line that is none, without its sign.
    comment: Option<Vec<u8>>,
    /// The lines that are no comments.
    lines: Vec<Vec<u8>>,
}

impl Sample {
    fn of(start: &[u8]) -> Result<Self, TableFault> {
        let mut sample = Self { comment: None, lines: Vec::new() };
        let mut lines = Lines::new(start);
        let mut is_whole = true;
        while let Some(line) = lines.next()? {
            if !line.is_comment() {
                sample.lines.push(without_mark(line.text).to_vec());
                is_whole = line.is_whole;
            } else if sample.lines.is_empty() {
                let text = without_mark(line.text).trim_ascii_start();
                sample.comment =
                    Some(text.trim_ascii_start().iter().copied().skip_while(|c| b"# ".contains(c)).collect());
            }
        }
        // The sample, or the file, ends in the middle of a line.
        if !is_whole && sample.lines.len() > 1 {
            sample.lines.pop();
        }
        Ok(sample)
    }
}

/// How numbers can be written where cells are delimited so.
fn plain(delimiter: u8) -> &'static [Notation] {
    if delimiter == b',' { &[Notation::Point] } else { &[Notation::Point, Notation::Comma] }
}

/// Whether a cell belongs to a row, and not to its heading.
fn is_value(cell: &str, delimiter: u8) -> bool {
    plain(delimiter).iter().chain([&Notation::Stamp]).any(|notation| notation.number(cell).is_some())
}

/// Whether a line below the names tells units: no number, and at least one unit that is known.
fn is_of_units(row: &[String], delimiter: u8) -> bool {
    let said = || row.iter().filter(|cell| !cell.trim().is_empty());
    said().all(|cell| !is_value(cell, delimiter)) && said().any(|cell| says_a_unit(cell))
}

/// How each column's numbers are written, by the rows of the sample.
fn notations(rows: &[Vec<String>], columns: usize, delimiter: u8) -> Vec<Notation> {
    let cells = |column: usize| rows.iter().filter_map(move |row| row.get(column)).map(String::as_str);
    let is_only = |cell: &str, notation: Notation, other: Notation| {
        notation.number(cell).is_some_and(f64::is_finite) && other.number(cell).is_none()
    };
    let any = |notation, other| (0..columns).flat_map(cells).any(|cell| is_only(cell, notation, other));
    // One country wrote the whole file.
    let is_comma = delimiter != b',' && any(Notation::Comma, Notation::Point) && !any(Notation::Point, Notation::Comma);
    let number = if is_comma { Notation::Comma } else { Notation::Point };
    (0..columns)
        .map(|column| {
            let first = cells(column).find(|cell| !cell.trim().is_empty());
            first.filter(|cell| number.number(cell).is_none()).and_then(Notation::of_stamp).unwrap_or(number)
        })
        .collect()
}

/// A header's cell without the marks that other programs put before it: a byte-order mark, a comment sign, spaces.
fn name(cell: &str) -> String {
    text(without_mark(cell.as_bytes())).trim_start_matches(['#', ' ']).trim().to_owned()
}
