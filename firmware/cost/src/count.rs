//! Instructions, by the emulator's own clock.
//!
//! Under `-icount shift=10` every instruction takes 1024 ns of virtual time, and SysTick counts its 25 MHz: 25.6 ticks an
//! instruction. Two readings, less those of a call that only returns, are exact.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// SysTick's 24 bits.
const WRAP: u32 = 1 << 24;

/// The clock that counts instructions.
pub struct Counter(SYST);

impl Counter {
    /// Starts it.
    pub fn new(mut syst: SYST) -> Self {
        syst.set_clock_source(SystClkSource::Core);
        syst.set_reload(WRAP - 1);
        syst.clear_current();
        syst.enable_counter();
        Self(syst)
    }

    /// Instructions from one reading of the clock to the next, with what the readings take.
    #[inline(always)]
    pub fn between(&self, act: impl FnOnce()) -> u32 {
        let before = SYST::get_current();
        act();
        let after = SYST::get_current();
        let ticks = before.wrapping_sub(after) % WRAP;
        // 25.6 ticks an instruction, to the nearest.
        (ticks * 10 + 128) / 256
    }
}

core::arch::global_asm!(
    ".thumb_func",
    ".global cost_return",
    "cost_return:",
    "bx lr",
    ".thumb_func",
    ".global cost_ten",
    "cost_ten:",
    "nop",
    "nop",
    "nop",
    "nop",
    "nop",
    "nop",
    "nop",
    "nop",
    "nop",
    "bx lr",
);

/// Counts a function: the instructions from its call to its return, both counted.
///
/// Its arguments stand with their types, so that a function that only returns can be called from the same place: what is
/// done to call it is then in both counts.
#[macro_export]
macro_rules! count {
    ($counter:expr, $function:expr, fn($($argument:expr => $type:ty),*) -> $out:ty) => {{
        type Function = fn($($type),*) -> core::mem::MaybeUninit<$out>;
        // SAFETY: `MaybeUninit` has the form of what is in it. The function that returns at once leaves it as it is,
        // and nobody looks at it.
        let functions: [Function; 2] = unsafe {
            [
                core::mem::transmute::<*const (), Function>($crate::cost_return as *const ()),
                core::mem::transmute::<*const (), Function>($function as *const ()),
            ]
        };
        let mut counts = [0; 2];
        for (count, function) in counts.iter_mut().zip(core::hint::black_box(&functions[..])) {
            *count = $counter.between(|| {
                let _ = function($($argument),*);
            });
        }
        // The call, and the return that the other has as well.
        counts[1] - counts[0] + 2
    }};
}
