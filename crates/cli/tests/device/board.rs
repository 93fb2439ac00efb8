//! A virtual board as a process of its own, and the command against it.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use crate::schema;

pub struct Board {
    child: Child,
    orders: ChildStdin,
    answers: BufReader<ChildStdout>,
    /// As `--port` takes it.
    pub port: String,
}

impl Board {
    /// A board of the unit that the calibration in `bench.rs` was made for.
    pub fn start(on: &str, more: &[&str], folder: &Path) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_zerorate"))
            .args(["virtual-board", "--on", on, "--serial", "ZR-0042"])
            .args(more)
            .current_dir(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let orders = child.stdin.take().unwrap();
        let mut answers = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        answers.read_line(&mut line).unwrap();
        let port = line.trim().rsplit(' ').next().unwrap().to_owned();
        Self { child, orders, answers, port }
    }

    /// Gives an order and returns what is said to it.
    pub fn order(&mut self, order: &str) -> String {
        writeln!(self.orders, "{order}").unwrap();
        self.said()
    }

    /// The next line that it says.
    pub fn said(&mut self) -> String {
        let mut line = String::new();
        self.answers.read_line(&mut line).unwrap();
        line.trim().to_owned()
    }

    /// Sends the process a signal, as `STOP`.
    pub fn signal(&self, signal: &str) {
        send(signal, self.child.id());
    }

    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Runs `zerorate device --port ...`.
    pub fn device(&self, arguments: &[&str], folder: &Path) -> Ran {
        let output = Command::new(env!("CARGO_BIN_EXE_zerorate"))
            .args(["device", "--port", &self.port])
            .args(arguments)
            .current_dir(folder)
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Ran {
            arguments: ["device"].iter().chain(arguments).map(|argument| (*argument).to_owned()).collect(),
            code: output.status.code(),
            out: text(output.stdout),
            err: text(output.stderr),
        }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        // It may be stopped, and gone already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// How a command ended.
#[derive(Debug)]
pub struct Ran {
    arguments: Vec<String>,
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Ran {
    /// Standard output as JSON; it must be nothing else, and of its command's form.
    #[track_caller]
    pub fn json(&self) -> serde_json::Value {
        let json = serde_json::from_str(&self.out).unwrap_or_else(|error| panic!("{error}: {self:?}"));
        schema::hold_printed(&self.arguments, &json);
        json
    }

    #[track_caller]
    pub fn ends(&self, code: i32, parts: &[&str]) -> &Self {
        assert_eq!(self.code, Some(code), "{self:?}");
        let both = [self.out.as_str(), &self.err].concat();
        parts.iter().for_each(|part| assert!(both.contains(part), "'{part}' is missing: {self:?}"));
        self
    }
}

pub fn send(signal: &str, process: u32) {
    let status = Command::new("kill").args([&format!("-{signal}"), &process.to_string()]).status().unwrap();
    assert!(status.success());
}

/// Guards against what hangs, however slow the machine. That silence is told within five seconds is held to on a clock of
/// its own, in bench's tests of the line.
const HANGS: Duration = Duration::from_secs(600);

/// Waits until something holds.
#[track_caller]
pub fn await_that(what: &str, mut holds: impl FnMut() -> bool) {
    let began = Instant::now();
    while !holds() {
        assert!(began.elapsed() < HANGS, "{what}: not in {HANGS:?}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Waits until a process ends, and returns its code.
#[track_caller]
pub fn await_end(child: &mut Child) -> Option<i32> {
    let mut status = None;
    await_that("the process ends", || {
        status = child.try_wait().unwrap();
        status.is_some()
    });
    status.unwrap().code()
}
