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
    pub fn between<T>(&self, act: impl FnOnce() -> T) -> u32 {
        let before = SYST::get_current();
        core::hint::black_box(act());
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
    "nop", "nop", "nop", "nop", "nop", "nop", "nop", "nop", "nop",
    "bx lr",
);

/// Counts a function of any signature: the instructions from its call to its return, both counted.
///
/// `$to` is the type of the function, so that one that only returns can be called in the same way.
#[macro_export]
macro_rules! count {
    ($counter:expr, $function:expr, $to:ty, ($($argument:expr),*)) => {{
            // SAFETY: it returns at once, whatever its arguments are; what it returns is looked at by nobody.
        let nothing: $to = unsafe { core::mem::transmute(core::hint::black_box($crate::cost_return as *const ())) };
        let function: $to = core::hint::black_box($function);
        let mut raw = [0; 2];
        for (raw, function) in raw.iter_mut().zip([nothing, function]) {
            *raw = $counter.between(|| function($($argument),*));
        }
        // The call, and the return that the other has as well.
        raw[1] - raw[0] + 2
    }};
}
