//! Raw samples for `cargo xtask compare-lot`: writes them (`generate FILE ROWS`), or sums them by a plain loop over memory
//! (`loop ROWS`) to say what the machine can do.

#![allow(clippy::cast_possible_truncation)] // groups, places and readings fit, and a batch does

use std::fs::File;
use std::sync::Arc;
use std::time::Instant;

use arrow_array::{RecordBatch, StringArray, UInt16Array, UInt32Array};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;

/// Samples of a group.
const LENGTH: u64 = 500;

/// Rows of a batch: 1000 groups of X and Y.
const BATCH: u64 = 2 * LENGTH * 1000;

/// A sample's group, whether it is Y, its place, temperature and reading.
fn sample(row: u64) -> (u32, bool, u16, u16, u16) {
    let (group, within) = (row / (2 * LENGTH), row % (2 * LENGTH));
    // A multiplicative hash for noise.
    let noise = row.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 60;
    let temperature = 8500 + (group / 30 % 3400) + noise;
    let reading = 8200 + (group / 50 % 400) + (noise ^ 5);
    (group as u32, within >= LENGTH, (within % LENGTH) as u16, temperature as u16, reading as u16)
}

fn batch(schema: &Arc<Schema>, from: u64, to: u64) -> RecordBatch {
    let rows: Vec<_> = (from..to).map(sample).collect();
    RecordBatch::try_new(
        Arc::clone(schema),
        vec![
            Arc::new(rows.iter().map(|row| row.0).collect::<UInt32Array>()),
            Arc::new(StringArray::from_iter_values(rows.iter().map(|row| if row.1 { "y" } else { "x" }))),
            Arc::new(rows.iter().map(|row| row.2).collect::<UInt16Array>()),
            Arc::new(rows.iter().map(|row| row.3).collect::<UInt16Array>()),
            Arc::new(rows.iter().map(|row| row.4).collect::<UInt16Array>()),
        ],
    )
    .expect("columns of one length")
}

fn generate(path: &str, rows: u64) -> Result<(), Box<dyn std::error::Error>> {
    let field = |name: &str, kind| Field::new(name, kind, false);
    let schema = Arc::new(Schema::new(vec![
        field("group_number", DataType::UInt32),
        field("axis", DataType::Utf8),
        field("index", DataType::UInt16),
        field("temperature_counts", DataType::UInt16),
        field("zro_counts", DataType::UInt16),
    ]));
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = ArrowWriter::try_new(File::create(path)?, Arc::clone(&schema), Some(properties))?;
    for from in (0..rows).step_by(BATCH as usize) {
        writer.write(&batch(&schema, from, (from + BATCH).min(rows)))?;
    }
    writer.close()?;
    Ok(())
}

/// Sums by a plain loop over columns in memory, in pieces, so that a hundred million rows need no memory of their own.
fn plain_loop(rows: u64) -> (f64, u64) {
    let mut seconds = 0.0;
    let mut check = 0;
    for from in (0..rows).step_by(BATCH as usize) {
        let samples: Vec<_> = (from..(from + BATCH).min(rows)).map(sample).collect();
        let groups: Vec<u32> = samples.iter().map(|it| it.0).collect();
        let axes: Vec<bool> = samples.iter().map(|it| it.1).collect();
        let temperatures: Vec<u16> = samples.iter().map(|it| it.3).collect();
        let readings: Vec<u16> = samples.iter().map(|it| it.4).collect();
        let first = groups[0];
        let began = Instant::now();
        let mut sums = vec![[0_u64; 5]; 2 * (BATCH / (2 * LENGTH)) as usize];
        for row in 0..groups.len() {
            let (t, z) = (u64::from(temperatures[row]), u64::from(readings[row]));
            let own = &mut sums[2 * (groups[row] - first) as usize + usize::from(axes[row])];
            own[0] += 1;
            own[1] += t;
            own[2] += t * t;
            own[3] += z;
            own[4] += z * z;
        }
        seconds += began.elapsed().as_secs_f64();
        check += sums.iter().map(|own| own[4]).sum::<u64>();
    }
    (seconds, check)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["generate", path, rows] => generate(path, rows.parse()?),
        ["loop", rows] => {
            let rows: u64 = rows.parse()?;
            let (seconds, check) = plain_loop(rows);
            println!("{{\"seconds\": {seconds}, \"zro_sq_sum\": {check}}}");
            Ok(())
        }
        _ => Err("raw_samples generate FILE ROWS, or raw_samples loop ROWS".into()),
    }
}
