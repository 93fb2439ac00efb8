//! Wall-clock times that a log tells.

use std::ops::Range;
use std::time::{Duration, SystemTime};

/// Seconds since 1970 at which a clock can stand. Before the first it was never set: PX4 takes it so (`GPS_EPOCH_SECS`, in
/// February 2009), and a receiver that has no fix says 0 or 1980. From the last on, the year 2100, it is damage.
const SET_S: Range<u64> = 1_234_567_890..4_102_444_800;

/// A time by its microseconds since 1970, UTC; `None` where no clock that was set says so.
#[must_use]
pub fn wall_clock(utc_us: u64) -> Option<SystemTime> {
    SET_S.contains(&(utc_us / 1_000_000)).then(|| SystemTime::UNIX_EPOCH + Duration::from_micros(utc_us))
}
