//! Delimited text as batches.

use csv::{ErrorKind, Reader, ReaderBuilder, StringRecord};

use super::dialect::{self, Dialect};
use super::{BATCH_ROWS, Batch, TableFault};
use crate::source::ReadSeek;

/// A stream of batches from a text file.
pub(super) struct TextBatches {
    reader: Reader<Box<dyn ReadSeek>>,
    /// Several spaces are one delimiter.
    joined_delimiters: bool,
    names: Vec<String>,
    columns: Vec<usize>,
    cells: bool,
    row: u64,
    failed: bool,
}

impl TextBatches {
    pub(super) fn new(
        file: Box<dyn ReadSeek>,
        dialect: &Dialect,
        names: &[String],
        columns: &[usize],
        cells: bool,
    ) -> Self {
        let reader = ReaderBuilder::new()
            .delimiter(dialect.delimiter)
            .has_headers(dialect.header)
            // The length is checked here, where the line is known and joined delimiters are taken out.
            .flexible(true)
            .from_reader(file);
        Self {
            reader,
            joined_delimiters: dialect.delimiter == b' ',
            names: names.to_vec(),
            columns: columns.to_vec(),
            cells,
            row: 0,
            failed: false,
        }
    }

    fn read(&mut self) -> Result<Option<Batch>, TableFault> {
        let mut batch = Batch {
            first_row: self.row,
            columns: vec![Vec::with_capacity(BATCH_ROWS); self.columns.len()],
            cells: Vec::new(),
        };
        let mut record = StringRecord::new();
        let mut rows = 0;
        while rows < BATCH_ROWS && self.reader.read_record(&mut record).map_err(|error| self.fault(error))? {
            if self.joined_delimiters {
                let position = record.position().cloned();
                record = record.iter().filter(|cell| !cell.is_empty()).collect();
                record.set_position(position);
            }
            self.append(&record, &mut batch)?;
            rows += 1;
        }
        self.row += rows as u64;
        Ok((rows > 0).then_some(batch))
    }

    fn append(&self, record: &StringRecord, batch: &mut Batch) -> Result<(), TableFault> {
        let line = || record.position().map_or(0, csv::Position::line);
        if record.len() != self.names.len() {
            return Err(TableFault::Ragged { line: line(), found: record.len(), expected: self.names.len() });
        }
        for (&column, numbers) in self.columns.iter().zip(&mut batch.columns) {
            let number = dialect::number(&record[column]).ok_or_else(|| TableFault::NotANumber {
                line: line(),
                column: self.names[column].clone(),
                text: record[column].to_owned(),
            })?;
            numbers.push(number);
        }
        if self.cells {
            batch.cells.push(record.iter().map(str::to_owned).collect());
        }
        Ok(())
    }

    fn fault(&self, error: csv::Error) -> TableFault {
        match error.into_kind() {
            ErrorKind::Io(error) => error.into(),
            ErrorKind::Utf8 { pos, .. } => TableFault::NotANumber {
                line: pos.map_or(0, |pos| pos.line()),
                column: self.names[0].clone(),
                text: "bytes that are not text".to_owned(),
            },
            other => std::io::Error::other(format!("{other:?}")).into(),
        }
    }
}

impl Iterator for TextBatches {
    type Item = Result<Batch, TableFault>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let result = self.read().transpose();
        self.failed = matches!(result, Some(Err(_)));
        result
    }
}
