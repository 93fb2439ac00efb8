//! What many units are told in the same words, said once.

use crate::number::whole;

/// Names that are told before the rest are counted.
const SHOWN: usize = 3;

/// Sentences, each with those that it was told of; the ones that few are told of come first.
pub fn alike<T>(told: impl IntoIterator<Item = (T, String)>) -> Vec<(String, Vec<T>)> {
    let mut all: Vec<(String, Vec<T>)> = Vec::new();
    let mut places: std::collections::HashMap<String, usize> = std::collections::HashMap::new();
    for (whom, sentence) in told {
        let place = *places.entry(sentence.clone()).or_insert(all.len());
        if place == all.len() {
            all.push((sentence, Vec::new()));
        }
        all[place].1.push(whom);
    }
    all.sort_by_key(|(_, whom)| whom.len());
    all
}

/// The first three of some names, and how many more there are.
#[must_use]
pub fn few(names: &[&str]) -> String {
    let first = names[..names.len().min(SHOWN)].join(", ");
    if names.len() > SHOWN { format!("{first} and {} more", whole((names.len() - SHOWN) as u64)) } else { first }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_many_are_told_alike_stands_once_and_after_what_one_is_told() {
        let told = [(1, "a"), (1, "b"), (2, "a"), (3, "c"), (3, "a")].map(|(whom, text)| (whom, text.to_owned()));
        let all: Vec<(String, Vec<i32>)> =
            [("b", vec![1]), ("c", vec![3]), ("a", vec![1, 2, 3])].map(|(text, whom)| (text.to_owned(), whom)).into();
        assert_eq!(alike(told), all);
        assert_eq!(few(&["x"]), "x");
        assert_eq!(few(&["x", "y", "z"]), "x, y, z");
        assert_eq!(few(&["x", "y", "z", "u", "v"]), "x, y, z and 2 more");
    }
}
