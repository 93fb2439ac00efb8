//! Some files of a lot as one table of the engine.
//!
//! Which file a row is of travels as the file's partition value: an executor needs no code of ours.

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

/// Some Parquet files of one schema as a table: their columns, then `file`, the place of the file.
#[derive(Debug)]
pub struct Files {
    root: ObjectStoreUrl,
    columns: SchemaRef,
    place: FieldRef,
    all: SchemaRef,
    files: Vec<PartitionedFile>,
    split: bool,
}

impl Files {
    /// A table of files that all have these columns.
    #[must_use]
    pub fn new(root: ObjectStoreUrl, columns: Vec<(&str, DataType)>, files: Vec<ObjectMeta>) -> Self {
        let columns: Vec<Field> = columns.into_iter().map(|(name, kind)| Field::new(name, kind, true)).collect();
        let columns = Arc::new(Schema::new(columns));
        let place = Arc::new(Field::new("file", DataType::Int64, false));
        let all: Vec<FieldRef> = columns.fields().iter().chain([&place]).cloned().collect();
        let placed = |(place, meta)| {
            PartitionedFile::new_from_meta(meta).with_partition_values(vec![ScalarValue::Int64(Some(place))])
        };
        let files = (0..).zip(files).map(placed).collect();
        Self { root, columns, place, all: Arc::new(Schema::new(all)), files, split: false }
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
            .with_table_partition_cols(vec![Arc::clone(&self.place)])
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
