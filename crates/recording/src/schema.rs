//! The columns and the metadata of a recording, from rows and back.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt16Type, UInt32Type, UInt64Type};
use arrow_array::{
    ArrayRef, ArrowPrimitiveType, Float64Array, PrimitiveArray, RecordBatch, StringArray, UInt16Array, UInt32Array,
    UInt64Array,
};
use arrow_schema::{ArrowError, Field, Schema};
use parquet::file::metadata::KeyValue;
use serde_json::{Value, json};
use zerorate_core::compensate::Mode;
use zerorate_core::group::GroupSums;
use zerorate_core::units::Axis;

use crate::columns::{COLUMNS, Column, name_in_version_1};
use crate::named::Named;
use crate::utc::rfc3339;
use crate::{GroupRow, Phase, RecordingInfo, status};

/// The version that is written. Version 1 had other names for three columns, told nothing of any, and had no start; it is
/// read as well.
pub const SCHEMA_VERSION: u32 = 2;

const VERSION_KEY: &str = "zerorate.schema_version";
const SERIAL_KEY: &str = "zerorate.unit_serial";
const PROCEDURE_KEY: &str = "zerorate.procedure";
const SET_UP_KEY: &str = "zerorate.set_up";
const FIRMWARE_KEY: &str = "zerorate.firmware";
const SEED_KEY: &str = "zerorate.seed";
pub(super) const STARTED_KEY: &str = "zerorate.started";
/// Where the units and meanings of all columns stand.
pub const COLUMNS_KEY: &str = "zerorate.columns";
const STATUS_BITS_KEY: &str = "zerorate.status_bits";
/// What a label's name stands behind.
const LABEL_KEY: &str = "zerorate.label.";

/// What a column's own metadata says of it.
const UNIT_KEY: &str = "unit";
const DESCRIPTION_KEY: &str = "description";

/// The schema of a recording with its metadata.
pub(super) fn schema(info: &RecordingInfo) -> Arc<Schema> {
    let fields: Vec<Field> = COLUMNS.iter().map(field).collect();
    let mut metadata = HashMap::from([
        (VERSION_KEY.to_owned(), SCHEMA_VERSION.to_string()),
        (SERIAL_KEY.to_owned(), info.unit_serial.clone()),
        (PROCEDURE_KEY.to_owned(), info.procedure.clone()),
        (SET_UP_KEY.to_owned(), info.set_up.clone()),
        (FIRMWARE_KEY.to_owned(), info.firmware.clone()),
        (COLUMNS_KEY.to_owned(), columns_told(&fields)),
        (STATUS_BITS_KEY.to_owned(), status_bits_told()),
    ]);
    let started = info.started.map(rfc3339);
    metadata.extend(started.map(|started| (STARTED_KEY.to_owned(), started)));
    metadata.extend(info.seed.map(|seed| (SEED_KEY.to_owned(), seed.to_string())));
    metadata.extend(of_labels(&info.labels));
    Arc::new(Schema::new_with_metadata(fields, metadata))
}

/// A column as a field that says its unit and what it is.
pub(super) fn field(column: &Column) -> Field {
    described(Field::new(column.name, column.kind.clone(), false), column.unit, column.description)
}

/// A field that says its unit and what it is.
#[must_use]
pub fn described(field: Field, unit: &str, description: &str) -> Field {
    let words = [(UNIT_KEY, unit), (DESCRIPTION_KEY, description)];
    field.with_metadata(words.map(|(key, word)| (key.to_owned(), word.to_owned())).into())
}

/// A table of a recording's columns, by their names, with what a recording says of each.
#[must_use]
pub fn described_as_a_recordings(schema: &Schema) -> Schema {
    let field = |field: &Arc<Field>| match COLUMNS.iter().find(|column| column.name == field.name()) {
        Some(column) => described(field.as_ref().clone(), column.unit, column.description),
        None => field.as_ref().clone(),
    };
    let fields: Vec<Field> = schema.fields().iter().map(field).collect();
    let metadata = HashMap::from([(COLUMNS_KEY.to_owned(), columns_told(&fields))]);
    Schema::new_with_metadata(fields, metadata)
}

/// The schema's metadata as the key-value pairs of a Parquet file, in an order that is always the same. Arrow's own copy
/// is packed into one of them, which DuckDB and most others do not open.
#[must_use]
pub fn key_values(schema: &Schema) -> Vec<KeyValue> {
    let sorted: BTreeMap<&String, &String> = schema.metadata().iter().collect();
    sorted.into_iter().map(|(key, value)| KeyValue::new(key.clone(), value.clone())).collect()
}

/// Units and meanings of all columns that say them, as JSON.
#[must_use]
pub fn columns_told(fields: &[Field]) -> String {
    let told = |field: &Field| {
        let words = [UNIT_KEY, DESCRIPTION_KEY].map(|key| field.metadata().get(key));
        let [Some(unit), Some(description)] = words else { return None };
        Some((field.name().clone(), json!({ UNIT_KEY: unit, DESCRIPTION_KEY: description })))
    };
    Value::Object(fields.iter().filter_map(told).collect()).to_string()
}

/// The bits of the column `status_bits` with their meanings, as JSON.
fn status_bits_told() -> String {
    let told = |(bit, meaning): &(u16, &str)| (bit.to_string(), Value::from(*meaning));
    Value::Object(status::MEANINGS.iter().map(told).collect()).to_string()
}

/// The schema version in a file's metadata, if it has one.
pub(super) fn version(schema: &Schema) -> Option<&str> {
    schema.metadata().get(VERSION_KEY).map(String::as_str)
}

/// The metadata of a file.
pub(super) fn info(schema: &Schema) -> RecordingInfo {
    let text = |key| schema.metadata().get(key).cloned().unwrap_or_default();
    RecordingInfo {
        unit_serial: text(SERIAL_KEY),
        procedure: text(PROCEDURE_KEY),
        set_up: text(SET_UP_KEY),
        firmware: text(FIRMWARE_KEY),
        seed: text(SEED_KEY).parse().ok(),
        started: text(STARTED_KEY).parse().ok(),
        labels: labels(schema.metadata()),
    }
}

/// Labels as entries of the metadata.
pub(super) fn of_labels(labels: &BTreeMap<String, String>) -> impl Iterator<Item = (String, String)> {
    labels.iter().map(|(name, value)| (format!("{LABEL_KEY}{name}"), value.clone()))
}

/// The labels among the metadata.
pub(super) fn labels(metadata: &HashMap<String, String>) -> BTreeMap<String, String> {
    let label = |(key, value): (&String, &String)| Some((key.strip_prefix(LABEL_KEY)?.to_owned(), value.clone()));
    metadata.iter().filter_map(label).collect()
}

/// Rows as a batch of the schema's columns.
pub(super) fn batch(schema: &Arc<Schema>, rows: &[GroupRow]) -> Result<RecordBatch, ArrowError> {
    let float = |of: fn(&GroupRow) -> f64| -> ArrayRef { Arc::new(rows.iter().map(of).collect::<Float64Array>()) };
    let sum = |of: fn(&GroupSums) -> u64| -> ArrayRef {
        Arc::new(rows.iter().map(|row| of(&row.sums)).collect::<UInt64Array>())
    };
    let text = |of: fn(&GroupRow) -> &str| -> ArrayRef { Arc::new(StringArray::from_iter_values(rows.iter().map(of))) };
    let columns: Vec<ArrayRef> = vec![
        Arc::new(rows.iter().map(|row| row.group).collect::<UInt32Array>()),
        float(|row| row.t_s),
        text(|row| row.phase.name()),
        text(|row| row.axis.name()),
        Arc::new(rows.iter().map(|row| row.sums.n).collect::<UInt32Array>()),
        sum(|sums| sums.temperature),
        sum(|sums| sums.temperature_sq),
        sum(|sums| sums.zro),
        sum(|sums| sums.zro_sq),
        float(|row| row.sums.mean_temperature().0),
        float(|row| row.sums.mean_zro().0),
        float(|row| row.corrected_counts),
        Arc::new(rows.iter().map(|row| row.tap).collect::<UInt16Array>()),
        text(|row| row.mode.name()),
        float(|row| row.chamber_set_c),
        float(|row| row.chamber_c),
        Arc::new(rows.iter().map(|row| row.status_bits).collect::<UInt16Array>()),
    ];
    RecordBatch::try_new(Arc::clone(schema), columns)
}

/// The rows of a batch, or what does not fit in it.
pub(super) fn rows(batch: &RecordBatch) -> Result<Vec<GroupRow>, String> {
    let group = numbers::<UInt32Type>(batch, "group_number")?;
    let t_s = numbers::<Float64Type>(batch, "t_s")?;
    let phase = texts(batch, "phase")?;
    let axis = texts(batch, "axis")?;
    let n = numbers::<UInt32Type>(batch, "n")?;
    let temperature = numbers::<UInt64Type>(batch, "temperature_sum")?;
    let temperature_sq = numbers::<UInt64Type>(batch, "temperature_sq_sum")?;
    let zro = numbers::<UInt64Type>(batch, "zro_sum")?;
    let zro_sq = numbers::<UInt64Type>(batch, "zro_sq_sum")?;
    let zro_counts = numbers::<Float64Type>(batch, "zro_counts")?;
    let temperature_counts = numbers::<Float64Type>(batch, "temperature_counts")?;
    let corrected_counts = numbers::<Float64Type>(batch, "corrected_counts")?;
    let tap = numbers::<UInt16Type>(batch, "tap")?;
    let mode = texts(batch, "compensation_mode")?;
    let chamber_set_c = numbers::<Float64Type>(batch, "chamber_set_c")?;
    let chamber_c = numbers::<Float64Type>(batch, "chamber_c")?;
    let status_bits = numbers::<UInt16Type>(batch, "status_bits")?;
    (0..batch.num_rows())
        .map(|i| {
            let sums = GroupSums {
                n: n.value(i),
                temperature: temperature.value(i),
                temperature_sq: temperature_sq.value(i),
                zro: zro.value(i),
                zro_sq: zro_sq.value(i),
            };
            // The means are there for people; here they show whether the sums are as they were written.
            let means =
                [(sums.mean_temperature().0, temperature_counts.value(i)), (sums.mean_zro().0, zro_counts.value(i))];
            if means.iter().any(|(sum, mean)| sum.to_bits() != mean.to_bits() && !(sum.is_nan() && mean.is_nan())) {
                return Err(format!("group {}: its means are not those of its sums", group.value(i)));
            }
            let unknown = |reason: String| format!("group {}: {reason}", group.value(i));
            Ok(GroupRow {
                group: group.value(i),
                t_s: t_s.value(i),
                phase: Phase::of_name(phase.value(i)).map_err(unknown)?,
                axis: Axis::of_name(axis.value(i)).map_err(unknown)?,
                sums,
                corrected_counts: corrected_counts.value(i),
                tap: tap.value(i),
                mode: Mode::of_name(mode.value(i)).map_err(unknown)?,
                chamber_set_c: chamber_set_c.value(i),
                chamber_c: chamber_c.value(i),
                status_bits: status_bits.value(i),
            })
        })
        .collect()
}

/// A column of numbers by its name.
pub(super) fn numbers<'a, T: ArrowPrimitiveType>(
    batch: &'a RecordBatch,
    name: &str,
) -> Result<&'a PrimitiveArray<T>, String> {
    let column = column(batch, name)?;
    column.as_primitive_opt::<T>().ok_or_else(|| format!("column '{name}' is of type {}", column.data_type()))
}

/// A column of words by its name.
pub(super) fn texts<'a>(batch: &'a RecordBatch, name: &str) -> Result<&'a StringArray, String> {
    let column = column(batch, name)?;
    column.as_string_opt::<i32>().ok_or_else(|| format!("column '{name}' is of type {}", column.data_type()))
}

/// A column by its name, or by that of schema version 1.
fn column<'a>(batch: &'a RecordBatch, name: &str) -> Result<&'a ArrayRef, String> {
    let earlier = || batch.column_by_name(name_in_version_1(name)?);
    batch.column_by_name(name).or_else(earlier).ok_or_else(|| format!("there is no column '{name}'"))
}
