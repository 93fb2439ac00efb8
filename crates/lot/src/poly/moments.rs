//! The second pass: sums of the centred, scaled variable.

use std::collections::HashMap;
use std::fmt::Write;

use zerorate_cal::ramp_fit::{FoldSurvey, JUDGED_ORDER};
use zerorate_fit::folds::FOLDS;

use super::{Extent, Key, column, count, keys};
use crate::dataset::{Found, Place, columns};
use crate::engine::{Engine, EngineError};
use crate::solve::Sums;
use crate::table::{FileValue, FileValues, Files};

/// The sums of one axis, an eighth of the ramp each, and the eighths' extremes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Moments {
    /// The sums.
    pub sums: Vec<Sums>,
    /// Counts and extremes.
    pub folds: [FoldSurvey; FOLDS],
}

impl Moments {
    /// All groups.
    pub(super) fn groups(&self) -> u64 {
        self.sums.iter().map(|sums| sums.groups).sum()
    }
}

/// The values of a file that both further passes need: of each axis first group, groups, centre, half span, level.
pub(super) fn frame(file: usize, extents: &HashMap<Key, Extent>) -> FileValues {
    let mut values = FileValues::new();
    for (y, name) in [(false, "x"), (true, "y")] {
        let extent = extents.get(&(file, y));
        let whole = |of: fn(&Extent) -> u64| {
            FileValue::Whole(extent.map_or(1, |extent| i64::try_from(of(extent)).unwrap_or(i64::MAX)))
        };
        // Without a scale nothing is solved: the sums are then of no use, and finite.
        let scale = extent.and_then(Extent::scale);
        values.push((format!("first_{name}"), whole(|extent| extent.span.0)));
        values.push((format!("groups_{name}"), whole(|extent| extent.span.1 - extent.span.0 + 1)));
        values.push((format!("centre_{name}"), FileValue::Real(scale.map_or(0.0, |scale| scale.centre()))));
        values.push((format!("half_{name}"), FileValue::Real(scale.map_or(1.0, |scale| scale.half_span()))));
        values.push((format!("level_{name}"), FileValue::Real(extent.map_or(0.0, Extent::level))));
    }
    values
}

/// The beginning of both further passes: `scaled` with columns file, y, stretch, t, z, x and v.
pub(super) const SCALED: &str = "
WITH axes AS (
  SELECT *, axis = 'y' AS is_y FROM files WHERE phase IN ('heating', 'cooling') AND n > 0),
framed AS (
  SELECT *, CAST(\"group\" AS BIGINT) AS g,
         CASE WHEN is_y THEN first_y ELSE first_x END AS first_group,
         CASE WHEN is_y THEN groups_y ELSE groups_x END AS all_groups,
         CASE WHEN is_y THEN centre_y ELSE centre_x END AS centre,
         CASE WHEN is_y THEN half_y ELSE half_x END AS half,
         CASE WHEN is_y THEN level_y ELSE level_x END AS level
  FROM axes),
scaled AS (
  SELECT *, CASE WHEN is_y THEN 1 ELSE 0 END AS y, ((g - first_group) * 8) / all_groups AS stretch,
         temperature_counts AS t, zro_counts AS z,
         (temperature_counts - centre) / half AS x, zro_counts - level AS v
  FROM framed)";

fn sql(order: usize) -> String {
    let mut sql = format!("{SCALED}\nSELECT file, y, stretch, count(*) AS groups, sum(v * v) AS vv,");
    sql += " min(t) AS t_min, max(t) AS t_max, min(z) AS z_min, max(z) AS z_max";
    let power = |k: usize| if k == 0 { "1.0".to_owned() } else { vec!["x"; k].join(" * ") };
    for k in 1..=2 * order {
        // Writing to a string cannot fail.
        let _ = write!(sql, ", sum({}) AS x{k}", power(k));
    }
    for k in 0..=order {
        let _ = write!(sql, ", sum(v * {}) AS v{k}", power(k));
    }
    sql + "\nFROM scaled GROUP BY file, y, stretch"
}

/// Asks for the sums, whatever the order asked for: those of [`JUDGED_ORDER`] hold all others.
pub(super) async fn query(
    engine: &Engine,
    place: &Place,
    files: &[&Found],
    extents: &HashMap<Key, Extent>,
) -> Result<HashMap<Key, Moments>, EngineError> {
    let order = JUDGED_ORDER;
    let table = files.iter().enumerate().map(|(place, file)| (file.meta.clone(), frame(place, extents))).collect();
    let batches = engine.collect(place, Files::new(place.root.clone(), columns(), table), &sql(order)).await?;
    let mut moments: HashMap<Key, Moments> = HashMap::new();
    for batch in &batches {
        let get = |name: &str| column(batch, name);
        let (stretch, groups, squares) = (get("stretch")?, get("groups")?, get("vv")?);
        let (t_min, t_max, z_min, z_max) = (get("t_min")?, get("t_max")?, get("z_min")?, get("z_max")?);
        let powers = (1..=2 * order).map(|k| get(&format!("x{k}"))).collect::<Result<Vec<_>, _>>()?;
        let products = (0..=order).map(|k| get(&format!("v{k}"))).collect::<Result<Vec<_>, _>>()?;
        for (row, key) in keys(batch)?.into_iter().enumerate() {
            let own = moments.entry(key).or_insert_with(|| Moments {
                sums: vec![Sums::empty(order); FOLDS],
                folds: [FoldSurvey::EMPTY; FOLDS],
            });
            let place = usize::try_from(count(stretch[row])).unwrap_or(usize::MAX).min(FOLDS - 1);
            let groups = count(groups[row]);
            own.sums[place] = Sums {
                groups,
                powers: std::iter::once(groups as f64).chain(powers.iter().map(|power| power[row])).collect(),
                products: products.iter().map(|product| product[row]).collect(),
                squares: squares[row],
            };
            own.folds[place] =
                FoldSurvey { groups, temperature: (t_min[row], t_max[row]), reading: (z_min[row], z_max[row]) };
        }
    }
    Ok(moments)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sums_are_of_the_scaled_variable_and_never_of_the_temperature() {
        let sql = sql(5);
        assert!(sql.contains("sum(x * x * x * x * x * x * x * x * x * x) AS x10"));
        assert!(sql.contains("sum(v * x * x * x * x * x) AS v5"));
        assert!(!sql.contains("t * t"));
    }
}
