//! Virtual time: ticks of 1/336 microsecond, which both the core's 168 MHz and the 16 MHz that it starts with divide.

/// Ticks since power came to the bench.
pub type Ticks = u64;

/// Ticks a microsecond.
pub const MICROSECOND: Ticks = 336;
/// Ticks a millisecond.
pub const MILLISECOND: Ticks = 1000 * MICROSECOND;
/// Ticks a second.
pub const SECOND: Ticks = 1000 * MILLISECOND;
/// An instant that does not come.
pub const NEVER: Ticks = Ticks::MAX;

/// Whole nanoseconds: 336 ticks are 1000.
pub const fn nanoseconds(ticks: Ticks) -> u64 {
    ticks * 125 / 42
}

/// The first tick at which so many nanoseconds have gone by.
pub const fn ticks_of_ns(ns: u64) -> Ticks {
    (ns * 42).div_ceil(125)
}

/// Milliseconds, to be printed.
#[allow(clippy::cast_precision_loss)]
pub fn milliseconds(ticks: Ticks) -> f64 {
    ticks as f64 / MILLISECOND as f64
}
