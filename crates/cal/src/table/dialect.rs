//! The delimiter and the header of a text table, from its first lines.

use super::TableFault;

/// How much of a file is looked at.
pub(super) const SAMPLE_BYTES: u64 = 64 * 1024;

/// Delimiters, the least likely inside a cell first: where several fit, the first does. A semicolon comes before a
/// comma because some countries write numbers with a comma.
const DELIMITERS: [u8; 4] = *b"\t;, ";

/// How a text table is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Dialect {
    /// Between cells. Several spaces are one delimiter; several of another are empty cells.
    pub delimiter: u8,
    /// Whether the first line has names.
    pub header: bool,
}

/// The dialect and the column names.
pub(super) fn detect(start: &[u8]) -> Result<(Dialect, Vec<String>), TableFault> {
    if start.contains(&0) {
        return Err(TableFault::NotATable);
    }
    let text = String::from_utf8_lossy(start);
    let mut lines: Vec<&str> = text.lines().filter(|line| !line.trim().is_empty()).collect();
    // The sample ends in the middle of a line, unless the file ends with it.
    if start.len() as u64 == SAMPLE_BYTES && lines.len() > 1 {
        lines.pop();
    }
    let Some(first) = lines.first() else {
        return Err(TableFault::Empty);
    };
    // The first two lines decide: a later line of another length is an error with its number, not another delimiter.
    let delimiter = DELIMITERS
        .into_iter()
        .find(|&delimiter| {
            let cells = split(first, delimiter).len();
            cells > 1 && lines.get(1).is_none_or(|second| split(second, delimiter).len() == cells)
        })
        .or_else(|| DELIMITERS.into_iter().find(|&delimiter| split(first, delimiter).len() > 1))
        .ok_or(TableFault::NotATable)?;
    let cells = split(first, delimiter);
    let header = cells.iter().any(|cell| number(cell).is_none());
    let names = if header {
        cells.iter().map(|cell| name(cell)).collect()
    } else {
        (1..=cells.len()).map(|place| format!("column_{place}")).collect()
    };
    Ok((Dialect { delimiter, header }, names))
}

/// A cell as a number: NaN for one that is empty or says so in words, `None` for other text.
pub(super) fn number(cell: &str) -> Option<f64> {
    let cell = cell.trim();
    if let Ok(number) = cell.parse() {
        return Some(number);
    }
    ["", "na", "n/a", "null", "none"].iter().any(|missing| cell.eq_ignore_ascii_case(missing)).then_some(f64::NAN)
}

/// The cells of a line.
fn split(line: &str, delimiter: u8) -> Vec<String> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).delimiter(delimiter).from_reader(line.as_bytes());
    let Some(Ok(record)) = reader.records().next() else {
        return Vec::new();
    };
    record.iter().filter(|cell| delimiter != b' ' || !cell.is_empty()).map(str::to_owned).collect()
}

/// A header's cell without the marks that other programs put before it: a byte-order mark, a comment sign, spaces.
fn name(cell: &str) -> String {
    cell.trim_start_matches(['\u{feff}', '#', ' ']).trim().to_owned()
}
