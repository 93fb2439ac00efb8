//! An invented lot: most units alike, a few outside their limits, a few rejected.

use zerorate_report::{LotAxis, LotBeside, LotLimit, LotReport, LotUnit, Quantity, WorstUnit};

use super::{log, noise};

fn unit(number: u32, days: f64) -> LotUnit {
    let at = |of: u64| noise(u64::from(number) * 10 + of);
    let serial = format!("ZR-2026-{number:04}");
    let axis = |(place, name): (u64, &str)| {
        let far = if number % 67 == 9 { 2.0 } else { 1.0 };
        let held_out = far * (2.6 + 0.5 * at(place));
        LotAxis {
            name: name.into(),
            values: [
                1150.0 + 120.0 * at(place + 2),
                8203.0 + 60.0 * at(place + 4),
                0.94 * held_out,
                held_out,
                5.5 * held_out,
            ],
        }
    };
    LotUnit {
        file: format!("{serial}.parquet"),
        serial,
        station: format!("chamber-{}", number % 3 + 1),
        day: days * f64::from(number),
        rejected: if number % 50 == 17 { vec!["the run ended before its ramp did".into()] } else { Vec::new() },
        warned: if number % 40 == 3 { vec!["the temperature only rises".into()] } else { Vec::new() },
        axes: [(0, "X"), (1, "Y")].map(axis).into(),
    }
}

/// So many units, this many days apart.
pub fn lot(units: u32, days: f64) -> LotReport {
    let limit = |quantity, min, max| LotLimit { quantity, min, max };
    let units: Vec<LotUnit> = (0..units).map(|number| unit(number, days)).collect();
    // A recording that only warms, as a ramp of the bench.
    let mut fit = log();
    fit.excluded.clear();
    fit.axes.truncate(1);
    fit.axes[0].name = "X".into();
    fit.axes[0].trace.retain(|point| point.time_s > 8000.0);
    let worst = units.iter().find(|unit| unit.rejected.is_empty());
    let worst = worst.map(|unit| WorstUnit { serial: unit.serial.clone(), axis: "X".into(), held_out_rms: 6.1, fit });
    let gone = |unit: &LotUnit| {
        format!(
            "{}: not drawn: {}: the recording cannot be read: Object at location /lot/{} not found: bring it back, or say where \
             the dataset is now (--dataset)",
            unit.serial, unit.file, unit.file
        )
    };
    LotReport {
        source: "models.parquet".into(),
        model: "poly:2".into(),
        beside: Some(LotBeside {
            skipped: vec![("notes.txt".into(), "not a recording: not a Parquet file".into())],
            other_procedures: 2,
        }),
        undrawn: units.iter().filter(|unit| unit.rejected.is_empty()).skip(1).take(9).map(gone).collect(),
        worst: worst.into_iter().collect(),
        units,
        limits: vec![
            limit(Quantity::Drift, f64::NEG_INFINITY, 1500.0),
            limit(Quantity::HeldOut, f64::NEG_INFINITY, 5.0),
            limit(Quantity::HeldOutPp, f64::NEG_INFINITY, 20.0),
            limit(Quantity::InSample, 0.5, 400.0),
            limit(Quantity::Reading, 8050.0, 8350.0),
        ],
    }
}
