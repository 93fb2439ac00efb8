//! Steps that run beside the others: much of what they do takes one core alone, and what they build is in folders of their own;
//! for that of wasm the steps that need it wait.

use std::cell::RefCell;
use std::fs::{self, File};
use std::io::{self, Read};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{self, Child, Command, Stdio};
use std::thread;

use anyhow::{Context, Result, ensure};

use crate::cargo::Lots;
use crate::provide;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// What runs beside.
pub const STEPS: [&str; 5] = ["wasm", "circuit", "gateware", "firmware", "chip"];

/// This program, running steps on its own; when this is dropped or its process ends, that ends too.
pub struct Beside {
    child: RefCell<Child>,
    log: PathBuf,
}

impl Beside {
    /// Starts steps; what they say goes to a log.
    pub fn start(workspace: &Workspace, names: &[&str], lots: Lots) -> Result<Self> {
        let log = workspace.target.join("beside.log");
        let says = File::create(&log).with_context(|| log.display().to_string())?;
        let mut command = Command::new(std::env::current_exe()?);
        command
            .args(["test", "--beside"])
            .args((lots == Lots::LeftOut).then_some("--no-lots"))
            .args(names)
            .stdout(says.try_clone()?)
            .stderr(says);
        // A group of its own, to be ended with all that it started; it lives as long as its input is open.
        let child = command.stdin(Stdio::piped()).process_group(0).spawn()?;
        println!("beside: {}; what they say stands in {} and follows at the end", names.join(", "), log.display());
        Ok(Self { child: RefCell::new(child), log })
    }

    /// Waits for the steps and prints what they said.
    pub fn finish(&self) -> Result<Outcome> {
        // Not `wait`: that closes the input.
        let input = self.child.borrow_mut().stdin.take();
        let status = self.child.borrow_mut().wait()?;
        drop(input);
        print!("{}", text(&self.log)?);
        ensure!(status.success(), "a step beside failed, see above");
        Ok(Outcome::Passed)
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        let child = self.child.get_mut();
        drop(child.stdin.take());
        // It ends by itself; waiting leaves nothing behind. Nothing can be done about an error here.
        let _ = child.wait();
    }
}

/// In the process beside: ends it and all that it started when its input is closed, so that it does not outlive the process
/// that waits for it.
pub fn end_with_the_input() {
    thread::spawn(|| {
        // An error is an end as well.
        let _ = io::stdin().read_to_end(&mut Vec::new());
        let _ = provide::succeed(Command::new("sh").arg("-c").arg(format!("kill -s TERM -- -{}", process::id())));
    });
}

fn text(log: &Path) -> Result<String> {
    let bytes = fs::read(log).with_context(|| log.display().to_string())?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
