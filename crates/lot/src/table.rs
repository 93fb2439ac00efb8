//! The recordings of a lot as one table of the engine.
//!
//! A unit's serial, scale and coefficients are the same in all rows of its file, so they travel as the file's partition
//! values: the query needs no join, and an executor no code of ours.

use std::sync::Arc;

use arrow_schema::{DataType, Field, FieldRef, Schema, SchemaRef};
use async_trait::async_trait;
use datafusion::catalog::{Session, TableProvider};
use datafusion::common::{Result, ScalarValue};
use datafusion::datasource::TableType;
use datafusion::datasource::listing::PartitionedFile;
use datafusion::datasource::object_store::ObjectStoreUrl;
use datafusion::datasource::physical_plan::{FileGroup, FileScanConfigBuilder, ParquetSource};
use datafusion::datasource::source::DataSourceExec;
use datafusion::datasource::table_schema::TableSchema;
use datafusion::logical_expr::Expr;
use datafusion::physical_plan::ExecutionPlan;
use object_store::ObjectMeta;

/// A number that is the same in all rows of a file, by name.
pub type FileValues = Vec<(String, FileValue)>;

/// Such a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FileValue {
    /// A whole number.
    Whole(i64),
    /// A real one.
    Real(f64),
}

/// Some Parquet files of one schema as a table: their columns, then `file`, the place of the file, then its values.
#[derive(Debug)]
pub struct Files {
    root: ObjectStoreUrl,
    columns: SchemaRef,
    partition_columns: Vec<FieldRef>,
    all: SchemaRef,
    files: Vec<PartitionedFile>,
    split: bool,
}

impl Files {
    /// A table of files, each with its values; all must have values of the same names and kinds.
    #[must_use]
    pub fn new(root: ObjectStoreUrl, columns: Vec<(&str, DataType)>, files: Vec<(ObjectMeta, FileValues)>) -> Self {
        let fields: Vec<FieldRef> =
            columns.into_iter().map(|(name, kind)| Arc::new(Field::new(name, kind, true))).collect();
        let kind = |value: &FileValue| match value {
            FileValue::Whole(_) => DataType::Int64,
            FileValue::Real(_) => DataType::Float64,
        };
        let mut partition_columns: Vec<FieldRef> = vec![Arc::new(Field::new("file", DataType::Int64, false))];
        for (name, value) in files.first().map(|(_, values)| values.as_slice()).unwrap_or_default() {
            partition_columns.push(Arc::new(Field::new(name, kind(value), false)));
        }
        let files = (0_i64..)
            .zip(files)
            .map(|(place, (meta, values))| {
                let mut scalars = vec![ScalarValue::Int64(Some(place))];
                scalars.extend(values.into_iter().map(|(_, value)| match value {
                    FileValue::Whole(value) => ScalarValue::Int64(Some(value)),
                    FileValue::Real(value) => ScalarValue::Float64(Some(value)),
                }));
                PartitionedFile::new_from_meta(meta).with_partition_values(scalars)
            })
            .collect();
        let columns = Arc::new(Schema::new(fields));
        let all: Vec<FieldRef> = columns.fields().iter().chain(&partition_columns).cloned().collect();
        Self { root, columns, partition_columns, all: Arc::new(Schema::new(all)), files, split: false }
    }

    /// The same, each file cut into a piece for each partition: for few large ones whose rows' order does not matter.
    #[must_use]
    pub fn split(mut self) -> Self {
        self.split = true;
        self
    }

    /// Each file's row groups dealt out in contiguous pieces.
    fn pieces(&self, partitions: usize) -> Vec<FileGroup> {
        let count = i64::try_from(partitions.max(1)).unwrap_or(1);
        let piece = |file: &PartitionedFile, part: i64| {
            let size = i64::try_from(file.object_meta.size).unwrap_or(i64::MAX);
            file.clone()
                .with_range(size / count * part, if part + 1 == count { size } else { size / count * (part + 1) })
        };
        (0..count).map(|part| FileGroup::new(self.files.iter().map(|file| piece(file, part)).collect())).collect()
    }

    /// The files dealt out to so many partitions, each file whole in one of them.
    fn groups(&self, partitions: usize) -> Vec<FileGroup> {
        let mut groups = vec![Vec::new(); partitions.min(self.files.len()).max(1)];
        let count = groups.len();
        for (place, file) in self.files.iter().enumerate() {
            groups[place % count].push(file.clone());
        }
        groups.into_iter().map(FileGroup::new).collect()
    }
}

#[async_trait]
impl TableProvider for Files {
    fn schema(&self) -> SchemaRef {
        Arc::clone(&self.all)
    }

    fn table_type(&self) -> TableType {
        TableType::Base
    }

    async fn scan(
        &self,
        state: &dyn Session,
        projection: Option<&Vec<usize>>,
        _filters: &[Expr],
        _limit: Option<usize>,
    ) -> Result<Arc<dyn ExecutionPlan>> {
        let schema = TableSchema::builder(Arc::clone(&self.columns))
            .with_table_partition_cols(self.partition_columns.clone())
            .build();
        let source = Arc::new(ParquetSource::new(schema));
        let partitions = state.config().target_partitions();
        let groups = if self.split { self.pieces(partitions) } else { self.groups(partitions) };
        let config = FileScanConfigBuilder::new(self.root.clone(), source)
            .with_file_groups(groups)
            .with_projection_indices(projection.cloned())?
            .build();
        Ok(DataSourceExec::from_data_source(config))
    }
}
