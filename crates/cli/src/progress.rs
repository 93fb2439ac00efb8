//! Signs of life on standard error, on a terminal only.

use std::fs;
use std::path::Path;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// How often the sign turns.
const TURN: Duration = Duration::from_millis(100);
/// A smaller file is read before a sign could be read.
const LARGE_BYTES: u64 = 8 << 20;

/// What is done now and the time gone by, of what nobody knows the end of.
pub fn without_end() -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    // A template that does not parse would be ours, and the plain sign is one too.
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}, {elapsed} gone") {
        bar.set_style(style);
    }
    bar
}

/// A turning sign with the time gone by; it goes when it is dropped.
pub struct Busy(ProgressBar);

impl Busy {
    /// Reading a file, of which the size tells how long it will take.
    pub fn reading(file: &Path) -> Self {
        let size = fs::metadata(file).map_or(0, |file| file.len());
        if size < LARGE_BYTES {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::new_spinner();
        // A template that does not parse would be ours, and a sign without a template is one too.
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}, {elapsed}") {
            bar.set_style(style);
        }
        bar.set_message(format!("reading {} ({})", file.display(), indicatif::HumanBytes(size)));
        bar.enable_steady_tick(TURN);
        Self(bar)
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
