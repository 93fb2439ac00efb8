//! A server as a process of its own.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

pub struct Server {
    child: Child,
    pub port: u16,
}

impl Server {
    pub fn start(script: &str, arguments: &[&str]) -> Self {
        let python = std::env::var("ZERORATE_INSTRUMENTS_PYTHON").expect("run `cargo xtask test instruments`");
        let mut child = Command::new(python)
            .arg(format!("{}/../instruments/tests/servers/{script}", env!("CARGO_MANIFEST_DIR")))
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        Self { child, port: line.trim().parse().unwrap() }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
