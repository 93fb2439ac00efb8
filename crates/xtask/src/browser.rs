//! A headless Chromium: found, installed or named; started, and ended with us.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use crate::devtools::DevTools;
use crate::provide;

/// The names under which systems keep Chromium or its like.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome-stable", "google-chrome"];

/// Debian's packages; without a font, figures have no text.
const PACKAGES: [&str; 2] = ["chromium", "fonts-dejavu-core"];

/// How often a page's memory is looked at.
const LOOK: Duration = Duration::from_millis(20);

/// How long a browser may take to end when asked to, before it is killed.
const FAREWELL: Duration = Duration::from_secs(5);

/// A running browser. Dropped, it is asked to end, then killed by its own process id, and its profile removed.
pub struct Browser {
    /// The conversation with it.
    pub devtools: DevTools<ChildStdin>,
    process: Child,
    profile: PathBuf,
}

impl Browser {
    /// Starts a browser with an empty profile in `folder`, and its log beside that.
    pub fn start(folder: &Path) -> Result<Self> {
        let program = find()?;
        let profile = folder.join("chromium-profile");
        let _ = fs::remove_dir_all(&profile);
        fs::create_dir_all(&profile)?;
        let log = folder.join("chromium.log");
        // The protocol's pipes are descriptors 3 and 4. `exec` keeps the process id, so what we kill is the browser.
        let mut command = Command::new("sh");
        command.args(["-c", r#"exec "$0" "$@" 3<&0 4>&1 </dev/null >/dev/null"#]).arg(&program);
        command.args(["--headless", "--remote-debugging-pipe", "--disable-gpu", "--hide-scrollbars", "--no-first-run"]);
        // So that what it asks of the network is the page's doing alone.
        command.args(["--disable-background-networking", "--disable-component-update", "--disable-sync"]);
        command.args(["--disable-quic", "--disable-dev-shm-usage"]);
        if provide::is_root() {
            command.arg("--no-sandbox"); // Chromium refuses to start as root with one.
        }
        command.arg(format!("--user-data-dir={}", profile.display()));
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(File::create(&log)?);
        let mut process = command.spawn().context("sh could not be started")?;
        let pipes = process.stdin.take().zip(process.stdout.take());
        let (to, from) = pipes.context("the browser has no pipes")?;
        let mut browser = Self { devtools: DevTools::new(to, from), process, profile };
        let version = browser.devtools.call("Browser.getVersion", serde_json::json!({}));
        let version = version.with_context(|| format!("{}: see {}", program.display(), log.display()))?;
        println!("    {}", version["product"].as_str().unwrap_or("a browser without a name"));
        Ok(browser)
    }

    /// Watches how much memory of their own the pages' processes have, until it is asked.
    pub fn memory(&self) -> Memory {
        let profile = self.profile.display().to_string();
        let (end, ended) = mpsc::channel::<()>();
        let watch = move || {
            let mut most = None;
            while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                most = most.max(own_memory_kb(&profile));
            }
            most
        };
        Memory { end, watch: thread::spawn(watch) }
    }
}

/// A watch over the pages' memory.
pub struct Memory {
    end: Sender<()>,
    watch: JoinHandle<Option<u64>>,
}

impl Memory {
    /// The most that one had, kB; nothing where the system does not tell.
    pub fn most_kb(self) -> Option<u64> {
        drop(self.end);
        self.watch.join().ok().flatten()
    }
}

/// The memory of the largest page of a profile that it shares with nobody, as the browser's own task manager counts it, kB.
fn own_memory_kb(profile: &str) -> Option<u64> {
    let of_page = |process: &PathBuf| {
        let line = fs::read(process.join("cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line);
        line.contains("--type=renderer") && line.contains(profile)
    };
    let own = |process: PathBuf| {
        let status = fs::read_to_string(process.join("status")).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:"))?;
        line.split_whitespace().next()?.parse().ok()
    };
    let processes = fs::read_dir("/proc").ok()?.flatten().map(|entry| entry.path());
    processes.filter(of_page).filter_map(own).max()
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Asked, it ends its helper processes too; killed, it leaves them to notice. Nothing here is worth an error:
        // a browser already gone is what we want, and a profile left behind is removed by the next start.
        let asked = Instant::now();
        let _ = self.devtools.close_browser();
        while matches!(self.process.try_wait(), Ok(None)) && asked.elapsed() < FAREWELL {
            thread::sleep(Duration::from_millis(20));
        }
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = fs::remove_dir_all(&self.profile);
    }
}

fn find() -> Result<PathBuf> {
    if provide::on_path(&NAMES).is_none() {
        provide::install("Chromium", &PACKAGES)?;
    }
    provide::on_path(&NAMES).context("Chromium was installed and is not on the PATH")
}
