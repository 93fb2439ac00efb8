//! A page for those who look on while something takes hours; of several boards, one of them all beside each one's own.

mod all;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::{Context, Result};
use chrono::Local;
use zerorate_bench::setup::SetUp;
use zerorate_live::{Listen, Live};
use zerorate_report::LiveRun;

pub use self::all::LookingOnAll;

/// Where a page is served if nobody says: on this machine alone.
pub const HERE: &str = "127.0.0.1:5495";

/// A run that is looked on, and its page.
pub struct LookingOn {
    run: Arc<Mutex<LiveRun>>,
    live: Live,
}

impl LookingOn {
    /// Serves the page of a run that begins.
    pub fn open(listen: &Listen, title: &str, setup: &SetUp) -> Result<Self> {
        Self::on(listen, about(title, setup))
    }

    /// Serves the page of a run as it is.
    pub fn on(listen: &Listen, run: LiveRun) -> Result<Self> {
        let page = LiveRun::page(&run.title);
        let run = Arc::new(Mutex::new(run));
        let own = Arc::clone(&run);
        // The parts are made of a copy, so that what runs waits for no drawing.
        let parts = move || {
            let copy = lock(&own).clone();
            copy.parts()
        };
        Ok(Self { run, live: serve(listen, page, parts)? })
    }

    /// Changes what is shown.
    pub fn change(&self, change: impl FnOnce(&mut LiveRun)) {
        change(&mut lock(&self.run));
    }

    /// Where to look, in words.
    pub fn told(&self) -> String {
        let what = if lock(&self.run).ended.is_some() { "the run that is over" } else { "the run as it goes" };
        format!("{what}: open {}", self.live.url())
    }

    /// It is over; everybody gets the end.
    pub fn end(self, how: String) {
        self.change(|run| run.end(how));
        self.live.finish();
    }
}

/// Serves a page of parts.
fn serve(
    listen: &Listen,
    page: String,
    parts: impl Fn() -> Vec<(&'static str, String)> + Send + Sync + 'static,
) -> Result<Live> {
    Live::open(listen, page, parts)
        .with_context(|| format!("nobody can look on; {} finds a port that is free", listen.at_any_port()))
}

/// The title of a calibration's page.
pub fn calibration(of: &str) -> String {
    format!("Calibration of {of}")
}

/// A run of which nothing has come.
pub fn about(title: &str, setup: &SetUp) -> LiveRun {
    LiveRun {
        title: title.to_owned(),
        air_c: f64::NAN,
        celsius: Some((setup.board.counts_at_zero_celsius, setup.board.counts_per_celsius)),
        model: setup.model(),
        ..LiveRun::default()
    }
}

/// The time by the clock on the wall.
pub fn clock() -> String {
    Local::now().format("%H:%M:%S").to_string()
}

fn lock(run: &Mutex<LiveRun>) -> MutexGuard<'_, LiveRun> {
    // A change that has panicked has ended the program.
    run.lock().unwrap_or_else(PoisonError::into_inner)
}
