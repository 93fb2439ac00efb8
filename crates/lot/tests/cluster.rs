//! A stock Ballista scheduler and two executors on loopback: the same numbers as embedded, and what is left of a run when
//! one of them is killed.
#![cfg(unix)]
#![allow(clippy::unwrap_used)] // what a test cannot do without

use std::fs;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::{Duration, Instant};

use zerorate_lot::engine::{Cluster, Engine};
use zerorate_lot::models::{self, ModelRow};
use zerorate_lot::run::FitRun;
use zerorate_lot::simulate::Simulation;

/// The longest that a query may take while executors are killed: an attempt that hangs takes its share of it.
const DEADLINE: Duration = Duration::from_secs(90);

/// Against what hangs for good, however slow the machine.
const FOR_GOOD: Duration = Duration::from_secs(900);

/// A process that ends with the test.
struct Node(Child);

impl Drop for Node {
    fn drop(&mut self) {
        // It may have been killed already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Node {
    fn start(arguments: &[String], log: &Path) -> Self {
        // Beside the tests' folder `deps`.
        let program =
            std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("examples/ballista_node");
        let log = fs::File::create(log).unwrap();
        let child = Command::new(program).args(arguments).stdout(log.try_clone().unwrap()).stderr(log).spawn();
        Self(child.expect("cargo test builds the example ballista_node"))
    }

    fn signal(&self, signal: &str) {
        let done = Command::new("kill").args([signal, &self.0.id().to_string()]).stderr(Stdio::null()).status();
        assert!(done.unwrap().success());
    }
}

/// A port that nobody listens on, below those that systems give to the near end of a connection: one of these, of which
/// the nodes make many, could take it before its node does.
fn free_port() -> u16 {
    static TRIED: AtomicU16 = AtomicU16::new(0);
    let first = 12_000 + u16::try_from(std::process::id() % 15_000).unwrap();
    let ports = std::iter::repeat_with(|| first + TRIED.fetch_add(1, Ordering::Relaxed)).take(1000);
    ports.into_iter().find(|port| TcpListener::bind(("127.0.0.1", *port)).is_ok()).expect("a free port")
}

/// A scheduler and its executors.
struct Nodes {
    folder: PathBuf,
    port: u16,
    started: usize,
    scheduler: Node,
    executors: Vec<(Node, PathBuf)>,
}

impl Nodes {
    fn start(folder: &Path) -> Self {
        let port = free_port();
        let scheduler = Node::start(&["scheduler".into(), port.to_string()], &folder.join("scheduler.log"));
        wait_for(port);
        let mut nodes = Self { folder: folder.to_owned(), port, started: 0, scheduler, executors: Vec::new() };
        nodes.add_executor();
        nodes.add_executor();
        nodes
    }

    fn add_executor(&mut self) {
        self.started += 1;
        let work = self.folder.join(format!("executor-{}", self.started));
        fs::create_dir(&work).unwrap();
        let (port, grpc) = (free_port(), free_port());
        let arguments =
            ["executor".into(), self.port.to_string(), port.to_string(), grpc.to_string(), work.display().to_string()];
        let node = Node::start(&arguments, &self.folder.join(format!("executor-{}.log", self.started)));
        wait_for(port);
        self.executors.push((node, work));
        // Time to be registered. Where it is too little, a round finds one executor, and that must end well too.
        std::thread::sleep(Duration::from_secs(1));
    }

    fn engine(&self, deadline: Duration) -> Engine {
        let address = format!("df://127.0.0.1:{}", self.port).parse().unwrap();
        Engine::Cluster(Cluster { address, deadline, retries: 2 })
    }
}

fn wait_for(port: u16) {
    let began = Instant::now();
    while std::net::TcpStream::connect(("127.0.0.1", port)).is_err() {
        assert!(began.elapsed() < FOR_GOOD, "nothing listens on port {port}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Files of a shuffle in an executor's folder.
fn shuffled(work: &Path) -> usize {
    let mut folders = vec![work.to_owned()];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            if entry.path().is_dir() { folders.push(entry.path()) } else { files += 1 }
        }
    }
    files
}

fn fit(lot: &Path, out: &Path, model: &str, engine: Engine) -> Result<Vec<ModelRow>, String> {
    let run = FitRun {
        dataset: lot.display().to_string(),
        out: out.to_owned(),
        model: model.parse().unwrap(),
        allow_narrow: false,
        engine,
        fresh: true,
    };
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().thread_stack_size(16 << 20).build().unwrap();
    runtime.block_on(run.run(&|_, _| ())).map_err(|error| error.to_string())?;
    Ok(models::read(out).unwrap())
}

/// The same rows, their numbers to 1e-9.
fn assert_same(rows: &[ModelRow], expected: &[ModelRow]) {
    assert_eq!(rows.len(), expected.len());
    for (row, own) in rows.iter().zip(expected) {
        assert_eq!((&row.unit_serial, &row.axis, &row.verdict), (&own.unit_serial, &own.axis, &own.verdict));
        assert_eq!((row.coefficients.len(), row.groups.to_bits()), (own.coefficients.len(), own.groups.to_bits()));
        let near = |a: f64, b: f64, of: f64| (a.is_nan() && b.is_nan()) || (a - b).abs() <= 1e-9 * of;
        let pairs = row.coefficients.iter().zip(&own.coefficients);
        assert!(pairs.into_iter().all(|(a, b)| near(*a, *b, own.drift_pp)), "{row:?} {own:?}");
        for (a, b) in [(row.held_out_rms, own.held_out_rms), (row.in_sample_pp, own.in_sample_pp)] {
            assert!(near(a, b, own.drift_pp), "{a} {b}");
        }
    }
}

#[test]
fn a_cluster_gives_the_embedded_numbers_and_survives_the_loss_of_an_executor() {
    let folder = tempfile::tempdir().unwrap();
    let lot = folder.path().join("lot");
    Simulation { units: 60, seed: 6, out: lot.clone(), bad: 0.1, cooling: false }.run(&|| ()).unwrap();
    let out = folder.path().join("models.parquet");
    let expected = fit(&lot, &out, "poly:2", Engine::embedded()).unwrap();
    let mut nodes = Nodes::start(folder.path());

    let began = Instant::now();
    let first = loop {
        // The scheduler may not have heard of its executors yet.
        match fit(&lot, &out, "poly:2", nodes.engine(FOR_GOOD)) {
            Ok(rows) => break rows,
            Err(error) => assert!(began.elapsed() < FOR_GOOD, "{error}"),
        }
    };
    assert_same(&first, &expected);
    let chosen = fit(&lot, &out, "auto", Engine::embedded()).unwrap();
    assert_same(&fit(&lot, &out, "auto", nodes.engine(FOR_GOOD)).unwrap(), &chosen);

    for round in 0..10 {
        let in_scan = round % 2 == 0;
        let began = Instant::now();
        let (victim, work) = nodes.executors.remove(0);
        if in_scan {
            // Its tasks come to it and get no further.
            victim.signal("-STOP");
        }
        let before = shuffled(&work);
        let (lot, out, engine) = (lot.clone(), out.clone(), nodes.engine(DEADLINE));
        let running = std::thread::spawn(move || fit(&lot, &out, "poly:2", engine));
        if in_scan {
            std::thread::sleep(Duration::from_millis(1500));
        } else {
            while shuffled(&work) == before && !running.is_finished() {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        victim.signal("-KILL");
        let result = running.join().unwrap();
        let (stage, took) = (if in_scan { "scan" } else { "after map" }, began.elapsed());
        println!(
            "kill {round} ({stage}): {} in {:.1} s",
            if result.is_ok() { "right" } else { "error" },
            took.as_secs_f64()
        );
        assert!(took < FOR_GOOD, "{stage}: {took:?}");
        match result {
            Ok(rows) => assert_same(&rows, &expected),
            Err(error) => assert!(error.contains("cluster"), "{error}"),
        }
        nodes.add_executor();
    }

    nodes.scheduler.signal("-KILL");
    let error = fit(&lot, &out, "poly:2", nodes.engine(DEADLINE)).unwrap_err();
    assert!(error.contains("does not answer") && error.contains("df://127.0.0.1"), "{error}");
}
