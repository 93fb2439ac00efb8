//! The first pass: counts and extremes.

use std::collections::HashMap;

use zerorate_core::drift::Scale;

use super::{Key, column, count, keys};
use crate::dataset::{Found, Place, columns};
use crate::engine::{Engine, EngineError};
use crate::table::Files;

/// What one axis has.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Extent {
    /// Groups of its ramps with samples.
    pub groups: u64,
    /// Samples in them.
    pub samples: u64,
    /// First and last group.
    pub span: (u64, u64),
    /// Extremes of the mean temperatures, counts.
    pub temperature: (f64, f64),
    /// Extremes of the mean readings, counts.
    pub reading: (f64, f64),
    /// Groups at an end of the converter.
    pub saturated: u64,
    /// The lowest and the highest tap.
    pub taps: (u16, u16),
    /// Groups whose means are not those of their sums.
    pub inconsistent: u64,
}

impl Extent {
    /// The unit's own scale.
    pub(super) fn scale(&self) -> Option<Scale> {
        Scale::spanning(self.temperature.0, self.temperature.1)
    }

    /// What is taken off the readings before they are summed, counts.
    pub(super) fn level(&self) -> f64 {
        f64::midpoint(self.reading.0, self.reading.1)
    }
}

const SQL: &str = "
WITH rows AS (
  SELECT file, CASE WHEN axis = 'y' THEN 1 ELSE 0 END AS y,
         phase IN ('heating', 'cooling') AND n > 0 AS used,
         CAST(\"group\" AS BIGINT) AS g, CAST(n AS BIGINT) AS n, CAST(flags AS BIGINT) AS flags,
         CAST(tap AS BIGINT) AS tap, temperature_counts AS t, zro_counts AS z,
         CAST(temperature_sum AS DOUBLE) AS t_sum, CAST(zro_sum AS DOUBLE) AS z_sum
  FROM files)
SELECT file, y, count(*) AS all_rows,
       sum(CASE WHEN used THEN 1 ELSE 0 END) AS groups,
       sum(CASE WHEN used THEN n ELSE 0 END) AS samples,
       min(CASE WHEN used THEN g END) AS first, max(CASE WHEN used THEN g END) AS last,
       min(CASE WHEN used THEN t END) AS t_min, max(CASE WHEN used THEN t END) AS t_max,
       min(CASE WHEN used THEN z END) AS z_min, max(CASE WHEN used THEN z END) AS z_max,
       min(CASE WHEN used THEN tap END) AS tap_min, max(CASE WHEN used THEN tap END) AS tap_max,
       sum(CASE WHEN used AND (flags / 4) % 2 = 1 THEN 1 ELSE 0 END) AS saturated,
       sum(CASE WHEN used AND (t <> t_sum / n OR z <> z_sum / n) THEN 1 ELSE 0 END) AS inconsistent
FROM rows GROUP BY file, y";

/// Asks for the extents. An axis without groups in its ramps has none.
// Taps fit their type in the file.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(super) async fn query(
    engine: &Engine,
    place: &Place,
    files: &[&Found],
) -> Result<HashMap<Key, Extent>, EngineError> {
    let table = files.iter().map(|file| (file.meta.clone(), Vec::new())).collect();
    let batches = engine.collect(place, Files::new(place.root.clone(), columns(), table), SQL).await?;
    let mut extents = HashMap::new();
    let mut rows = vec![0; files.len()];
    for batch in &batches {
        let get = |name| column(batch, name);
        let (all_rows, groups, samples) = (get("all_rows")?, get("groups")?, get("samples")?);
        let (first, last) = (get("first")?, get("last")?);
        let (t_min, t_max, z_min, z_max) = (get("t_min")?, get("t_max")?, get("z_min")?, get("z_max")?);
        let (tap_min, tap_max) = (get("tap_min")?, get("tap_max")?);
        let (saturated, inconsistent) = (get("saturated")?, get("inconsistent")?);
        for (row, key) in keys(batch)?.into_iter().enumerate() {
            rows[key.0] += count(all_rows[row]);
            if groups[row] > 0.0 {
                let extent = Extent {
                    groups: count(groups[row]),
                    samples: count(samples[row]),
                    span: (count(first[row]), count(last[row])),
                    temperature: (t_min[row], t_max[row]),
                    reading: (z_min[row], z_max[row]),
                    saturated: count(saturated[row]),
                    taps: (tap_min[row] as u16, tap_max[row] as u16),
                    inconsistent: count(inconsistent[row]),
                };
                extents.insert(key, extent);
            }
        }
    }
    // A result that lost rows on its way must not pass for one.
    match files.iter().zip(&rows).find(|(file, rows)| file.rows != **rows) {
        None => Ok(extents),
        Some((file, rows)) => Err(EngineError::Lost { file: file.file.clone(), expected: file.rows, found: *rows }),
    }
}
