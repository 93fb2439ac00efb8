//! The core's own registers (ARMv7-M, B3.2 and B3.3): where vectors are, the request for a reset, the float unit's access, and
//! the counter that delays are made with, and the one that cycles are counted with (C1.8).

use super::time::Ticks;

const SYST_CSR: u32 = 0x010;
const SYST_RVR: u32 = 0x014;
const SYST_CVR: u32 = 0x018;
const ICSR: u32 = 0xD04;
const VTOR: u32 = 0xD08;
const AIRCR: u32 = 0xD0C;
const CFSR: u32 = 0xD28;
const HFSR: u32 = 0xD2C;
const MMFAR: u32 = 0xD34;
const BFAR: u32 = 0xD38;
const CPACR: u32 = 0xD88;
const DEMCR: u32 = 0xDFC;
const TRACE_ENABLE: u32 = 1 << 24;

const DWT_CTRL: u32 = 0x000;
const DWT_CYCCNT: u32 = 0x004;
/// The key, and SYSRESETREQ.
const RESET_REQUEST: u32 = 0x05FA_0004;
const COUNT_FLAG: u32 = 1 << 16;
const CORE_CLOCK: u32 = 1 << 2;
const ENABLE: u32 = 1 << 0;

/// A fault's kind, as CFSR has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// An instruction was fetched where nothing answers: IBUSERR.
    Fetch = 1 << 8,
    /// Data were read or written where nothing answers: PRECISERR.
    Data = 1 << 9,
    /// An instruction that is none, or of a unit that is off: UNDEFINSTR.
    Instruction = 1 << 16,
}

/// Registers from 0xE000E000 on that are not the NVIC's.
#[derive(Default)]
pub struct System {
    csr: u32,
    reload: u32,
    /// When the counter is at its end next, and how long it takes.
    wraps_at: Ticks,
    period: Ticks,
    /// What has been waited for it since this was last asked.
    delayed: Ticks,
    vectors: u32,
    cpacr: u32,
    demcr: u32,
    dwt_ctrl: u32,
    /// What the last fault was, and the address that it could not reach.
    cfsr: u32,
    bfar: u32,
    /// A reset was asked for.
    pub reset_asked: bool,
}

impl System {
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// A fault: its kind, and the address that did not answer, where there is one.
    pub fn fault(&mut self, kind: Fault, address: Option<u32>) {
        const BFARVALID: u32 = 1 << 15;
        self.cfsr |= kind as u32 | if address.is_some() { BFARVALID } else { 0 };
        self.bfar = address.unwrap_or(0);
    }

    /// Where the vectors are; 0 is the flash's alias.
    pub const fn vectors(&self) -> u32 {
        if self.vectors == 0 { super::memory::FLASH } else { self.vectors }
    }

    /// Whether the float unit may be used.
    pub const fn has_float(&self) -> bool {
        self.cpacr >> 20 & 0xF == 0xF
    }

    pub fn read(&mut self, offset: u32, now: Ticks, exception: u32) -> Option<(u32, Option<Ticks>)> {
        let word = match offset {
            SYST_CSR => {
                if self.csr & ENABLE == 0 {
                    return Some((self.csr, None));
                }
                if self.wraps_at > now {
                    return Some((self.csr, Some(self.wraps_at)));
                }
                self.wraps_at += self.period * ((now - self.wraps_at) / self.period + 1);
                self.delayed += self.period;
                self.csr | COUNT_FLAG
            }
            SYST_RVR => self.reload,
            ICSR => exception,
            VTOR => self.vectors,
            AIRCR => 0xFA05_0000,
            CPACR => self.cpacr,
            DEMCR => self.demcr,
            CFSR => self.cfsr,
            // FORCED: a handler of its own is off.
            HFSR => u32::from(self.cfsr != 0) << 30,
            MMFAR => 0,
            BFAR => self.bfar,
            // Priorities of the system's exceptions, of which none is used; SCR, CCR and SHCSR as after reset; FPCCR.
            0xD10 | 0xD18..=0xD24 => 0,
            0xD14 => 0x200,
            0xF34 => 0xC000_0000,
            _ => return None,
        };
        Some((word, None))
    }

    /// How long the program has waited for the counter since this was last asked: its delays.
    pub const fn take_delayed(&mut self) -> Ticks {
        std::mem::replace(&mut self.delayed, 0)
    }

    /// A word of the trace unit: its control, and the cycles counted, which stand still until both are told to run.
    pub const fn trace(&self, offset: u32, now: Ticks, core_ticks: Ticks) -> Option<u32> {
        let runs = self.demcr & TRACE_ENABLE != 0 && self.dwt_ctrl & ENABLE != 0;
        match offset {
            DWT_CTRL => Some(self.dwt_ctrl),
            #[allow(clippy::cast_possible_truncation)] // the counter has 32 bits
            DWT_CYCCNT => Some(if runs { (now / core_ticks) as u32 } else { 0 }),
            _ => None,
        }
    }

    /// A write to the trace unit; `false` if there is no such register.
    pub const fn write_trace(&mut self, offset: u32, word: u32) -> bool {
        let is_control = offset == DWT_CTRL;
        if is_control {
            self.dwt_ctrl = word;
        }
        is_control
    }

    /// A write; `false` if there is no such register.
    pub fn write(&mut self, offset: u32, word: u32, now: Ticks, core_ticks: Ticks) -> bool {
        match offset {
            SYST_CSR => {
                let begins = self.csr & ENABLE == 0 && word & ENABLE != 0;
                self.csr = word & 7;
                if begins {
                    let cycle = if word & CORE_CLOCK == 0 { 8 * core_ticks } else { core_ticks };
                    self.period = cycle * Ticks::from(self.reload + 1);
                    self.wraps_at = now + self.period;
                }
            }
            SYST_RVR => self.reload = word & 0xFF_FFFF,
            SYST_CVR => self.wraps_at = now + self.period,
            VTOR => self.vectors = word,
            AIRCR => self.reset_asked |= word & 0xFFFF_0007 == RESET_REQUEST,
            CPACR => self.cpacr = word,
            DEMCR => self.demcr = word,
            0xD10..=0xD24 | 0xF34 => {}
            _ => return false,
        }
        true
    }
}
