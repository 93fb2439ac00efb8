//! The person at a manual bench: told on standard error, answers on standard input.

use std::io::{BufRead, stdin};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use console::Style;
use indicatif::ProgressBar;
use zerorate_bench::instruments::InstrumentError;
use zerorate_bench::manual::Operator;

use crate::interrupt;

/// How often Ctrl-C is looked for while nobody answers.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// The person at this terminal.
pub struct AtTerminal {
    bar: ProgressBar,
    lines: Receiver<String>,
}

impl AtTerminal {
    /// Listens to standard input; what is told stands above the bar.
    pub fn new(bar: ProgressBar) -> Self {
        let (tell, lines) = mpsc::channel();
        thread::spawn(move || {
            for line in stdin().lock().lines().map_while(Result::ok) {
                if tell.send(line).is_err() {
                    break;
                }
            }
        });
        Self { bar, lines }
    }

    fn say(&self, what: &str) {
        let sign = Style::new().for_stderr().cyan().bold().apply_to(">>");
        self.bar.suspend(|| eprintln!("{sign} {what}"));
    }

    fn answer(&self) -> Result<String, InstrumentError> {
        loop {
            if interrupt::was_asked_for() {
                return Err(InstrumentError::Interrupted);
            }
            match self.lines.recv_timeout(LOOK_EVERY) {
                Ok(line) => return Ok(line),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(InstrumentError::NobodyThere),
            }
        }
    }
}

impl Operator for AtTerminal {
    fn tell(&mut self, what: &str) {
        self.say(what);
    }

    fn ask_done(&mut self, what: &str) -> Result<(), InstrumentError> {
        // What was typed before the question is no answer to it.
        while self.lines.try_recv().is_ok() {}
        self.say(&format!("{what}; then press Enter"));
        self.answer().map(drop)
    }

    fn ask_number(&mut self, what: &str) -> Result<f64, InstrumentError> {
        self.say(&format!("{what}?"));
        loop {
            let text = self.answer()?;
            match text.trim().replace(',', ".").parse::<f64>() {
                Ok(number) if number.is_finite() => return Ok(number),
                _ => self.say(&format!("'{}' is no number. {what}?", text.trim())),
            }
        }
    }
}
