//! Looks on a recording as `zerorate live` shows it, and on what the page does while the server is away and when it is back.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::devtools::{DevTools, SCREENS};
use crate::faults;
use crate::workspace::Workspace;

/// How long the page may take to say what it is to say: the browser's own patience with a lost connection is in it.
const SAID_WITHIN: Duration = Duration::from_secs(120);
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Opens the recording that the report's calibration has left, on each screen in each scheme, and lists what is wrong. The last
/// page sees the server end, another come in its place, and one of another recording after that.
pub fn look<W: Write>(workspace: &Workspace, page: &mut DevTools<W>, pictures: &Path) -> Result<Vec<String>> {
    let recordings = workspace.target.join("report-calibration");
    let recording = recordings.join("full-temperature.parquet");
    println!("    zerorate live {}", recording.display());
    let server = Server::start(workspace, &recording, "127.0.0.1:0")?;
    let (url, place) = (server.url.clone(), server.place());
    let mut faults = Vec::new();
    for screen in SCREENS {
        for scheme in ["light", "dark"] {
            page.open_page()?;
            page.go_to(&url, screen, scheme)?;
            says(page, "Connected")?;
            let view = format!("live-{}-{scheme}", screen.0);
            page.photograph(&pictures.join(format!("{view}.png")))?;
            let mut found = faults::shown(page, screen)?;
            let own = format!("request for {url}events");
            found.extend(page.events.iter().filter_map(|event| faults::of(event, &url)).filter(|fault| *fault != own));
            faults.extend(found.into_iter().map(|fault| format!("{view}: {fault}")));
        }
    }
    drop(server);
    says(page, "lost")?;
    let again = Server::start(workspace, &recording, &place)?;
    says(page, "Connected")?;
    drop(again);
    says(page, "lost")?;
    let _another = Server::start(workspace, &recordings.join("compensation-test-trim.parquet"), &place)?;
    becomes(page, "document.title", "compensation-test")?;
    says(page, "Connected")?;
    Ok(faults)
}

/// Waits until the page's line about its connection has a word in it.
fn says<W: Write>(page: &mut DevTools<W>, word: &str) -> Result<()> {
    becomes(page, "document.getElementById('line').textContent", word)
}

/// Waits until a text of the page has words in it. A page that goes elsewhere meanwhile takes the question with it: it is asked
/// again.
fn becomes<W: Write>(page: &mut DevTools<W>, text: &str, words: &str) -> Result<()> {
    let until = Instant::now() + SAID_WITHIN;
    loop {
        let says = page.evaluate(text);
        match says {
            Ok(says) if says.as_str().is_some_and(|says| says.contains(words)) => return Ok(()),
            says if Instant::now() > until => bail!("the page as it goes never says '{words}': {says:?}"),
            _ => thread::sleep(LOOK_EVERY),
        }
    }
}

/// `zerorate live`, which ends with this.
struct Server {
    process: Child,
    url: String,
}

impl Server {
    fn start(workspace: &Workspace, recording: &Path, on: &str) -> Result<Self> {
        let mut command = Command::new(workspace.zerorate()?);
        command.arg("live").arg(recording).args(["--on", on]).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut process = command.spawn().context("zerorate could not be started")?;
        let told = process.stderr.take().context("zerorate has no standard error")?;
        let mut server = Self { process, url: String::new() };
        let mut lines = BufReader::new(told).lines().map_while(std::result::Result::ok);
        let url = |line: String| line.split_whitespace().find(|word| word.starts_with("http://")).map(str::to_owned);
        server.url = lines.find_map(url).context("zerorate live says no address")?;
        Ok(server)
    }

    /// Where it listens.
    fn place(&self) -> String {
        self.url.trim_start_matches("http://").trim_end_matches('/').to_owned()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // One that has ended by itself is gone too.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
