//! What two outputs differ in.

use std::fmt;

use serde_json::Value;

/// Keys whose values are no figures: the clock's time, and the version that wrote it.
const LEFT_OUT: [&str; 2] = ["wall_s", "created_by"];

/// Something that is not the same.
#[derive(Debug, PartialEq)]
pub struct Difference {
    /// Where: `axes.x.fit.rms`, `tests[2].mean_counts`.
    path: String,
    before: String,
    after: String,
    /// Of two numbers, their difference by the larger of them.
    relative: Option<f64>,
}

impl Difference {
    /// Two words.
    pub fn of_words(path: &str, before: &str, after: &str) -> Self {
        Self { path: path.into(), before: before.into(), after: after.into(), relative: None }
    }

    /// The same within something.
    pub fn under(self, path: &str) -> Self {
        Self { path: [path, &self.path].concat(), ..self }
    }

    /// How large it is: infinite where there are not two numbers.
    pub fn relative(&self) -> f64 {
        self.relative.unwrap_or(f64::INFINITY)
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { path, before, after, relative } = self;
        write!(f, "{path}: {before} -> {after}")?;
        relative.map_or(Ok(()), |relative| write!(f, " ({relative:.1e})"))
    }
}

/// The figures of two values that differ.
pub fn between(before: &Value, after: &Value) -> Vec<Difference> {
    let mut found = Vec::new();
    walk(String::new(), Some(before), Some(after), &mut found);
    found
}

fn walk(path: String, before: Option<&Value>, after: Option<&Value>, found: &mut Vec<Difference>) {
    match (before, after) {
        (Some(Value::Object(before)), Some(Value::Object(after))) => {
            let added = after.keys().filter(|key| !before.contains_key(*key));
            for key in before.keys().chain(added).filter(|key| !LEFT_OUT.contains(&key.as_str())) {
                let point = if path.is_empty() { "" } else { "." };
                walk(format!("{path}{point}{key}"), before.get(key), after.get(key), found);
            }
        }
        (Some(Value::Array(before)), Some(Value::Array(after))) => {
            for place in 0..before.len().max(after.len()) {
                walk(format!("{path}[{place}]"), before.get(place), after.get(place), found);
            }
        }
        _ => {
            let text = |value: Option<&Value>| value.map_or_else(|| "nothing".to_owned(), Value::to_string);
            let number = |value: Option<&Value>| value.and_then(Value::as_f64);
            let relative = number(before).zip(number(after)).map(|(a, b)| relative(a, b));
            // As it is written: 0.0 equals -0.0.
            let (before, after) = (text(before), text(after));
            if before != after {
                found.push(Difference { path, before, after, relative });
            }
        }
    }
}

fn relative(a: f64, b: f64) -> f64 {
    // Two zeros are written differently, and are no distance apart.
    if a.total_cmp(&b).is_eq() || a.abs() + b.abs() == 0.0 { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) }
}

/// Where two files begin to differ.
pub fn between_bytes(before: &[u8], after: &[u8]) -> Vec<Difference> {
    if before == after {
        return Vec::new();
    }
    let at = before.iter().zip(after).take_while(|(a, b)| a == b).count();
    let length = |bytes: &[u8]| format!("{} bytes", bytes.len());
    vec![Difference::of_words(&format!("from byte {at} on"), &length(before), &length(after))]
}

/// The words of a printed table that differ, the numbers among them as numbers.
pub fn between_lines(before: &str, after: &str) -> Vec<Difference> {
    let value = |text: &str| {
        let words = text.split_whitespace();
        words.map(|word| word.parse::<f64>().map_or_else(|_| Value::from(word), Value::from)).collect::<Value>()
    };
    let lines = |text: &str| text.lines().map(value).collect::<Value>();
    between(&lines(before), &lines(after))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn told(found: &[Difference]) -> Vec<String> {
        found.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn every_digit_counts_and_the_clock_does_not() {
        let before =
            json!({ "wall_s": 4.1, "axes": { "x": { "rms": 0.1, "n": [1, 2] } }, "created_by": "zerorate 0.1.0" });
        assert_eq!(between(&before, &before), []);
        let mut after = before.clone();
        after["wall_s"] = 5.0.into();
        after["created_by"] = "zerorate 0.2.0".into();
        assert_eq!(between(&before, &after), []);
        after["axes"]["x"]["rms"] = 0.100_000_000_000_000_02.into();
        after["axes"]["x"]["n"] = json!([1, 2, 3]);
        let found = between(&before, &after);
        assert_eq!(told(&found), ["axes.x.rms: 0.1 -> 0.10000000000000002 (1.4e-16)", "axes.x.n[2]: nothing -> 3"]);
        assert!(found[1].relative().is_infinite());
    }

    #[test]
    fn what_is_new_gone_or_of_another_kind_is_told() {
        let found = between(&json!({ "a": 1, "b": "x" }), &json!({ "b": 2, "c": null }));
        assert_eq!(told(&found), ["a: 1 -> nothing", "b: \"x\" -> 2", "c: nothing -> null"]);
        // The sign of a zero is a digit too, and so is a float that was a whole number.
        assert_eq!(
            told(&between(&json!([1, 0.0]), &json!([1.0, -0.0]))),
            ["[0]: 1 -> 1.0 (0.0e0)", "[1]: 0.0 -> -0.0 (0.0e0)"]
        );
    }

    #[test]
    fn files_are_compared_by_their_bytes_and_tables_by_their_words() {
        assert_eq!(told(&between_bytes(b"abc", b"abcd")), ["from byte 3 on: 3 bytes -> 4 bytes"]);
        assert_eq!(between_bytes(b"abc", b"abc"), []);
        assert_eq!(
            told(&between_lines("rms x\nzerorate 0.81", "rms x\nzerorate 0.82")),
            ["[1][1]: 0.81 -> 0.82 (1.2e-2)"]
        );
    }
}
