//! A headless Chromium: found, installed or named; started, and ended with us.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use crate::devtools::DevTools;
use crate::provide;

/// The names under which systems keep Chromium or its like.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome-stable", "google-chrome"];

/// Debian's packages; without a font, figures have no text.
const PACKAGES: [&str; 2] = ["chromium", "fonts-dejavu-core"];

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
