//! What is left of a panic: a count in memory that a restart does not clear.
//!
//! A panic does nothing to the wiper - the potentiometer keeps its tap while the processor starts anew - counts itself here,
//! and restarts. The count goes out with the fault counters; it begins anew when power comes.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};

/// What stands beside the count when it is one: memory holds anything when power comes.
const MARK: u32 = 0x5A52_5354;

/// Mark and count.
struct Kept {
    mark: AtomicU32,
    restarts: AtomicU32,
}

#[allow(unsafe_code)]
// SAFETY: the section `.uninit` of cortex-m-rt is RAM that start-up code leaves as it is; nothing else is placed by it.
#[unsafe(link_section = ".uninit.restarts")]
static KEPT: MaybeUninit<Kept> = MaybeUninit::uninit();

fn kept() -> &'static Kept {
    #[allow(unsafe_code)]
    // SAFETY: two atomic words, of which every bit pattern is one; the static is never written but through them.
    unsafe {
        KEPT.assume_init_ref()
    }
}

/// Restarts after a panic or a fault since power came.
#[must_use]
pub fn restarts() -> u32 {
    let kept = kept();
    if kept.mark.load(Ordering::Relaxed) != MARK {
        kept.restarts.store(0, Ordering::Relaxed);
        kept.mark.store(MARK, Ordering::Relaxed);
    }
    kept.restarts.load(Ordering::Relaxed)
}

/// Counts a fault and restarts the processor. The wiper is left as it is.
pub fn restart() -> ! {
    let count = restarts().saturating_add(1);
    kept().restarts.store(count, Ordering::Relaxed);
    cortex_m::peripheral::SCB::sys_reset()
}
