//! Ctrl-C as a flag that loops look at, so that what is under way ends in order.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result};

static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C sets the flag; a second one ends the program at once.
pub fn watch() -> Result<()> {
    ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::SeqCst) {
            // 128 + SIGINT, as shells have it.
            std::process::exit(130);
        }
    })
    .context("Ctrl-C cannot be watched for")
}

/// Whether Ctrl-C was pressed.
pub fn was_asked_for() -> bool {
    ASKED.load(Ordering::SeqCst)
}
