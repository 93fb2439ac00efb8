//! What may be public though nobody uses it.

/// The file, the name, and why it is kept.
pub const KEPT: [(&str, &str, &str); 1] =
    [("crates/bench/src/simulated.rs", "bare_device", "bench's tests break its plant and damage its line")];
