//! The first stage: raw samples become group sums, once, some 500 to 1. The fit reads group sums and nothing else.
//!
//! The sums are of whole numbers, so an engine gives them exactly, in any order.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use arrow_array::RecordBatch;
use arrow_schema::DataType;
use parquet::arrow::ArrowWriter;

use crate::dataset::{Place, PlaceError};
use crate::engine::{Engine, EngineError};
use crate::table::Files;

/// The columns of raw samples that are read. X and Y are words that repeat.
fn columns() -> Vec<(&'static str, DataType)> {
    vec![
        ("group", DataType::UInt32),
        ("axis", DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8))),
        ("temperature_counts", DataType::UInt16),
        ("zro_counts", DataType::UInt16),
    ]
}

/// One whole number a group and axis is what an engine groups by fastest.
const SQL: &str = "
WITH samples AS (
  SELECT file, 2 * CAST(\"group\" AS BIGINT) + CASE WHEN axis = 'y' THEN 1 ELSE 0 END AS place,
         CAST(temperature_counts AS BIGINT) AS t, CAST(zro_counts AS BIGINT) AS z
  FROM files)
SELECT file, place / 2 AS \"group\", CASE WHEN place % 2 = 1 THEN 'y' ELSE 'x' END AS axis, count(*) AS n,
       sum(t) AS temperature_sum, sum(t * t) AS temperature_sq_sum, sum(z) AS zro_sum, sum(z * z) AS zro_sq_sum
FROM samples GROUP BY file, place";

/// The same where there is one file: its place needs no part in the key.
const SQL_OF_ONE: &str = "
WITH samples AS (
  SELECT 2 * CAST(\"group\" AS BIGINT) + CASE WHEN axis = 'y' THEN 1 ELSE 0 END AS place,
         CAST(temperature_counts AS BIGINT) AS t, CAST(zro_counts AS BIGINT) AS z
  FROM files)
SELECT place / 2 AS \"group\", CASE WHEN place % 2 = 1 THEN 'y' ELSE 'x' END AS axis, count(*) AS n,
       sum(t) AS temperature_sum, sum(t * t) AS temperature_sq_sum, sum(z) AS zro_sum, sum(z * z) AS zro_sq_sum
FROM samples GROUP BY place";

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
    let files: Vec<_> = place.list().await?;
    if files.is_empty() {
        return Err(PlaceError::Nothing { dataset: dataset.to_owned() }.into());
    }
    let sql = if files.len() == 1 { SQL_OF_ONE } else { SQL };
    let began = Instant::now();
    let table = Files::new(place.root.clone(), columns(), files.into_iter().map(|meta| (meta, Vec::new())).collect());
    let batches = engine.collect(&place, table.split(), sql).await?;
    let seconds = began.elapsed().as_secs_f64();
    write(out, &batches)
        .map_err(|reason| RawError::Write { path: out.display().to_string(), reason: reason.to_string() })?;
    Ok(Grouped { rows: batches.iter().map(RecordBatch::num_rows).sum(), seconds })
}

fn write(out: &Path, batches: &[RecordBatch]) -> Result<(), Box<dyn std::error::Error>> {
    let Some(first) = batches.first() else {
        return Err("there are no samples".into());
    };
    let partial = out.with_extension("parquet.partial");
    let mut writer = ArrowWriter::try_new(std::fs::File::create(&partial)?, Arc::clone(&first.schema()), None)?;
    for batch in batches {
        writer.write(batch)?;
    }
    writer.into_inner()?.sync_all()?;
    std::fs::rename(&partial, out)?;
    Ok(())
}
