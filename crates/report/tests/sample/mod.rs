//! Reports of invented runs, the same every time: what the report's tests read and its example writes.

mod board_run;
mod log;
mod lot;

pub use board_run::board_run;
pub use log::log;
pub use lot::lot;

/// Noise of about unit variance that needs no generator: the sum of twelve uniform values of a hash.
pub fn noise(seed: u64) -> f64 {
    let uniform = |k: u64| {
        let mut z = (seed * 12 + k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..12).map(uniform).sum::<f64>() - 6.0
}
