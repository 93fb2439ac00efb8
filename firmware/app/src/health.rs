//! How a board finds itself: how deep its stack ever was, and how long its interrupt ever took.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::{DCB, DWT};
use zerorate_core::wire::{Health, Interrupt, Stack};

/// What start-up code paints all of the stack with (feature `paint-stack` of cortex-m-rt).
const PAINT: u32 = cortex_m_rt::STACK_PAINT_VALUE;

/// The longest interrupt, cycles.
static LONGEST: AtomicU32 = AtomicU32::new(0);
/// The processor's clock; 0 where no cycles are counted.
static CYCLES_PER_US: AtomicU32 = AtomicU32::new(0);

#[allow(unsafe_code)]
// SAFETY: the linker's marks of the stack's ends, of which only the addresses are looked at.
unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Has cycles counted from now on, where the processor can.
pub fn count_cycles(dcb: &mut DCB, dwt: &mut DWT, cycles_per_us: u32) {
    if DWT::has_cycle_counter() {
        dcb.enable_trace();
        dwt.enable_cycle_counter();
        CYCLES_PER_US.store(cycles_per_us, Ordering::Relaxed);
    }
}

/// Does an interrupt's work, and remembers how long it took if it was the longest.
pub fn timed<R>(work: impl FnOnce() -> R) -> R {
    let began = DWT::cycle_count();
    let done = work();
    LONGEST.fetch_max(DWT::cycle_count().wrapping_sub(began), Ordering::Relaxed);
    done
}

/// How the board finds itself.
#[must_use]
pub fn health() -> Health {
    let cycles_per_us = CYCLES_PER_US.load(Ordering::Relaxed);
    let longest_cycles = LONGEST.load(Ordering::Relaxed);
    let interrupt = (cycles_per_us > 0).then_some(Interrupt { longest_cycles, cycles_per_us });
    Health { stack: Some(stack()), interrupt }
}

/// The stack grows down: what is still painted at its end was never used.
fn stack() -> Stack {
    let (top, end) = (&raw const _stack_start as usize, &raw const _stack_end as usize);
    let words = (top - end) / size_of::<u32>();
    let painted = (0..words).take_while(|word| word_at(end + word * size_of::<u32>()) == PAINT).count();
    let bytes = |words: usize| u32::try_from(words * size_of::<u32>()).unwrap_or(u32::MAX);
    Stack { size: bytes(words), used: bytes(words - painted) }
}

fn word_at(address: usize) -> u32 {
    #[allow(unsafe_code)]
    // SAFETY: an aligned word of RAM between the stack's ends, read as it is: nothing is assumed of what it holds.
    unsafe {
        core::ptr::read_volatile(address as *const u32)
    }
}
