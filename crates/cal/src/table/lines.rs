//! The lines of a text, one at a time and none of them without end.

use std::io::{BufRead, Read};

use super::TableFault;

/// Longer than any row of a log: what has no line feed for so long is no table, however small it was packed.
const LONGEST_LINE: u64 = 1 << 20;

/// The lines of a text that are not blank.
pub(super) struct Lines<R> {
    reader: R,
    text: Vec<u8>,
    number: u64,
}

/// One of them.
pub(super) struct Line<'a> {
    /// Without the line feed, and without a carriage return before it.
    pub text: &'a [u8],
    /// Its number in the file, from 1.
    pub number: u64,
    /// Whether a line feed ends it: only then is its last cell known to be whole.
    pub is_whole: bool,
}

impl Line<'_> {
    /// Whether it is a comment and no row.
    pub(super) fn is_comment(&self) -> bool {
        without_mark(self.text).trim_ascii_start().starts_with(b"#")
    }
}

/// A line without the mark that says that a text is UTF-8.
pub(super) fn without_mark(line: &[u8]) -> &[u8] {
    line.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(line)
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(reader: R) -> Self {
        Self { reader, text: Vec::new(), number: 0 }
    }

    /// The next line that is not blank.
    pub(super) fn next(&mut self) -> Result<Option<Line<'_>>, TableFault> {
        loop {
            self.text.clear();
            let read = self.reader.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut self.text)?;
            if read == 0 {
                return Ok(None);
            }
            self.number += 1;
            let is_whole = self.text.ends_with(b"\n");
            if !is_whole && read as u64 == LONGEST_LINE {
                return Err(TableFault::EndlessLine { line: self.number });
            }
            if !self.text.trim_ascii().is_empty() {
                break Ok(Some(Line { text: without_end(&self.text), number: self.number, is_whole }));
            }
        }
    }
}

fn without_end(line: &[u8]) -> &[u8] {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    line.strip_suffix(b"\r").unwrap_or(line)
}
