//! The third pass: what the curves leave.

use std::collections::HashMap;
use std::fmt::Write;

use zerorate_cal::ramp_fit::JUDGED_ORDER;
use zerorate_fit::folds::FOLDS;
use zerorate_fit::residual::Residuals;

use super::moments::{SCALED, frame};
use super::{Curve, Extent, Key, column, count, keys};
use crate::dataset::{Found, Place, columns};
use crate::engine::{Engine, EngineError};
use crate::table::{FileValue, Files};

/// What is left of one axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Left {
    /// Of the curve that wild groups are searched for under.
    pub survey: Residuals,
    /// The sum of squares under the fit of everything.
    pub squares: f64,
    /// The least and the greatest there, counts.
    pub extremes: (f64, f64),
    /// The sum of squares where each eighth is predicted by the others.
    pub held_out_squares: f64,
    /// The least and the greatest there, counts.
    pub held_out_extremes: (f64, f64),
}

/// The value of a coefficient's column: `c2_x`, or without an eighth, `c2_x_5`.
fn name(k: usize, axis: &str, without: Option<usize>) -> String {
    without.map_or_else(|| format!("c{k}_{axis}"), |stretch| format!("c{k}_{axis}_{stretch}"))
}

/// The value of a coefficient of the curve that is judged by, `j2_x`.
fn judged_name(k: usize, axis: &str) -> String {
    format!("j{k}_{axis}")
}

fn sql(order: usize) -> String {
    let mut sql = format!("{SCALED},\nfitted AS (SELECT file, y, v, x");
    for k in 0..=order {
        // Writing to a string cannot fail.
        let _ = write!(sql, ", CASE WHEN is_y THEN {} ELSE {} END AS c{k}", name(k, "y", None), name(k, "x", None));
        let _ = write!(sql, ", CASE 2 * stretch + y");
        for stretch in 0..FOLDS {
            for (y, axis) in ["x", "y"].into_iter().enumerate() {
                let _ = write!(sql, " WHEN {} THEN {}", 2 * stretch + y, name(k, axis, Some(stretch)));
            }
        }
        let _ = write!(sql, " END AS h{k}");
    }
    for k in 0..=JUDGED_ORDER {
        let _ = write!(sql, ", CASE WHEN is_y THEN {} ELSE {} END AS j{k}", judged_name(k, "y"), judged_name(k, "x"));
    }
    let horner = |letter: &str, order: usize| {
        (0..order).rev().fold(format!("{letter}{order}"), |sum, k| format!("({sum}) * x + {letter}{k}"))
    };
    let _ = write!(
        sql,
        " FROM scaled),\nleft_over AS (SELECT file, y, v - ({}) AS r, v - ({}) AS h, v - ({}) AS j FROM fitted)",
        horner("c", order),
        horner("h", order),
        horner("j", JUDGED_ORDER)
    );
    sql + "\nSELECT file, y, count(*) AS groups, sum(r * r) AS r2, min(r) AS r_min, max(r) AS r_max, sum(h * h) AS h2,
       min(h) AS h_min, max(h) AS h_max, sum(j * j) AS j2, sum(j * j * j * j) AS j4, min(j) AS j_min, max(j) AS j_max
FROM left_over GROUP BY file, y"
}

/// Asks for what is left under the curves; axes without one are left out.
pub(super) async fn query(
    engine: &Engine,
    place: &Place,
    files: &[&Found],
    extents: &HashMap<Key, Extent>,
    curves: &HashMap<Key, Curve>,
    order: usize,
) -> Result<HashMap<Key, Left>, EngineError> {
    let values = |file: usize| {
        let mut values = frame(file, extents);
        for (y, axis) in [(false, "x"), (true, "y")] {
            let curve = curves.get(&(file, y));
            for without in std::iter::once(None).chain((0..FOLDS).map(Some)) {
                let coefficients = match without {
                    None => curve.map(|curve| &curve.coefficients),
                    Some(stretch) => curve.and_then(|curve| curve.without[stretch].as_ref()),
                };
                for k in 0..=order {
                    let value = coefficients.map_or(0.0, |coefficients| coefficients[k]);
                    values.push((name(k, axis, without), FileValue::Real(value)));
                }
            }
            for k in 0..=JUDGED_ORDER {
                let value = curve.map_or(0.0, |curve| curve.judged[k]);
                values.push((judged_name(k, axis), FileValue::Real(value)));
            }
        }
        values
    };
    let table = files.iter().enumerate().map(|(place, file)| (file.meta.clone(), values(place))).collect();
    let batches = engine.collect(place, Files::new(place.root.clone(), columns(), table), &sql(order)).await?;
    let mut left = HashMap::new();
    for batch in &batches {
        let get = |name| column(batch, name);
        let (groups, squares) = (get("groups")?, get("r2")?);
        let (judged_squares, judged_fourths) = (get("j2")?, get("j4")?);
        let (judged_least, judged_most) = (get("j_min")?, get("j_max")?);
        let (least, most) = (get("r_min")?, get("r_max")?);
        let (held_squares, held_least, held_most) = (get("h2")?, get("h_min")?, get("h_max")?);
        for (row, key) in keys(batch)?.into_iter().enumerate().filter(|(_, key)| curves.contains_key(key)) {
            let survey = Residuals {
                count: count(groups[row]),
                squares: judged_squares[row],
                fourths: judged_fourths[row],
                min: judged_least[row],
                max: judged_most[row],
            };
            left.insert(
                key,
                Left {
                    survey,
                    squares: squares[row],
                    extremes: (least[row], most[row]),
                    held_out_squares: held_squares[row],
                    held_out_extremes: (held_least[row], held_most[row]),
                },
            );
        }
    }
    Ok(left)
}
