//! What may be public though nobody uses it.

/// The file, the name, and why it is kept.
pub const KEPT: [(&str, &str, &str); 4] = [
    ("crates/bench/src/simulated.rs", "bare_device", "bench's tests break its plant and damage its line"),
    (
        "crates/core/src/drift/polynomial.rs",
        "Polynomial::from_raw_coefficients",
        "tests of five crates give the paper's own numbers",
    ),
    ("crates/recording/src/named.rs", "serialize", "serde calls it where a field of cal has it by `with`"),
    ("crates/recording/src/named.rs", "deserialize", "the same"),
];
