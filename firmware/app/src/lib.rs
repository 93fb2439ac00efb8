//! What the boards have in common besides `zerorate-device`: how RTIC shares the compensator, the bytes on their way from
//! the host, the memory that a restart does not clear, and what a hard fault does.
//!
//! It holds no registers: a board's folder has its clock, pins, lines and interrupt vectors.

#![no_std]

use core::mem::MaybeUninit;

use heapless::spsc::Queue;
use zerorate_device::acquisition::Acquisition;
use zerorate_device::application::Shared;
use zerorate_device::compensator::Compensator;
use zerorate_device::restart::Kept;
use zerorate_device::trim_part::TrimPart;

/// Bytes of the host that may wait for the task: two frames of the longest kind but one.
pub type Received = Queue<u8, 1024>;

/// The compensator as RTIC shares it.
pub struct Locked<M>(pub M);

impl<A: Acquisition, P: TrimPart, M: rtic::Mutex<T = Compensator<A, P>>> Shared for Locked<M> {
    type Acquisition = A;
    type Part = P;

    fn lock<R>(&mut self, act: impl FnOnce(&mut Compensator<A, P>) -> R) -> R {
        self.0.lock(act)
    }
}

#[allow(unsafe_code)]
// SAFETY: the section `.uninit` of cortex-m-rt is RAM that start-up code leaves as it is; nothing else is placed by it.
#[unsafe(link_section = ".uninit.restarts")]
static KEPT: MaybeUninit<Kept> = MaybeUninit::uninit();

/// What is kept through a restart of the processor.
pub fn kept() -> &'static Kept {
    #[allow(unsafe_code)]
    // SAFETY: atomic words, of which every bit pattern is one; the static is never written but through them.
    unsafe {
        KEPT.assume_init_ref()
    }
}

/// Counts a fault and restarts the processor. The wiper is left as it is.
pub fn restart() -> ! {
    kept().panicked();
    cortex_m::peripheral::SCB::sys_reset()
}

#[allow(unsafe_code)]
// SAFETY: it touches words of memory that are there in any state, and restarts.
#[cortex_m_rt::exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    restart()
}
