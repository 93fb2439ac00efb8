//! What `zerorate apply` does: a log with the bias by a calibration beside every rate.

use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use thiserror::Error;
use zerorate_core::drift::Drift;

use crate::table::{TableError, TableFile};
use crate::whole_file::WholeFile;

/// The curve to apply to one rate column.
#[derive(Debug, Clone, PartialEq)]
pub struct AppliedDrift {
    /// The rate column's name.
    pub column: String,
    /// The curve, in the column's unit and the temperature column's. Outside its valid range it is held at its end.
    pub drift: Drift,
}

/// What was done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Applied {
    /// Rows written.
    pub rows: u64,
    /// Rows without a temperature, whose predictions are empty.
    pub without_temperature: u64,
    /// Rows with a temperature outside a curve's valid range, at which the curve was held.
    pub outside: u64,
}

/// Why a log cannot be corrected.
#[derive(Debug, Error)]
pub enum ApplyError {
    /// The log cannot be read.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The corrected log cannot be written.
    #[error("{}: cannot be written: {source}: an earlier file there is as it was", path.display())]
    Write {
        /// The output file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// Writes a log again as comma-separated text, every row and column kept, with `predicted_<column>` (the bias by the
/// curve) and `corrected_<column>` (rate less bias) added for each curve. A row without a rate still gets its
/// prediction; a row without a temperature gets neither. The output appears at once when it is whole.
///
/// # Errors
/// When the log cannot be read, a column is not there, or the output cannot be written.
pub fn apply(log: &Path, temperature: &str, drifts: &[AppliedDrift], output: &Path) -> Result<Applied, ApplyError> {
    let table = TableFile::open(log)?;
    let mut columns = vec![table.column(temperature)?];
    for drift in drifts {
        columns.push(table.column(&drift.column)?);
    }
    let write_error = |source| ApplyError::Write { path: output.to_owned(), source };
    let file = WholeFile::create(output).map_err(write_error)?;
    write(&table, &columns, drifts, file, write_error)
}

fn write(
    table: &TableFile,
    columns: &[usize],
    drifts: &[AppliedDrift],
    file: WholeFile,
    write_error: impl Fn(io::Error) -> ApplyError + Copy,
) -> Result<Applied, ApplyError> {
    let csv_error = |error: csv::Error| write_error(error.into());
    let mut writer = csv::Writer::from_writer(BufWriter::new(file));
    let added = drifts.iter().flat_map(|d| [format!("predicted_{}", d.column), format!("corrected_{}", d.column)]);
    writer.write_record(table.names().iter().cloned().chain(added)).map_err(csv_error)?;
    let mut applied = Applied::default();
    for batch in table.batches_with_cells(columns)? {
        let batch = batch?;
        for (row, cells) in batch.cells.iter().enumerate() {
            let temperature = batch.columns[0][row];
            let rates = batch.columns[1..].iter().map(|column| column[row]);
            writer
                .write_record(cells.iter().cloned().chain(added_cells(drifts, temperature, rates)))
                .map_err(csv_error)?;
            applied.rows += 1;
            applied.without_temperature += u64::from(temperature.is_nan());
            let outside = drifts.iter().any(|d| temperature < d.drift.valid.min() || temperature > d.drift.valid.max());
            applied.outside += u64::from(outside);
        }
    }
    let buffer = writer.into_inner().map_err(|error| write_error(error.into_error()))?;
    let file = buffer.into_inner().map_err(|error| write_error(error.into_error()))?;
    file.finish().map_err(write_error)?;
    Ok(applied)
}

/// The prediction and the correction of each rate; empty where there is none.
fn added_cells(
    drifts: &[AppliedDrift],
    temperature: f64,
    rates: impl Iterator<Item = f64>,
) -> impl Iterator<Item = String> {
    drifts.iter().zip(rates).flat_map(move |(applied, rate)| {
        let (predicted, _) = applied.drift.evaluate(temperature);
        [predicted, rate - predicted].map(|value| if value.is_nan() { String::new() } else { value.to_string() })
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use zerorate_core::drift::{Polynomial, Scale, Shape, ValidRange};

    use super::*;

    /// 1 + T / 10 over 0..20.
    fn drift(column: &str) -> AppliedDrift {
        let scale = Scale::spanning(0.0, 20.0).unwrap();
        AppliedDrift {
            column: column.to_owned(),
            drift: Drift {
                shape: Shape::Polynomial(Polynomial::new(scale, &[2.0, 1.0]).unwrap()),
                valid: ValidRange::new(0.0, 20.0).unwrap(),
            },
        }
    }

    fn correct(log: &str) -> (Result<Applied, ApplyError>, String) {
        let folder = tempfile::tempdir().unwrap();
        let (input, output) = (folder.path().join("log.tsv"), folder.path().join("out.csv"));
        fs::write(&input, log).unwrap();
        fs::write(&output, "earlier").unwrap();
        let applied = apply(&input, "temp", &[drift("x"), drift("y")], &output);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left beside it");
        (applied, fs::read_to_string(&output).unwrap())
    }

    #[test]
    fn every_row_and_column_is_kept_and_two_are_added_for_each_rate() {
        let log = "temp\tx\tnote\ty\n0\t1.5\ta, b\t1\n10\tnan\tc\t\n\t3\td\t4\n";
        let (applied, text) = correct(&log.replace("a, b", "'a, b'").replace("c\t", "7\t").replace('\'', ""));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "temp,x,note,y,predicted_x,corrected_x,predicted_y,corrected_y");
        assert_eq!(lines[1], "0,1.5,\"a, b\",1,1,0.5,1,0");
        assert_eq!(lines[2], "10,nan,7,,2,,2,", "a row without a rate keeps its prediction");
        assert_eq!(lines[3], ",3,d,4,,,,");
        assert_eq!(applied.unwrap(), Applied { rows: 3, without_temperature: 1, outside: 0 });
    }

    #[test]
    fn outside_the_valid_range_the_curve_is_held_and_counted() {
        let (applied, text) = correct("temp,x,y\n-50,0,0\n90,0,0\n");
        assert!(text.contains("-50,0,0,1,-1,1,-1") && text.contains("90,0,0,3,-3,3,-3"), "{text}");
        assert_eq!(applied.unwrap().outside, 2);
    }

    #[test]
    fn a_log_that_cannot_be_read_leaves_the_earlier_output() {
        let (applied, text) = correct("temp,x,y\n1,2,3\n1,oops,3\n");
        assert!(applied.unwrap_err().to_string().contains(":3: column 'x' holds 'oops'"));
        assert_eq!(text, "earlier");
        let (applied, text) = correct("temp,x\n1,2\n");
        assert!(applied.unwrap_err().to_string().contains("there is no column 'y'"));
        assert_eq!(text, "earlier");
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("log.csv");
        fs::write(&input, "temp,x\n1,2\n").unwrap();
        let error = apply(&input, "temp", &[drift("x")], Path::new("/nowhere/out.csv")).unwrap_err().to_string();
        assert!(error.starts_with("/nowhere/out.csv: cannot be written"), "{error}");
    }
}
