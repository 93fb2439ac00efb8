//! Several boards looked on at once.

use std::sync::{Arc, Mutex};

use anyhow::Result;
use zerorate_bench::setup::SetUp;
use zerorate_live::{Listen, Live};
use zerorate_report::{LiveBoard, LiveBoards, LiveRun};

use super::{LookingOn, calibration, lock, serve};

/// The page that shows where each of several boards is.
pub struct LookingOnAll {
    live: Live,
}

impl LookingOnAll {
    /// Serves a page of all, and at the ports after it one of each board.
    pub fn open(listen: &Listen, serials: &[&str], setup: &SetUp) -> Result<(Self, Vec<LookingOn>)> {
        let open =
            |(place, serial): (usize, &&str)| LookingOn::open(&listen.after(place + 1)?, &calibration(serial), setup);
        let each = serials.iter().enumerate().map(open).collect::<Result<Vec<_>>>()?;
        let boards: Vec<_> = serials
            .iter()
            .zip(&each)
            .map(|(serial, own)| ((*serial).to_owned(), own.live.url(), Arc::clone(&own.run)))
            .collect();
        let parts = move || {
            let copy = |(serial, url, run): &(String, String, Arc<Mutex<LiveRun>>)| LiveBoard {
                serial: serial.clone(),
                url: url.clone(),
                run: lock(run).clone(),
            };
            LiveBoards(boards.iter().map(copy).collect()).parts()
        };
        let page = LiveBoards::page(&calibration(&format!("{} boards", serials.len())));
        Ok((Self { live: serve(listen, page, parts)? }, each))
    }

    /// Where to look, in words.
    pub fn told(&self) -> String {
        format!("all boards as they go: open {}", self.live.url())
    }

    /// All are over; everybody gets the end.
    pub fn end(self) {
        self.live.finish();
    }
}
