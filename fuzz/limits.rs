//! What an input may cost: 64 MiB beyond what was allocated before it, and a second of this processor.

use std::alloc::System;
use std::time::Duration;

use cap::Cap;
use cpu_time::ThreadTime;

/// An allocation beyond its limit fails, and a failed allocation ends the process: the fuzzer reports it as a crash.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

const MOST_BYTES: usize = 64 << 20;
const MOST_TIME: Duration = Duration::from_secs(1);

/// Runs a parser on an input within the limits.
pub fn held(parser: fn(&[u8]), bytes: &[u8]) {
    // Cannot fail: it is more than is allocated.
    let _ = ALLOCATOR.set_limit(ALLOCATOR.allocated() + MOST_BYTES);
    let started = ThreadTime::now();
    parser(bytes);
    let took = started.elapsed();
    let _ = ALLOCATOR.set_limit(usize::MAX);
    assert!(took < MOST_TIME, "{} bytes took {took:?}", bytes.len());
}
