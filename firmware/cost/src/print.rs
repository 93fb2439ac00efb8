//! Lines of a name and a number, by semihosting.

use cortex_m::asm::semihosting_syscall;

const SYS_WRITE0: u32 = 0x04;
const SYS_EXIT: u32 = 0x18;
const APPLICATION_EXIT: u32 = 0x2_0026;

/// The longest line.
const LINE: usize = 64;

/// Prints a name and a number.
pub fn line(name: &str, number: u32) {
    let mut digits = [0; 10];
    let mut left = number;
    let mut first = digits.len();
    while left > 0 || first == digits.len() {
        first -= 1;
        digits[first] = b'0' + (left % 10) as u8;
        left /= 10;
    }
    let mut text = [0; LINE];
    let parts = [name.as_bytes(), b" ", &digits[first..], b"\n\0"];
    for (slot, byte) in text.iter_mut().zip(parts.into_iter().flatten()) {
        *slot = *byte;
    }
    text[LINE - 1] = 0;
    // SAFETY: the text ends in a zero.
    unsafe {
        semihosting_syscall(SYS_WRITE0, text.as_ptr() as u32);
    }
}

/// Ends the emulation.
pub fn exit() -> ! {
    loop {
        // SAFETY: the operation takes a number.
        unsafe {
            semihosting_syscall(SYS_EXIT, APPLICATION_EXIT);
        }
    }
}
