//! What runs the queries: DataFusion inside this process, or a stock Ballista cluster. The plans are the same.

mod cluster;
mod result;

use std::sync::Arc;

use arrow_array::RecordBatch;
use datafusion::common::DataFusionError;
use datafusion::execution::SendableRecordBatchStream;
use datafusion::execution::runtime_env::RuntimeEnv;
use datafusion::execution::session_state::SessionStateBuilder;
use datafusion::physical_plan::{ExecutionPlan, execute_stream};
use datafusion::prelude::{SessionConfig, SessionContext};
use futures::TryStreamExt;

pub use cluster::{Address, AddressError, Cluster, ClusterError};
pub(crate) use result::{column, count};

use crate::dataset::Place;
use crate::table::Files;

/// What runs the queries.
#[derive(Debug, Clone)]
pub enum Engine {
    /// This process, on so many threads.
    Embedded {
        /// Partitions that are worked on at a time.
        threads: usize,
    },
    /// A cluster.
    Cluster(Cluster),
}

/// Why a query gave no result.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// The query failed: most often, a file in it cannot be read.
    #[error("{0}")]
    Query(#[from] DataFusionError),
    /// A result holds other than the rows of its files.
    #[error(
        "{file}: its footer says {expected} rows, and {found} were read: the file is damaged, or the result incomplete"
    )]
    Lost {
        /// The file.
        file: String,
        /// Rows by its footer.
        expected: u64,
        /// Rows in the result.
        found: u64,
    },
    /// The cluster failed.
    #[error(transparent)]
    Cluster(#[from] ClusterError),
}

impl EngineError {
    /// Whether the same query on fewer files may succeed: not when the cluster itself is gone.
    #[must_use]
    pub fn is_of_the_files(&self) -> bool {
        match self {
            Self::Query(_) | Self::Lost { .. } => true,
            Self::Cluster(error) => matches!(error, ClusterError::Query { .. }),
        }
    }
}

impl Engine {
    /// An engine in this process, on all cores.
    #[must_use]
    pub fn embedded() -> Self {
        Self::Embedded { threads: std::thread::available_parallelism().map_or(1, std::num::NonZero::get) }
    }

    fn config(&self) -> SessionConfig {
        match self {
            Self::Embedded { threads } => SessionConfig::new().with_target_partitions(*threads),
            Self::Cluster(cluster) => cluster.config(),
        }
        .set_bool("datafusion.sql_parser.map_string_types_to_utf8view", false)
        .set_bool("datafusion.optimizer.enable_dynamic_filter_pushdown", false)
        // A file is read by one task, in order.
        .set_bool("datafusion.optimizer.repartition_file_scans", false)
        .set_bool("datafusion.execution.parquet.pushdown_filters", false)
    }

    async fn plan(
        &self,
        place: &Place,
        files: Files,
        sql: &str,
    ) -> Result<(SessionContext, Arc<dyn ExecutionPlan>), DataFusionError> {
        let runtime = Arc::new(RuntimeEnv::default());
        runtime.register_object_store(place.root.as_ref(), Arc::clone(&place.store));
        let state = SessionStateBuilder::new()
            .with_config(self.config())
            .with_runtime_env(runtime)
            .with_default_features()
            .build();
        let context = SessionContext::new_with_state(state);
        context.register_table("files", Arc::new(files))?;
        let plan = context.sql(sql).await?.create_physical_plan().await?;
        Ok((context, plan))
    }

    /// Runs a query on the table `files` and gives all of its result.
    ///
    /// # Errors
    /// [`EngineError`].
    pub async fn collect(&self, place: &Place, files: Files, sql: &str) -> Result<Vec<RecordBatch>, EngineError> {
        let (context, plan) = self.plan(place, files, sql).await?;
        match self {
            Self::Embedded { .. } => {
                let stream: SendableRecordBatchStream = execute_stream(plan, context.task_ctx())?;
                Ok(stream.try_collect().await?)
            }
            Self::Cluster(cluster) => Ok(cluster.collect(plan).await?),
        }
    }
}
