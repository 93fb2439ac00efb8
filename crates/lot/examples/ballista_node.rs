//! A stock Ballista 55 scheduler or executor from its library, for tests on loopback: what `ballista-scheduler` and
//! `ballista-executor` start, with shorter timeouts and nothing of ours in it.
//!
//! `ballista_node scheduler PORT` or `ballista_node executor SCHEDULER_PORT PORT GRPC_PORT WORK_DIR`

use std::net::SocketAddr;
use std::sync::Arc;

use ballista_executor::executor_process::{ExecutorProcessConfig, start_executor_process};
use ballista_scheduler::cluster::BallistaCluster;
use ballista_scheduler::config::SchedulerConfig;
use ballista_scheduler::scheduler_process::start_server;

type Failure = Box<dyn std::error::Error>;

async fn scheduler(port: u16) -> Result<(), Failure> {
    let config = SchedulerConfig {
        bind_port: port,
        external_host: "127.0.0.1".into(),
        // 180 s by default: an executor that died would be waited for as long.
        executor_timeout_seconds: 8,
        expire_dead_executor_interval_seconds: 1,
        no_executors_grace_period_seconds: 8,
        ..SchedulerConfig::default()
    };
    let address: SocketAddr = format!("127.0.0.1:{port}").parse()?;
    let cluster = BallistaCluster::new_from_config(&config).await?;
    Ok(start_server(cluster, address, Arc::new(config)).await?)
}

async fn executor(scheduler: u16, port: u16, grpc_port: u16, work_dir: String) -> Result<(), Failure> {
    let config = ExecutorProcessConfig {
        scheduler_host: "127.0.0.1".into(),
        scheduler_port: scheduler,
        external_host: Some("127.0.0.1".into()),
        port,
        grpc_port,
        vcores: 2,
        work_dir: Some(work_dir),
        executor_heartbeat_interval_seconds: 2,
        scheduler_connect_timeout_seconds: 20,
        ..ExecutorProcessConfig::default()
    };
    Ok(start_executor_process(Arc::new(config)).await?)
}

fn main() -> Result<(), Failure> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        // Plans are decoded recursively; the stock scheduler's own choice.
        .thread_stack_size(32 << 20)
        .build()?;
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["scheduler", port] => runtime.block_on(scheduler(port.parse()?)),
        ["executor", scheduler, port, grpc_port, work_dir] => {
            runtime.block_on(executor(scheduler.parse()?, port.parse()?, grpc_port.parse()?, work_dir.to_owned()))
        }
        _ => {
            Err("ballista_node scheduler PORT, or ballista_node executor SCHEDULER_PORT PORT GRPC_PORT WORK_DIR".into())
        }
    }
}
