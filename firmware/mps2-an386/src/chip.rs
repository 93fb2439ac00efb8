//! The chip as far as the application needs it: its interrupts and UART0 (ARM DAI 0386, "Cortex-M4 on the MPS2", and the
//! Cortex-M System Design Kit's APB UART).

use cortex_m::interrupt::InterruptNumber;

/// Bits of an interrupt's priority (CMSIS for MPS2: `__NVIC_PRIO_BITS`).
pub const NVIC_PRIO_BITS: u8 = 3;

/// Interrupt lines in use. The two ports have no pins here, and time is the bench's: software pends them and the timer's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(non_camel_case_types)]
#[repr(u16)]
pub enum Interrupt {
    /// A byte has come on UART0.
    UART0_RX = 0,
    /// GPIO 0: the acquisition port's data ready line.
    PORT0 = 6,
    /// GPIO 1: the console has work.
    PORT1 = 7,
    /// The tick.
    TIMER0 = 8,
}

pub use Interrupt as interrupt;

#[allow(unsafe_code)]
// SAFETY: the numbers are those of the vector table below, and each is below the chip's 32.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

#[allow(unsafe_code)]
unsafe extern "C" {
    fn UART0_RX();
    fn PORT0();
    fn PORT1();
    fn TIMER0();
    fn DefaultHandler();
}

#[allow(unsafe_code)]
// SAFETY: cortex-m-rt's link.x places this section after the exceptions, where the processor looks for interrupt vectors.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); 32] = {
    let mut table: [unsafe extern "C" fn(); 32] = [DefaultHandler; 32];
    table[Interrupt::UART0_RX as usize] = UART0_RX;
    table[Interrupt::PORT0 as usize] = PORT0;
    table[Interrupt::PORT1 as usize] = PORT1;
    table[Interrupt::TIMER0 as usize] = TIMER0;
    table
};

/// UART0.
const UART0: *mut u32 = 0x4000_4000 as *mut u32;
const DATA: usize = 0;
const STATE: usize = 1;
const CONTROL: usize = 2;
const INTERRUPT_CLEAR: usize = 3;
const BAUD_DIVIDER: usize = 4;

const TRANSMIT_FULL: u32 = 1 << 0;
const RECEIVE_FULL: u32 = 1 << 1;
const TRANSMIT_ENABLE: u32 = 1 << 0;
const RECEIVE_ENABLE: u32 = 1 << 1;
const RECEIVE_INTERRUPT_ENABLE: u32 = 1 << 3;
const RECEIVE_INTERRUPT: u32 = 1 << 1;
/// 25 MHz / 217 = 115 200 baud; an emulated line has no speed.
const DIVIDER: u32 = 217;

fn read(register: usize) -> u32 {
    #[allow(unsafe_code)]
    // SAFETY: a word-aligned register of UART0, which only this module touches.
    unsafe {
        UART0.add(register).read_volatile()
    }
}

fn write(register: usize, word: u32) {
    #[allow(unsafe_code)]
    // SAFETY: as in `read`.
    unsafe {
        UART0.add(register).write_volatile(word);
    }
}

/// Starts UART0, its receive interrupt on; its two halves.
pub fn uart0() -> (Receiving, Sending) {
    write(BAUD_DIVIDER, DIVIDER);
    write(CONTROL, TRANSMIT_ENABLE | RECEIVE_ENABLE | RECEIVE_INTERRUPT_ENABLE);
    (Receiving(()), Sending { sent: 0 })
}

/// The half that the interrupt reads.
pub struct Receiving(());

impl Receiving {
    /// The byte that has come, if any; its interrupt is cleared.
    pub fn take(&mut self) -> Option<u8> {
        write(INTERRUPT_CLEAR, RECEIVE_INTERRUPT);
        let byte = (read(STATE) & RECEIVE_FULL != 0).then(|| read(DATA))?;
        u8::try_from(byte & 0xFF).ok()
    }
}

/// The half that the console writes.
pub struct Sending {
    sent: u32,
}

impl Sending {
    /// Bytes sent since the start.
    pub const fn sent(&self) -> u32 {
        self.sent
    }

    /// Sends all bytes.
    pub fn send(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            while read(STATE) & TRANSMIT_FULL != 0 {}
            write(DATA, u32::from(byte));
        }
        self.sent = self.sent.wrapping_add(u32::try_from(bytes.len()).unwrap_or(0));
    }
}
