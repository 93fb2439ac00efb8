//! Delimited text as batches.

use std::io::BufReader;

use super::cells::{Splitter, text};
use super::dialect::Dialect;
use super::lines::{Line, Lines};
use super::value::Notation;
use super::{BATCH_ROWS, Batch, TableFault};
use crate::source::ReadSeek;

/// A stream of batches from a text file.
pub(super) struct TextBatches {
    lines: Lines<BufReader<Box<dyn ReadSeek>>>,
    /// Lines of the heading that are still to come.
    heading: u64,
    splitter: Splitter,
    notations: Vec<Notation>,
    names: Vec<String>,
    columns: Vec<usize>,
    cells: bool,
    row: u64,
    ended: bool,
}

impl TextBatches {
    pub(super) fn new(
        file: Box<dyn ReadSeek>,
        dialect: &Dialect,
        names: &[String],
        columns: &[usize],
        cells: bool,
    ) -> Self {
        Self {
            lines: Lines::new(BufReader::new(file)),
            heading: dialect.heading,
            splitter: Splitter::new(dialect.delimiter),
            notations: dialect.notations.clone(),
            names: names.to_vec(),
            columns: columns.to_vec(),
            cells,
            row: 0,
            ended: false,
        }
    }

    fn read(&mut self) -> Result<Option<Batch>, TableFault> {
        let mut batch = Batch {
            first_row: self.row,
            columns: vec![Vec::with_capacity(BATCH_ROWS); self.columns.len()],
            cells: Vec::new(),
            cut_line: None,
        };
        let mut rows = 0;
        while rows < BATCH_ROWS {
            let Some(line) = self.lines.next()? else {
                self.ended = true;
                break;
            };
            if line.is_comment() {
                continue;
            }
            if self.heading > 0 {
                self.heading -= 1;
                continue;
            }
            if !line.is_whole {
                // Of `0.01234` may be left `0.01`, and nothing in the line tells.
                batch.cut_line = Some(line.number);
                self.ended = true;
                break;
            }
            let found = self.splitter.split(line.text);
            if found != self.names.len() {
                return Err(ragged(&line, found, self.names.len()));
            }
            for (&column, numbers) in self.columns.iter().zip(&mut batch.columns) {
                let cell = text(self.splitter.cell(column));
                let number = self.notations[column].number(&cell).ok_or_else(|| TableFault::NotANumber {
                    line: line.number,
                    column: self.names[column].clone(),
                    text: cell.trim().to_owned(),
                    wanted: self.notations[column].name(),
                })?;
                numbers.push(number);
            }
            if self.cells {
                let cell = |place: usize| self.notations[place].pointed(text(self.splitter.cell(place)).into_owned());
                batch.cells.push((0..found).map(cell).collect());
            }
            rows += 1;
        }
        self.row += rows as u64;
        Ok((rows > 0 || batch.cut_line.is_some()).then_some(batch))
    }
}

const DECIMAL_COMMAS: &str = "commas seem to stand both between cells and in numbers (0,5): export it again with semicolons or \
     tabs between cells, or with decimal points";

/// A line that has not as many cells as the first: cut off, or its numbers were cut at their decimal commas.
fn ragged(line: &Line<'_>, found: usize, expected: usize) -> TableFault {
    let is_of_digits = line.text.iter().all(|letter| b"0123456789+-eE, ".contains(letter));
    // Two halves a number at most.
    let is_halves = is_of_digits && line.text.contains(&b',') && (expected + 1..=2 * expected).contains(&found);
    let likely = if is_halves { DECIMAL_COMMAS } else { "the line is cut off or damaged" };
    TableFault::Ragged { line: line.number, found, expected, likely }
}

impl Iterator for TextBatches {
    type Item = Result<Batch, TableFault>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let result = self.read().transpose();
        self.ended |= matches!(result, Some(Err(_)));
        result
    }
}
