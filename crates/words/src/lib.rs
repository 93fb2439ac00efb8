#![doc = include_str!("../README.md")]

use std::error::Error;
use std::iter::successors;

/// A text in which parameters are named as the libraries name them, with the command's options in their place:
/// `` `rate_unit` `` is `--rate-unit`.
#[must_use]
pub fn as_options(text: &str) -> String {
    let is_name = |part: &str| !part.is_empty() && part.chars().all(|c| c.is_ascii_lowercase() || c == '_');
    let parts: Vec<&str> = text.split('`').collect();
    let mut told = String::new();
    let mut place = 0;
    while place < parts.len() {
        // A name has a mark on both sides.
        if place > 0 && place + 1 < parts.len() && is_name(parts[place]) {
            told.push_str("--");
            told.push_str(&parts[place].replace('_', "-"));
            told.push_str(parts[place + 1]);
            place += 2;
        } else {
            told.push_str(if place > 0 { "`" } else { "" });
            told.push_str(parts[place]);
            place += 1;
        }
    }
    told
}

/// An error and its causes. Many of them have told their cause already.
#[must_use]
pub fn sentence(error: &(dyn Error + 'static)) -> String {
    let causes = successors(Some(error), |&error| error.source()).map(ToString::to_string);
    let told = causes.fold(String::new(), |told, cause| match () {
        () if told.is_empty() => cause,
        () if told.contains(&cause) => told,
        () => format!("{told}: {cause}"),
    });
    without_numbers(&told)
}

/// The system's numbers for its errors say nothing to people who read the words before them.
fn without_numbers(text: &str) -> String {
    let mut words = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once(" (os error ") {
        words.push_str(before);
        rest = after.split_once(')').map_or("", |(_, after)| after);
    }
    words + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_told_as_options() {
        let text = "it is none (`rate_unit` says which, `time` when): `listener sensor_gyro` shows it, `--out` too";
        let told = "it is none (--rate-unit says which, --time when): `listener sensor_gyro` shows it, `--out` too";
        assert_eq!(as_options(text), told);
        assert_eq!(as_options("a lone ` and `"), "a lone ` and `");
    }

    #[derive(Debug)]
    struct Told(&'static str, Option<Box<Told>>);

    impl std::fmt::Display for Told {
        fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str(self.0)
        }
    }

    impl Error for Told {
        fn source(&self) -> Option<&(dyn Error + 'static)> {
            self.1.as_deref().map(|cause| cause as _)
        }
    }

    #[test]
    fn a_cause_that_was_told_is_not_told_again() {
        let cause = Told("the disk is full", None);
        let told = Told("apply", Some(Box::new(Told("a.csv: the disk is full: make room", Some(Box::new(cause))))));
        assert_eq!(sentence(&told), "apply: a.csv: the disk is full: make room");
    }

    #[test]
    fn the_systems_error_numbers_are_left_out() {
        let text = "log.csv: cannot be read: No such file or directory (os error 2): give another";
        assert_eq!(without_numbers(text), "log.csv: cannot be read: No such file or directory: give another");
        assert_eq!(without_numbers("full (os error 28)"), "full");
    }
}
