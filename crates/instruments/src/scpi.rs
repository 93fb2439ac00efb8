//! SCPI as a client: lines of text, one answer a question.
//!
//! What was not answered is asked again only after the line was made anew or was quiet, and what came unasked is dropped
//! before each question: so a late answer, or one that came twice within 100 ms, is never taken for the next. SCPI numbers nothing:
//! one that comes twice, later than that, cannot be told from the next.

use std::time::{Duration, Instant};

use crate::fault::Fault;
use crate::line::Line;

/// How often something is asked before it is given up.
const TRIES: u32 = 3;
/// How long a line is quiet before the next question: an answer that comes twice is over by then.
const QUIET: Duration = Duration::from_millis(100);
/// Errors that a queue holds at most: instruments keep ten to thirty.
const LONGEST_QUEUE: u32 = 100;
/// An answer longer than this is none of an instrument.
const LONGEST: usize = 4096;

/// An instrument that speaks SCPI.
pub struct Scpi {
    line: Box<dyn Line>,
    time_out: Duration,
    is_stale: bool,
    answered: Option<Instant>,
}

impl Scpi {
    /// An instrument on a line, whose answers take `time_out` at most.
    #[must_use]
    pub const fn new(line: Box<dyn Line>, time_out: Duration) -> Self {
        Self { line, time_out, is_stale: false, answered: None }
    }

    /// Says something that is not answered.
    ///
    /// # Errors
    /// [`Fault::Line`].
    pub fn tell(&mut self, command: &str) -> Result<(), Fault> {
        self.renew_if_stale();
        self.line.send(format!("{command}\n").as_bytes()).map_err(Fault::Line)
    }

    /// Says something, and holds it against the instrument's error queue.
    ///
    /// # Errors
    /// [`Fault::Scpi`] with the instrument's own words.
    pub fn order(&mut self, command: &str) -> Result<(), Fault> {
        self.tell(command)?;
        match self.next_error()? {
            None => Ok(()),
            Some(error) => Err(Fault::Scpi { command: command.into(), error }),
        }
    }

    /// Takes out what is in the instrument's error queue.
    ///
    /// # Errors
    /// [`Fault`]; [`Fault::Scpi`] of one whose queue has no end.
    pub fn forget_errors(&mut self) -> Result<(), Fault> {
        let mut last = String::new();
        for _ in 0..LONGEST_QUEUE {
            match self.next_error()? {
                None => return Ok(()),
                Some(error) => last = error,
            }
        }
        Err(Fault::Scpi { command: "SYST:ERR?".into(), error: last })
    }

    /// The oldest error in the instrument's queue.
    fn next_error(&mut self) -> Result<Option<String>, Fault> {
        // 0,"No error": SCPI-99, volume 2, 21.8.
        let code = |answer: &str| answer.split_once(',').and_then(|(code, _)| code.trim().parse::<i32>().ok());
        let (code, error) = self.ask_for("SYST:ERR?", code)?;
        Ok((code != 0).then_some(error))
    }

    /// Asks, and returns the answer's line.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn ask(&mut self, question: &str) -> Result<String, Fault> {
        let mut last = None;
        for _ in 0..TRIES {
            self.renew_if_stale();
            match self.once(question) {
                Ok(answer) => {
                    self.answered = Some(Instant::now());
                    return Ok(answer);
                }
                Err(fault) => {
                    self.is_stale = true;
                    last = Some(fault);
                }
            }
        }
        Err(last.unwrap_or_else(|| Fault::Silent { asked: question.into(), heard: "nothing came" }))
    }

    /// Asks for a number.
    ///
    /// # Errors
    /// [`Fault::OtherAnswer`] for what is no number, and for NaN and infinities, which SCPI writes as 9.91E37 and 9.9E37.
    pub fn ask_number(&mut self, question: &str) -> Result<f64, Fault> {
        let number = |answer: &str| {
            // Some say their unit after it.
            let digits = answer.trim_end_matches(|letter: char| letter.is_ascii_alphabetic());
            digits.trim().parse::<f64>().ok().filter(|number| number.abs() < 9.9e37)
        };
        self.ask_for(question, number).map(|(number, _)| number)
    }

    /// Asks for a switch: whether it is on.
    ///
    /// # Errors
    /// [`Fault::OtherAnswer`] for what is neither.
    pub fn ask_switch(&mut self, question: &str) -> Result<bool, Fault> {
        let switch = |answer: &str| match answer {
            "1" | "ON" => Some(true),
            "0" | "OFF" => Some(false),
            _ => None,
        };
        self.ask_for(question, switch).map(|(is_on, _)| is_on)
    }

    /// Asks for an answer of a kind. One of another kind may be another question's: it is asked again on a fresh line.
    fn ask_for<T>(&mut self, question: &str, read: impl Fn(&str) -> Option<T>) -> Result<(T, String), Fault> {
        let mut tries = 1;
        loop {
            let answer = self.ask(question)?;
            match read(&answer) {
                Some(value) => return Ok((value, answer)),
                None if tries == TRIES => return Err(Fault::OtherAnswer { asked: question.into(), answer }),
                None => self.is_stale = true,
            }
            tries += 1;
        }
    }

    fn renew_if_stale(&mut self) {
        if std::mem::take(&mut self.is_stale) {
            self.line.renew(self.time_out);
        }
    }

    fn once(&mut self, question: &str) -> Result<String, Fault> {
        let is_recent = self.answered.is_some_and(|answered| answered.elapsed() < QUIET);
        self.line.drop_heard(if is_recent { QUIET } else { Duration::ZERO });
        self.line.send(format!("{question}\n").as_bytes()).map_err(Fault::Line)?;
        let deadline = Instant::now() + self.time_out;
        let mut heard = Vec::new();
        loop {
            if let Some(end) = heard.iter().position(|&byte| byte == b'\n') {
                let line = String::from_utf8_lossy(&heard[..end]);
                // A terminal would obey what is none of a text.
                return Ok(line.trim().chars().filter(|letter| !letter.is_control()).collect());
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() || heard.len() > LONGEST {
                let what = if heard.is_empty() { "nothing came" } else { "what came is no whole line" };
                return Err(Fault::Silent { asked: question.into(), heard: what });
            }
            self.line.receive(&mut heard, left).map_err(Fault::Line)?;
        }
    }
}
