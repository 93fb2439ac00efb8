//! The command as people and programs meet it: what it prints, where it writes, how it ends.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used, missing_docs)]

mod apply;
mod bench;
mod characterise;
mod export;
mod fault;
mod fit;
mod forms;
mod help;
mod in_chamber;
mod info;
mod kept;
mod killed;
mod live;
mod log;
mod place;
mod report;
mod schema;
mod setup;
mod table;
mod units;
mod verify;

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// How a command ended.
struct Ran {
    arguments: Vec<String>,
    code: i32,
    out: String,
    err: String,
}

impl Ran {
    /// Standard output as JSON; it must be nothing else, and of its command's form.
    #[track_caller]
    fn json(&self) -> serde_json::Value {
        let json = serde_json::from_str(&self.out).unwrap_or_else(|error| panic!("{error}: {}", self.out));
        schema::hold_printed(&self.arguments, &json);
        json
    }

    /// An error: exit code 2, one line that begins with `error:`, without the insides of a program, and nothing else.
    #[track_caller]
    fn is_error(&self, parts: &[&str]) {
        assert_eq!(self.code, 2, "{}", self.err);
        assert!(self.out.is_empty() || self.json()["error"].is_string(), "{}", self.out);
        assert!(self.err.starts_with("error: ") && self.err.trim_end().lines().count() == 1, "{}", self.err);
        for inside in ["os error", "panicked", "Some(", "Err(", "RUST_BACKTRACE"] {
            assert!(!self.err.contains(inside), "{}", self.err);
        }
        let told: Vec<&str> = self.err.trim_end().split(": ").collect();
        assert!((1..told.len()).all(|part| !told[..part].contains(&told[part])), "told twice: {}", self.err);
        self.says(parts);
    }

    /// Both outputs together hold each part.
    #[track_caller]
    fn says(&self, parts: &[&str]) {
        let text = format!("{}{}", self.out, self.err);
        parts.iter().for_each(|part| assert!(text.contains(part), "'{part}' is missing from: {text}"));
    }
}

/// Runs the command in a folder.
fn zerorate(folder: &Path, arguments: &[&str]) -> Ran {
    ran(arguments, command(folder).args(arguments).output().unwrap())
}

fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_zerorate"));
    command.current_dir(folder);
    command
}

fn ran(arguments: &[&str], output: Output) -> Ran {
    Ran {
        arguments: arguments.iter().map(|argument| (*argument).to_owned()).collect(),
        code: output.status.code().unwrap(),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// A folder of its own with a file in it.
fn folder_with(file: &str, content: impl AsRef<[u8]>) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(file), content).unwrap();
    folder
}
