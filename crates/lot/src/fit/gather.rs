//! The groups of some recordings' ramps, from the engine: 2400 rows or so a unit and axis.

use zerorate_cal::ramp_fit::RampGroup;

use crate::dataset::{Found, Place, columns};
use crate::engine::{Engine, EngineError, column, count};
use crate::table::Files;

/// Schema version 1 of a recording has its group numbers and status bits under words that SQL keeps for itself.
const SQL: &str = "
SELECT file, axis = 'y' AS y, coalesce(group_number, \"group\") AS group_number, t_s, temperature_counts, zro_counts, n,
       coalesce(status_bits, flags) AS status_bits, tap,
       phase IN ('heating', 'cooling') AND n > 0 AS used, NOT isnan(chamber_c) AS driven,
       n > 0 AND coalesce(temperature_counts <> CAST(temperature_sum AS DOUBLE) / n
                          OR zro_counts <> CAST(zro_sum AS DOUBLE) / n, true) AS inconsistent
FROM files";

/// What one recording holds.
#[derive(Debug, Clone, Default)]
pub(super) struct Unit {
    /// The ramps of X and Y, in order.
    pub axes: [Vec<RampGroup>; 2],
    /// Whether the bench drove the chamber: then a row tells its air.
    pub driven: bool,
    /// Groups, of soaks too, whose means are not those of their sums.
    pub inconsistent: u64,
}

/// Reads some recordings.
// Group numbers, counts, bits and taps fit their types in the file.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(super) async fn gather(engine: &Engine, place: &Place, files: &[&Found]) -> Result<Vec<Unit>, EngineError> {
    let table = Files::new(place.root.clone(), columns(), files.iter().map(|file| file.meta.clone()).collect());
    let mut units = vec![Unit::default(); files.len()];
    let mut rows = vec![0; files.len()];
    for batch in &engine.collect(place, table, SQL).await? {
        let get = |name| column(batch, name);
        let (file, y, group, t_s) = (get("file")?, get("y")?, get("group_number")?, get("t_s")?);
        let (temperature, reading) = (get("temperature_counts")?, get("zro_counts")?);
        let (n, status_bits, tap) = (get("n")?, get("status_bits")?, get("tap")?);
        let (used, driven, inconsistent) = (get("used")?, get("driven")?, get("inconsistent")?);
        for row in 0..batch.num_rows() {
            let own = file[row] as usize;
            rows[own] += 1;
            units[own].driven |= driven[row] > 0.5;
            units[own].inconsistent += count(inconsistent[row]);
            if used[row] > 0.5 {
                units[own].axes[usize::from(y[row] > 0.5)].push(RampGroup {
                    group: group[row] as u32,
                    time_s: t_s[row],
                    temperature: temperature[row],
                    reading: reading[row],
                    samples: n[row] as u32,
                    status_bits: status_bits[row] as u16,
                    tap: tap[row] as u16,
                });
            }
        }
    }
    // An engine owes rows no order.
    units.iter_mut().flat_map(|unit| &mut unit.axes).for_each(|groups| groups.sort_by_key(|group| group.group));
    // A result that lost rows on its way must not pass for one.
    match files.iter().zip(rows).find(|(file, rows)| file.rows != *rows) {
        None => Ok(units),
        Some((file, found)) => Err(EngineError::Lost { file: file.file.clone(), expected: file.rows, found }),
    }
}
