//! A line, split into its cells.

use std::borrow::Cow;
use std::ops::Range;

use csv_core::{Reader, ReaderBuilder, Terminator};

/// Splits lines by one delimiter; what stands in double quotes is one cell.
pub(super) struct Splitter {
    reader: Reader,
    /// Several spaces are one delimiter; several of another are empty cells.
    joins: bool,
    text: Vec<u8>,
    ends: Vec<usize>,
    cells: Vec<Range<usize>>,
}

impl Splitter {
    pub(super) fn new(delimiter: u8) -> Self {
        // A line comes without its end: a carriage return in it is no end but damage, and stays in its cell.
        let reader = ReaderBuilder::new().delimiter(delimiter).terminator(Terminator::Any(b'\n')).build();
        Self { reader, joins: delimiter == b' ', text: Vec::new(), ends: Vec::new(), cells: Vec::new() }
    }

    /// The number of cells in a line, which can then be asked for.
    pub(super) fn split(&mut self, line: &[u8]) -> usize {
        // No cell is longer than its line, and each but the first has a delimiter before it.
        self.text.resize(self.text.len().max(line.len()), 0);
        self.ends.resize(self.ends.len().max(line.len() + 1), 0);
        self.reader.reset();
        let (_, _, written, ended) = self.reader.read_record(line, &mut self.text, &mut self.ends);
        let (_, _, _, last) = self.reader.read_record(&[], &mut self.text[written..], &mut self.ends[ended..]);
        self.cells.clear();
        let mut start = 0;
        for &end in &self.ends[..ended + last] {
            if !self.joins || end > start {
                self.cells.push(start..end);
            }
            start = end;
        }
        self.cells.len()
    }

    /// A cell of the line that was split last.
    pub(super) fn cell(&self, place: usize) -> &[u8] {
        &self.text[self.cells[place].clone()]
    }

    /// All cells of a line as text.
    pub(super) fn texts(&mut self, line: &[u8]) -> Vec<String> {
        (0..self.split(line)).map(|place| text(self.cell(place)).into_owned()).collect()
    }
}

/// A cell as text: UTF-8, or else Latin-1, in which older programs write a degree sign.
pub(super) fn text(cell: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(cell) {
        Ok(text) => text.into(),
        Err(_) => cell.iter().map(|&byte| char::from(byte)).collect(),
    }
}
