//! The command as it was typed.

use std::ffi::OsString;
use std::fmt;

use crate::output;

/// The program's name and its arguments.
#[derive(Debug)]
pub struct Typed(pub Vec<OsString>);

impl Typed {
    /// Whether programs are to be told: whatever else was typed, it may be what is wrong.
    pub fn wants_json(&self) -> bool {
        self.0.iter().any(|argument| argument == "--json")
    }
}

impl fmt::Display for Typed {
    /// As it is typed again, whatever the program's path.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("zerorate")?;
        self.0.iter().skip(1).try_for_each(|argument| write!(f, " {}", output::word(&argument.to_string_lossy())))
    }
}
