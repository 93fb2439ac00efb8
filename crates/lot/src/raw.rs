//! The first stage: raw samples become group sums, once, some 500 to 1. The fit reads group sums and nothing else.
//!
//! The sums are of whole numbers, so an engine gives them exactly, in any order.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use arrow_array::{Array, RecordBatch, StringArray};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::properties::WriterProperties;
use zerorate_cal::recording::{described_as_a_recordings, key_values};

use crate::dataset::{Place, PlaceError, footer};
use crate::engine::{Engine, EngineError, column, count};
use crate::out::{self, OutError};
use crate::table::Files;
use footer::Footer;

/// The columns of raw samples that are read. Words of a letter are compared fastest as views.
fn columns() -> Vec<(&'static str, DataType)> {
    vec![
        ("group_number", DataType::UInt32),
        ("axis", DataType::Utf8View),
        ("temperature_counts", DataType::UInt16),
        ("zro_counts", DataType::UInt16),
    ]
}

/// The query. One whole number a group and axis is what an engine groups by fastest: its last two bits are 1 for X and 2
/// for Y, and something else where the axis is neither. Of one file, its place needs no part in the key.
fn sql(files: usize) -> String {
    let file = if files == 1 { "" } else { "file, " };
    format!(
        "
WITH samples AS (
  SELECT {file}4 * CAST(group_number AS BIGINT) + CASE WHEN axis = 'y' THEN 2 ELSE 0 END
           + CASE WHEN axis = 'x' THEN 1 ELSE 0 END AS place,
         CAST(temperature_counts AS BIGINT) AS t, CAST(zro_counts AS BIGINT) AS z
  FROM files)
SELECT {file}place / 4 AS group_number, CASE place % 4 WHEN 1 THEN 'x' WHEN 2 THEN 'y' END AS axis, count(*) AS n,
       sum(t) AS temperature_sum, sum(t * t) AS temperature_sq_sum, sum(z) AS zro_sum, sum(z * z) AS zro_sq_sum
FROM samples GROUP BY {file}place ORDER BY {file}place"
    )
}

/// What a first stage came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grouped {
    /// Rows of sums, one a file, group and axis.
    pub rows: usize,
    /// Wall time of the query, seconds.
    pub seconds: f64,
}

/// Why samples were not grouped.
#[derive(Debug, thiserror::Error)]
pub enum RawError {
    /// The samples' place.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// A file is no raw samples, or not whole ones.
    #[error("{file}: {reason}")]
    Samples {
        /// The file.
        file: String,
        /// What is wrong and what is wanted.
        reason: String,
    },
    /// The sums would go over the samples.
    #[error(transparent)]
    Out(#[from] OutError),
    /// The engine.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The sums cannot be written.
    #[error("{path}: cannot be written: {reason}")]
    Write {
        /// The file.
        path: String,
        /// Why.
        reason: String,
    },
}

/// Sums the groups of all raw samples in a dataset and writes them as Parquet.
///
/// # Errors
/// [`RawError`].
pub async fn group(engine: &Engine, dataset: &str, out: &Path) -> Result<Grouped, RawError> {
    let place = Place::of(dataset)?;
    let (files, unlisted) = place.list().await?;
    // Sums without some of the samples would pass for whole ones.
    if !unlisted.is_empty() {
        return Err(RawError::Samples { file: dataset.to_owned(), reason: unlisted.join("; ") });
    }
    if files.is_empty() {
        return Err(PlaceError::Nothing { dataset: dataset.to_owned() }.into());
    }
    let local: Vec<PathBuf> = files.iter().filter_map(|meta| place.local(meta)).collect();
    out::check(out, local.iter().map(PathBuf::as_path))?;
    out::check_kind(out, "sums of `zerorate lot group`", are_sums)?;
    for meta in &files {
        let samples = |reason| RawError::Samples { file: place.name_of(&meta.location), reason };
        footer::read(place.store.as_ref(), meta).await.and_then(|footer| check(&footer)).map_err(samples)?;
    }
    let sql = sql(files.len());
    let began = Instant::now();
    let names: Vec<String> = files.iter().map(|meta| place.name_of(&meta.location)).collect();
    let table = Files::new(place.root.clone(), columns(), files);
    let batches = engine.collect(&place, table.split(), &sql).await?;
    let seconds = began.elapsed().as_secs_f64();
    if batches.iter().filter_map(|batch| batch.column_by_name("axis")).any(|axis| axis.null_count() > 0) {
        let reason = "column 'axis' has other words than x and y".to_owned();
        return Err(RawError::Samples { file: dataset.to_owned(), reason });
    }
    let batches = batches.iter().map(|batch| named(batch, &names)).collect::<Result<Vec<_>, _>>()?;
    write(out, &batches)
        .map_err(|reason| RawError::Write { path: out.display().to_string(), reason: reason.to_string() })?;
    Ok(Grouped { rows: batches.iter().map(RecordBatch::num_rows).sum(), seconds })
}

/// Whether a file holds sums and nothing that a recording has beside them.
fn are_sums(path: &Path) -> bool {
    let file = std::fs::File::open(path).ok();
    let builder = file.and_then(|file| ParquetRecordBatchReaderBuilder::try_new(file).ok());
    builder.is_some_and(|builder| {
        let has = |column| builder.schema().column_with_name(column).is_some();
        has("zro_sum") && has("zro_sq_sum") && !has("phase")
    })
}

/// The sums with their files' names for their places.
fn named(batch: &RecordBatch, names: &[String]) -> Result<RecordBatch, EngineError> {
    let Some((at, _)) = batch.schema().column_with_name("file") else { return Ok(batch.clone()) };
    let name =
        |place: &f64| usize::try_from(count(*place)).ok().and_then(|at| names.get(at)).map_or("", String::as_str);
    let files = StringArray::from_iter_values(column(batch, "file")?.iter().map(name));
    let mut fields: Vec<Field> = batch.schema().fields().iter().map(|field| field.as_ref().clone()).collect();
    let mut columns = batch.columns().to_vec();
    fields[at] = Field::new("file", DataType::Utf8, false);
    columns[at] = Arc::new(files);
    let schema = Arc::new(Schema::new(fields));
    RecordBatch::try_new(schema, columns).map_err(|error| EngineError::Query(error.into()))
}

/// Whether a file's columns can be summed without a loss: all there, of whole numbers, none missing.
fn check(footer: &Footer) -> Result<(), String> {
    for (name, _) in columns() {
        let field = footer.schema.field_with_name(name).map_err(|_| format!("there is no column '{name}'"))?;
        let kind = field.data_type();
        let word = match kind {
            DataType::Dictionary(_, value) => value.as_ref(),
            kind => kind,
        };
        let fits = if name == "axis" {
            matches!(word, DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View)
        } else {
            kind.is_integer()
        };
        if !fits {
            let wanted = if name == "axis" { "the words x and y" } else { "whole numbers" };
            return Err(format!("column '{name}' is of type {kind}, and {wanted} are wanted"));
        }
        match footer.missing(name) {
            Some(0) => {}
            Some(missing) => {
                return Err(format!("{missing} values are missing in column '{name}': leave such samples out"));
            }
            None => {
                return Err(format!(
                    "column '{name}' does not say whether values are missing: write it with statistics"
                ));
            }
        }
    }
    Ok(())
}

fn write(out: &Path, batches: &[RecordBatch]) -> Result<(), Box<dyn std::error::Error>> {
    let Some(first) = batches.first() else {
        return Err("there are no samples".into());
    };
    let schema = Arc::new(described_as_a_recordings(&first.schema()));
    let properties = WriterProperties::builder().set_key_value_metadata(Some(key_values(&schema))).build();
    let partial = out.with_extension("parquet.partial");
    let mut writer = ArrowWriter::try_new(std::fs::File::create(&partial)?, Arc::clone(&schema), Some(properties))?;
    for batch in batches {
        writer.write(&batch.clone().with_schema(Arc::clone(&schema))?)?;
    }
    writer.into_inner()?.sync_all()?;
    std::fs::rename(&partial, out)?;
    Ok(())
}
