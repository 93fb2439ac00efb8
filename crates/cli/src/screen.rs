//! What people see: pages of text on standard output, JSON instead when asked for, notes and errors beside them.

mod grid;

use std::borrow::Cow;
use std::io::{self, Write};

use anyhow::Result;
use console::{Style, StyledObject, Term};
use serde::Serialize;
use zerorate_words::{as_options, sentence};

pub use grid::Grid;
pub use zerorate_report::number::{aligned, thousands, three_digits};

/// Lines longer than this are hard to read, however wide the terminal.
const WIDEST: usize = 100;

/// A page that is put together and then printed at once.
#[derive(Debug, Default)]
pub struct Page {
    text: String,
}

impl Page {
    /// A line as it is.
    pub fn line(&mut self, line: impl AsRef<str>) {
        self.text.push_str(line.as_ref().trim_end());
        self.text.push('\n');
    }

    /// An empty line.
    pub fn gap(&mut self) {
        self.text.push('\n');
    }

    /// An empty line and a heading.
    pub fn heading(&mut self, heading: &str) {
        self.gap();
        let heading = style(Style::new().bold(), heading).to_string();
        self.line(heading);
    }

    /// A sentence, broken at the terminal's width; `indent` stands before its first line and as many spaces before the
    /// others.
    pub fn sentence(&mut self, indent: &str, sentence: &str) {
        for line in broken(indent, sentence, width(&Term::stdout())) {
            self.line(line);
        }
    }

    /// A table.
    pub fn grid(&mut self, grid: &Grid) {
        grid.lines().iter().for_each(|line| self.line(line));
    }

    /// Names and what they stand for, in two columns.
    pub fn facts(&mut self, facts: &[(&str, String)]) {
        let wide = facts.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
        for (name, fact) in facts {
            self.sentence(&format!("  {name:wide$}  "), fact);
        }
    }

    /// Prints the page to standard output.
    pub fn print(&self) -> Result<()> {
        print(&self.text)
    }
}

/// Prints a text to standard output as it is.
pub fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    Ok(out.flush()?)
}

/// Prints JSON to standard output; its sentences name the command's options.
pub fn print_json(value: &impl Serialize) -> Result<()> {
    print(&(as_options(&serde_json::to_string_pretty(value)?) + "\n"))
}

/// An error for programs, which read standard output alone.
pub fn json_error(sentence: &str) {
    #[derive(Serialize)]
    struct Failed {
        schema: u32,
        error: String,
    }
    // Whoever does not listen is not told.
    let _ = print_json(&Failed { schema: 1, error: sentence.to_owned() });
}

/// Tells something on standard error, where it does not mix with JSON.
pub fn note(text: &str) {
    tell("note: ", text);
}

/// Tells an error on standard error, in one sentence.
pub fn error(error: &anyhow::Error) {
    let label = Style::new().for_stderr().red().bold().apply_to("error:");
    tell(&format!("{label} "), &sentence(error.as_ref()));
}

fn tell(label: &str, text: &str) {
    for line in broken(label, text, width(&Term::stderr())) {
        // Whoever does not listen is not told.
        let _ = writeln!(io::stderr(), "{}", line.trim_end());
    }
}

/// A text in a style, where standard output shows styles.
pub fn style<D>(style: Style, text: D) -> StyledObject<D> {
    style.for_stdout().apply_to(text)
}

/// The width of a terminal; without end where it is none, so that lines can be searched.
fn width(terminal: &Term) -> usize {
    if !terminal.is_term() {
        return usize::MAX;
    }
    terminal.size_checked().map_or(80, |(_, columns)| usize::from(columns)).min(WIDEST)
}

/// The lines of a sentence that was broken between words; what stands before it, and as many spaces before the others.
fn broken(indent: &str, sentence: &str, width: usize) -> Vec<String> {
    let hanging = " ".repeat(console::measure_text_width(indent));
    let options = textwrap::Options::new(width).initial_indent(indent).subsequent_indent(&hanging);
    let words = options.break_words(false).word_splitter(textwrap::WordSplitter::NoHyphenation);
    let spaced = words.word_separator(textwrap::WordSeparator::AsciiSpace);
    textwrap::wrap(&as_options(sentence), spaced).into_iter().map(Cow::into_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_is_broken_between_words_and_hangs_under_its_beginning() {
        let lines = broken("  - ", "one two three four", 12);
        assert_eq!(
            lines.iter().map(|line| line.trim_end()).collect::<Vec<_>>(),
            ["  - one two", "    three", "    four"]
        );
        assert_eq!(broken("", "unbreakablylong word", 5)[0].trim_end(), "unbreakablylong");
    }
}
