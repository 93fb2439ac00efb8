//! What Python has, as what the crates read: a file, bytes, columns of numbers.
//!
//! Columns are kept as a Parquet file in memory, which is a table like any other: they are read and converted where a CSV is.

use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::ffi_stream::ArrowArrayStreamReader;
use arrow_array::{
    ArrayRef, Float64Array, RecordBatch, TimestampMicrosecondArray, TimestampMillisecondArray,
    TimestampNanosecondArray, TimestampSecondArray,
};
use arrow_pyarrow::PyArrowType;
use arrow_schema::{ArrowError, DataType, SchemaRef};
use numpy::PyReadonlyArray1;
use parquet::arrow::ArrowWriter;
use parquet::errors::ParquetError;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use pyo3::prelude::*;
use zerorate_cal::source::Source as Readable;

use crate::errors::{raised, told};

/// Something that is read: a file, bytes, columns.
#[pyclass(frozen, module = "zerorate._zerorate")]
pub struct Source(pub Readable);

#[pymethods]
impl Source {
    /// A file.
    #[staticmethod]
    fn file(path: PathBuf) -> Self {
        Self(Readable::file(&path))
    }

    /// The bytes of a log of any kind, under a name for messages.
    #[staticmethod]
    fn bytes(name: String, bytes: &[u8]) -> Self {
        Self(Readable::bytes(name, bytes))
    }

    /// Columns with their names: float64, or datetime64 as int64 with its unit.
    #[staticmethod]
    fn columns(name: String, columns: Vec<(String, Column<'_>)>) -> PyResult<Self> {
        let columns = columns.into_iter().map(|(column, numbers)| Ok((column, numbers.array()?)));
        let columns = columns.collect::<PyResult<Vec<(String, ArrayRef)>>>()?;
        let table = RecordBatch::try_from_iter(columns).map_err(|error| raised(&error))?;
        Self::table(name, &table.schema(), [Ok(table)])
    }

    /// A data frame by Arrow's C stream interface. Categories are no numbers, and not every kind of them can be kept: they are
    /// left out.
    #[staticmethod]
    fn stream(name: String, frame: PyArrowType<ArrowArrayStreamReader>) -> PyResult<Self> {
        use arrow_array::RecordBatchReader as _;
        let schema = frame.0.schema();
        let is_kept = |place: &usize| !matches!(schema.field(*place).data_type(), DataType::Dictionary(..));
        let kept: Vec<usize> = (0..schema.fields().len()).filter(is_kept).collect();
        let schema = schema.project(&kept).map_err(|error| raised(&error))?;
        Self::table(name, &Arc::new(schema), frame.0.map(|records| records?.project(&kept)))
    }
}

impl Source {
    fn table(
        name: String,
        schema: &SchemaRef,
        records: impl IntoIterator<Item = Result<RecordBatch, ArrowError>>,
    ) -> PyResult<Self> {
        // It is read once, and at once: nothing is worth packing or looking up.
        let properties = WriterProperties::builder().set_dictionary_enabled(false);
        let properties = properties.set_statistics_enabled(EnabledStatistics::None).build();
        let written = || -> Result<Vec<u8>, ParquetError> {
            let mut file = ArrowWriter::try_new(Vec::new(), Arc::clone(schema), Some(properties))?;
            for record in records {
                file.write(&record?)?;
            }
            file.into_inner()
        };
        let bytes = written().map_err(|error| raised(&error))?;
        Ok(Self(Readable::bytes(name, bytes)))
    }
}

/// One column.
#[derive(FromPyObject)]
pub enum Column<'py> {
    /// Numbers.
    Numbers(PyReadonlyArray1<'py, f64>),
    /// Times since 1970, and their unit as numpy names it: s, ms, us, ns.
    Times(PyReadonlyArray1<'py, i64>, String),
}

impl Column<'_> {
    fn array(&self) -> PyResult<ArrayRef> {
        let (times, unit) = match self {
            Self::Numbers(numbers) => return Ok(Arc::new(Float64Array::from(numbers.as_array().to_vec()))),
            Self::Times(times, unit) => (times.as_array(), unit.as_str()),
        };
        // numpy's "not a time" is the least integer.
        let times = times.iter().map(|&time| (time != i64::MIN).then_some(time));
        Ok(match unit {
            "s" => Arc::new(times.collect::<TimestampSecondArray>()),
            "ms" => Arc::new(times.collect::<TimestampMillisecondArray>()),
            "us" => Arc::new(times.collect::<TimestampMicrosecondArray>()),
            "ns" => Arc::new(times.collect::<TimestampNanosecondArray>()),
            other => return Err(told(&format!("times in {other} are not read: give datetime64 of s, ms, us or ns"))),
        })
    }
}
