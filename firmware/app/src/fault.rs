//! What is left of a panic: facts in memory that a restart does not clear.
//!
//! A panic does nothing to the wiper - the potentiometer keeps its tap while the processor starts anew - counts itself here,
//! and restarts. The count goes out with the fault counters, the cause with the identity; the taps that were commanded last
//! are taken up again, so that no wiper moves because a program has failed. All begin anew when power comes.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};

use zerorate_core::units::Taps;
use zerorate_core::wire::ResetCause;

/// What stands beside the facts when they are some: memory holds anything when power comes.
const MARK: u32 = 0x5A52_5354;

/// Mark and facts.
struct Kept {
    mark: AtomicU32,
    restarts: AtomicU32,
    /// Whether the restart under way is one of these.
    panicked: AtomicU32,
    /// X's tap in the lower half, Y's in the upper.
    taps: AtomicU32,
}

#[allow(unsafe_code)]
// SAFETY: the section `.uninit` of cortex-m-rt is RAM that start-up code leaves as it is; nothing else is placed by it.
#[unsafe(link_section = ".uninit.restarts")]
static KEPT: MaybeUninit<Kept> = MaybeUninit::uninit();

fn kept() -> &'static Kept {
    #[allow(unsafe_code)]
    // SAFETY: atomic words, of which every bit pattern is one; the static is never written but through them.
    let kept = unsafe { KEPT.assume_init_ref() };
    if kept.mark.load(Ordering::Relaxed) != MARK {
        kept.restarts.store(0, Ordering::Relaxed);
        kept.panicked.store(0, Ordering::Relaxed);
        keep(kept, [Taps::MIDDLE; 2]);
        kept.mark.store(MARK, Ordering::Relaxed);
    }
    kept
}

fn keep(kept: &Kept, [x, y]: [Taps; 2]) {
    kept.taps.store(u32::from(y.get()) << 16 | u32::from(x.get()), Ordering::Relaxed);
}

/// For a board that can tell that its watchdog started it.
pub const WATCHDOG: ResetCause = ResetCause::Watchdog;

/// What is known of the start.
#[derive(Debug, Clone, Copy)]
pub struct Started {
    /// Why the program started.
    pub reset: ResetCause,
    /// Restarts after a panic or a fault since power came.
    pub restarts: u32,
    /// The taps that were commanded last.
    pub taps: [Taps; 2],
}

/// What is known of this start; to be asked once.
#[must_use]
pub fn started() -> Started {
    let kept = kept();
    let restarts = kept.restarts.load(Ordering::Relaxed);
    // Without a panic it was the power, or a reset that only the board could tell from it.
    let panicked = kept.panicked.load(Ordering::Relaxed) != 0;
    kept.panicked.store(0, Ordering::Relaxed);
    let taps = kept.taps.load(Ordering::Relaxed);
    let tap = |half: u32| u16::try_from(half).ok().and_then(Taps::new).unwrap_or(Taps::MIDDLE);
    let reset = if panicked { ResetCause::Panic } else { ResetCause::Power };
    Started { reset, restarts, taps: [tap(taps & 0xFFFF), tap(taps >> 16)] }
}

/// Keeps the taps that were commanded last.
pub fn keep_taps(taps: [Taps; 2]) {
    keep(kept(), taps);
}

/// Counts a fault and restarts the processor. The wiper is left as it is.
pub fn restart() -> ! {
    let kept = kept();
    kept.restarts.store(kept.restarts.load(Ordering::Relaxed).saturating_add(1), Ordering::Relaxed);
    kept.panicked.store(1, Ordering::Relaxed);
    cortex_m::peripheral::SCB::sys_reset()
}
