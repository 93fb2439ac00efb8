//! The footer of a Parquet file, in one read where it is small.

use arrow_schema::{DataType, Schema};
use object_store::{ObjectMeta, ObjectStore, ObjectStoreExt};
use parquet::arrow::parquet_to_arrow_schema;
use parquet::errors::ParquetError;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader, RowGroupMetaData};
use zerorate_cal::recording::name_in_version_1;

/// Bytes read from a file's end at first.
const TAIL: u64 = 64 * 1024;

/// What every Parquet file starts with.
const MAGIC: &[u8] = b"PAR1";

/// What the footer says.
pub(crate) struct Footer {
    /// Columns and metadata.
    pub schema: Schema,
    /// Rows.
    pub rows: u64,
    metadata: ParquetMetaData,
}

impl Footer {
    /// How many values of a column are missing; `None` where its statistics do not say.
    pub(crate) fn missing(&self, column: &str) -> Option<u64> {
        let place = self.metadata.file_metadata().schema_descr().columns().iter().position(|it| it.name() == column)?;
        let required = self.metadata.file_metadata().schema_descr().column(place).max_def_level() == 0;
        let of_group = |group: &RowGroupMetaData| {
            if required { Some(0) } else { group.column(place).statistics()?.null_count_opt() }
        };
        self.metadata.row_groups().iter().map(of_group).sum()
    }
}

/// Reads the footer; the error is the reason for people.
pub(crate) async fn read(store: &dyn ObjectStore, meta: &ObjectMeta) -> Result<Footer, String> {
    let foreign = || "not a recording: not a Parquet file".to_owned();
    let unreadable = |error: object_store::Error| format!("cannot be read: {error}");
    if meta.size < 12 {
        return Err(foreign());
    }
    let start = store.get_range(&meta.location, 0..4).await.map_err(unreadable)?;
    if start != MAGIC {
        return Err(foreign());
    }
    let mut length = TAIL.min(meta.size);
    let metadata = loop {
        let tail = store.get_range(&meta.location, meta.size - length..meta.size).await.map_err(unreadable)?;
        let mut reader = ParquetMetaDataReader::new();
        match reader.try_parse_sized(&tail, meta.size) {
            Ok(()) => break reader.finish().map_err(|error| damaged(&error))?,
            Err(ParquetError::NeedMoreData(more)) if length < meta.size => {
                length = (more as u64).max(2 * length).min(meta.size);
            }
            Err(error) => return Err(damaged(&error)),
        }
    };
    let file = metadata.file_metadata();
    let schema = parquet_to_arrow_schema(file.schema_descr(), file.key_value_metadata()).map_err(|e| damaged(&e))?;
    let rows = u64::try_from(file.num_rows()).map_err(|_| "damaged: a negative number of rows".to_owned())?;
    Ok(Footer { schema, rows, metadata })
}

fn damaged(error: &ParquetError) -> String {
    format!("damaged: {error}: take another copy or record again")
}

/// What is read of a recording, with its types.
static COLUMNS: [(&str, DataType); 12] = [
    ("group_number", DataType::UInt32),
    ("t_s", DataType::Float64),
    ("phase", DataType::Utf8),
    ("axis", DataType::Utf8),
    ("n", DataType::UInt32),
    ("temperature_sum", DataType::UInt64),
    ("zro_sum", DataType::UInt64),
    ("temperature_counts", DataType::Float64),
    ("zro_counts", DataType::Float64),
    ("tap", DataType::UInt16),
    ("chamber_c", DataType::Float64),
    ("status_bits", DataType::UInt16),
];

/// The columns of the engine's table: what was renamed since schema version 1 stands there under both names, and is null
/// under the one that a file does not have.
pub(crate) fn columns() -> Vec<(&'static str, DataType)> {
    let earlier = |(name, kind): &(&str, DataType)| Some((name_in_version_1(name)?, kind.clone()));
    COLUMNS.iter().cloned().chain(COLUMNS.iter().filter_map(earlier)).collect()
}

/// Whether the columns are a recording's.
pub(super) fn check_columns(schema: &Schema) -> Result<(), String> {
    let field = |name: &str| schema.field_with_name(name).ok();
    for (name, kind) in &COLUMNS {
        match field(name).or_else(|| field(name_in_version_1(name)?)) {
            None => return Err(format!("damaged: there is no column '{name}'")),
            Some(field) if field.data_type() != kind => {
                return Err(format!("damaged: column '{name}' is of type {}", field.data_type()));
            }
            Some(_) => {}
        }
    }
    Ok(())
}
