//! What the boards have in common besides `zerorate-device`: how RTIC shares the compensator, the bytes on their way from
//! the host, the memory that a restart does not clear, and what a panic and a hard fault do.
//!
//! It holds no registers: a board's folder has its clock, pins, lines and interrupt vectors.

#![no_std]

pub mod health;

use core::mem::MaybeUninit;
use core::panic::PanicInfo;

use cortex_m::peripheral::SCB;
use heapless::spsc::Queue;
use zerorate_core::wire::{FaultRegisters, Stop};
use zerorate_device::acquisition::Acquisition;
use zerorate_device::application::Shared;
use zerorate_device::compensator::{Compensator, Memory};
use zerorate_device::restart::Kept;
use zerorate_device::trim_part::TrimPart;

/// Bytes of the host that may wait for the task: two frames of the longest kind but one.
pub type Received = Queue<u8, 1024>;

/// The compensator as RTIC shares it.
pub struct Locked<M>(pub M);

impl<A: Acquisition, P: TrimPart, M: rtic::Mutex<T = Compensator<A, P, &'static mut Memory>>> Shared for Locked<M> {
    type Acquisition = A;
    type Part = P;
    type Memory = &'static mut Memory;

    fn lock<R>(&mut self, act: impl FnOnce(&mut Compensator<A, P, Self::Memory>) -> R) -> R {
        self.0.lock(act)
    }
}

/// Has the compensator do an interrupt's work, which its record decides.
pub fn serve<C, R>(compensator: &mut impl rtic::Mutex<T = C>, work: impl FnOnce(&mut C) -> R) -> R {
    kept().at_record(|| compensator.lock(work))
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

/// Keeps where the program has panicked, and restarts the processor. The wiper is left as it is.
pub fn panicked(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    let (file, line) = info.location().map_or(("", 0), |place| (place.file(), place.line()));
    restart(&Stop::panic_at(file, line))
}

/// Keeps where the processor could not go on, and restarts it. The wiper is left as it is.
#[allow(unsafe_code)]
// SAFETY: it reads registers that reading does not change, touches words of memory that are there in any state, and restarts.
#[cortex_m_rt::exception]
unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
    let scb = unsafe { &*SCB::PTR };
    restart(&Stop::Fault(FaultRegisters {
        pc: frame.pc(),
        lr: frame.lr(),
        cfsr: scb.cfsr.read(),
        hfsr: scb.hfsr.read(),
        mmfar: scb.mmfar.read(),
        bfar: scb.bfar.read(),
    }))
}

fn restart(stop: &Stop) -> ! {
    kept().stopped(stop);
    SCB::sys_reset()
}
