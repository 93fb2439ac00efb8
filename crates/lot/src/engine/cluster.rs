//! A stock Ballista cluster: a plan goes to its scheduler, the result comes from its executors.
//!
//! Ballista 55 leaves two things to its clients. Its adaptive planner, on by default, hangs for good when an executor
//! dies after the map stage (apache/datafusion-ballista issue 1986): it is switched off. And a job has no deadline of
//! its own: here each attempt has one, and a failed attempt is made again.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use arrow_array::RecordBatch;
use ballista_core::execution_plans::execute_physical_plan;
use ballista_core::extension::SessionConfigExt;
use datafusion::physical_plan::ExecutionPlan;
use datafusion::prelude::SessionConfig;
use datafusion_proto::protobuf::PhysicalPlanNode;
use futures::TryStreamExt;
use tokio::net::TcpStream;
use tokio::time::timeout;

/// Partitions of a query: tasks that executors can take.
const PARTITIONS: usize = 8;

/// How long a scheduler may take to accept a connection.
const CONNECT: Duration = Duration::from_secs(5);

/// The pause before another attempt.
const PAUSE: Duration = Duration::from_secs(2);

/// A cluster's scheduler, and how long to wait for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cluster {
    /// The scheduler.
    pub address: Address,
    /// The longest that a query may take, all attempts together.
    pub deadline: Duration,
    /// Attempts after the first.
    pub retries: u32,
}

/// Where a scheduler listens: `df://HOST:PORT`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Address {
    host: String,
    port: u16,
}

/// A text that is no address of a scheduler.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no scheduler: give df://HOST:PORT, as df://localhost:50050")]
pub struct AddressError(String);

impl FromStr for Address {
    type Err = AddressError;
    fn from_str(text: &str) -> Result<Self, AddressError> {
        let wrong = || AddressError(text.to_owned());
        let (host, port) = text.strip_prefix("df://").and_then(|rest| rest.rsplit_once(':')).ok_or_else(wrong)?;
        let port = port.trim_end_matches('/').parse().map_err(|_| wrong())?;
        if host.is_empty() { Err(wrong()) } else { Ok(Self { host: host.to_owned(), port }) }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "df://{}:{}", self.host, self.port)
    }
}

/// Why a cluster gave no result.
#[derive(Debug, thiserror::Error)]
pub enum ClusterError {
    /// Nothing listens there.
    #[error(
        "the scheduler {address} does not answer ({reason}): start it (see crates/lot/README.md), or leave out `cluster`"
    )]
    NoScheduler {
        /// Where.
        address: Address,
        /// What the system says.
        reason: String,
    },
    /// No result in time.
    #[error("the cluster {address} gave no result in {} s, in {attempts} attempts: look whether its executors live, or give it longer (`deadline`)", deadline.as_secs())]
    Deadline {
        /// Which.
        address: Address,
        /// The deadline.
        deadline: Duration,
        /// Attempts begun.
        attempts: u32,
    },
    /// The query failed in every attempt.
    #[error("the cluster {address} failed in {attempts} attempts; at last: {reason}")]
    Query {
        /// Which.
        address: Address,
        /// Attempts made.
        attempts: u32,
        /// What it said.
        reason: String,
    },
}

impl Cluster {
    /// The session's options: Ballista's own, the adaptive planner off.
    pub(super) fn config(&self) -> SessionConfig {
        SessionConfig::new_with_ballista()
            .with_target_partitions(PARTITIONS)
            .with_ballista_adaptive_query_planner(false)
            .with_ballista_job_name("zerorate lot")
    }

    /// Runs a plan, again where it fails, until the deadline.
    pub(super) async fn collect(&self, plan: Arc<dyn ExecutionPlan>) -> Result<Vec<RecordBatch>, ClusterError> {
        let began = Instant::now();
        let mut attempts = 0;
        loop {
            attempts += 1;
            let late = || ClusterError::Deadline { address: self.address.clone(), deadline: self.deadline, attempts };
            let left = self.deadline.checked_sub(began.elapsed()).ok_or_else(late)?;
            // A part of the deadline each, so that an attempt that hangs leaves time for another.
            let share = left / (self.retries + 2 - attempts.min(self.retries + 1));
            let reason = match self.connected().await {
                Err(error) if attempts > self.retries => return Err(error),
                Err(error) => error.to_string(),
                Ok(()) => match timeout(share, self.attempt(Arc::clone(&plan))).await {
                    Ok(Ok(batches)) => return Ok(batches),
                    Ok(Err(reason)) => reason,
                    Err(_) if attempts > self.retries => return Err(late()),
                    Err(_) => format!("no result in {} s", share.as_secs()),
                },
            };
            if attempts > self.retries {
                return Err(ClusterError::Query { address: self.address.clone(), attempts, reason });
            }
            tokio::time::sleep(PAUSE.min(left)).await;
        }
    }

    /// Whether the scheduler accepts connections: Ballista's own client has no limit here.
    async fn connected(&self) -> Result<(), ClusterError> {
        let gone = |reason: String| ClusterError::NoScheduler { address: self.address.clone(), reason };
        match timeout(CONNECT, TcpStream::connect((self.address.host.as_str(), self.address.port))).await {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(gone(error.to_string())),
            Err(_) => Err(gone(format!("no connection in {} s", CONNECT.as_secs()))),
        }
    }

    async fn attempt(&self, plan: Arc<dyn ExecutionPlan>) -> Result<Vec<RecordBatch>, String> {
        let config = self.config();
        let url = format!("http://{}:{}", self.address.host, self.address.port);
        let ballista = config.ballista_config();
        let codec = config.ballista_physical_extension_codec();
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let session = format!("zerorate-lot-{}-{}", std::process::id(), now.as_nanos());
        let stream =
            execute_physical_plan::<PhysicalPlanNode>(url, &ballista, plan, codec.as_ref(), session, config.clone())
                .await
                .map_err(|error| error.to_string())?;
        stream.try_collect().await.map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_read_and_anything_else_refused() {
        let address: Address = "df://10.0.0.7:50050".parse().unwrap();
        assert_eq!(address.to_string(), "df://10.0.0.7:50050");
        for wrong in ["10.0.0.7:50050", "df://:50050", "df://host", "http://host:1", "df://host:x"] {
            assert!(wrong.parse::<Address>().is_err(), "{wrong}");
        }
    }
}
