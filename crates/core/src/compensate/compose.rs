//! The host's half: models in f64, and the integers that they are rounded to. It points at the integer half, which knows
//! nothing of it.

mod edges;
mod law;
mod low_pass;
mod rounding;

pub use law::StaticLaw;
pub use low_pass::LowPass;
