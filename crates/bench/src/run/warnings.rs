//! What came to nothing on the way. What is said again and again stands once, with how often.

/// Warnings in the order in which each was first said.
#[derive(Debug, Clone, Default)]
pub struct Warnings(Vec<Warning>);

#[derive(Debug, Clone)]
struct Warning {
    text: String,
    times: usize,
}

impl Warnings {
    /// Takes in a warning, and returns it as it is to be told now. One that was given before but for its numbers ("nothing
    /// has moved for 10 minutes") takes that one's place.
    pub fn remind(&mut self, text: String) -> String {
        let same = |warning: &&mut Warning| without_numbers(&warning.text).eq(without_numbers(&text));
        match self.0.iter_mut().find(same) {
            Some(warning) => {
                *warning = Warning { text, times: warning.times + 1 };
                warning.sentence()
            }
            None => self.add(text),
        }
    }

    /// Takes in a warning that stands for itself.
    pub fn add(&mut self, text: String) -> String {
        self.0.push(Warning { text: text.clone(), times: 1 });
        text
    }

    /// The warnings, a sentence each.
    pub fn sentences(&self) -> impl Iterator<Item = String> {
        self.0.iter().map(Warning::sentence)
    }
}

impl Warning {
    fn sentence(&self) -> String {
        if self.times == 1 { self.text.clone() } else { format!("{} (said {} times)", self.text, self.times) }
    }
}

fn without_numbers(text: &str) -> impl Iterator<Item = char> {
    text.chars().filter(|letter| !letter.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_again_stands_once_with_its_last_numbers_and_a_count() {
        let mut warnings = Warnings::default();
        warnings.remind("no ramp after 5 minutes".into());
        warnings.add("groups that did not arrive: 7".into());
        let told = warnings.remind("no ramp after 10 minutes".into());
        warnings.add("groups that did not arrive: 9".into());
        assert_eq!(told, "no ramp after 10 minutes (said 2 times)");
        let all: Vec<String> = warnings.sentences().collect();
        assert_eq!(all, [&told, "groups that did not arrive: 7", "groups that did not arrive: 9"]);
    }
}
