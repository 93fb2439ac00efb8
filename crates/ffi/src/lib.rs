// With an operating system the standard library's panic handler serves; on the bare board there is ours.
#![cfg_attr(target_os = "none", no_std)]
#![doc = include_str!("../README.md")]

mod interface;
mod unit;

pub use interface::*;
pub use unit::*;

/// Nothing here is meant to panic; should it, the wiper stays where it is and the board's watchdog has the word.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
