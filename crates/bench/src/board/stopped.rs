//! Where a board's program stopped itself, in words for people, and how the place is looked up.

use std::fmt;

use serde::Serialize;
use zerorate_core::wire::{FaultRegisters, Stop};

/// Where a board's program stopped itself last since its power came.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Stopped {
    /// A panic.
    Panic {
        /// The source file, of a long name its end.
        file: String,
        /// The line in it.
        line: u32,
    },
    /// A fault of the processor.
    Fault {
        /// What was wrong.
        what: Vec<&'static str>,
        /// The instruction that could not be done, in hexadecimal as all that follows.
        pc: String,
        /// Where its function returns to, unless it has called another since.
        lr: String,
        /// The address that it could not reach, where that is known.
        address: Option<String>,
        /// The processor's two fault registers.
        cfsr: String,
        /// See `cfsr`.
        hfsr: String,
    },
}

/// Bits of CFSR and what they say (ARMv7-M, B3.2.15).
const KINDS: [(u32, &str); 14] = [
    (1 << 0, "an instruction fetched where none may be"),
    (1 << 1, "data where none may be"),
    (1 << 3, "memory refused as an interrupt returned"),
    (1 << 4, "memory refused as an interrupt began"),
    (1 << 8, "an instruction fetched where nothing answers"),
    (1 << 9, "data read or written where nothing answers"),
    (1 << 10, "data written a few instructions before where nothing answers"),
    (1 << 11, "nothing answered as an interrupt returned"),
    (1 << 12, "nothing answered as an interrupt began"),
    (1 << 16, "an instruction that is none"),
    (1 << 17, "a jump to where is no code for this processor"),
    (1 << 18, "a return from an interrupt that was none"),
    (1 << 24, "an address that is not aligned"),
    (1 << 25, "a division by zero"),
];
/// CFSR: MMFAR holds the address, BFAR does.
const MMFAR_HOLDS: u32 = 1 << 7;
const BFAR_HOLDS: u32 = 1 << 15;

impl From<Stop> for Stopped {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Panic { file, line } => Self::Panic { file: file.to_string(), line },
            Stop::Fault(FaultRegisters { pc, lr, cfsr, hfsr, mmfar, bfar }) => {
                let what = KINDS.iter().filter(|(bit, _)| cfsr & bit != 0).map(|&(_, what)| what).collect();
                let address = [(MMFAR_HOLDS, mmfar), (BFAR_HOLDS, bfar)];
                let address = address.into_iter().find(|(bit, _)| cfsr & bit != 0).map(|(_, address)| hex(address));
                Self::Fault { what, pc: hex(pc), lr: hex(lr), address, cfsr: hex(cfsr), hfsr: hex(hfsr) }
            }
        }
    }
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Panic { file, line } => write!(f, "a panic at {file}:{line}"),
            Self::Fault { what, pc, lr, address, cfsr, hfsr } => {
                let what = if what.is_empty() { "a fault without a kind".into() } else { what.join(", ") };
                write!(f, "{what}")?;
                if let Some(address) = address {
                    write!(f, " ({address})")?;
                }
                write!(f, "; CFSR {cfsr}, HFSR {hfsr}; the place: arm-none-eabi-addr2line -fpie FIRMWARE.elf {pc} {lr}")
            }
        }
    }
}

fn hex(word: u32) -> String {
    format!("{word:#010x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_told_by_its_place() {
        let stopped = Stopped::from(Stop::panic_at("crates/device/src/compensator.rs", 212));
        assert_eq!(stopped.to_string(), "a panic at crates/device/src/compensator.rs:212");
    }

    #[test]
    fn a_fault_is_told_by_its_kind_and_by_how_its_place_is_looked_up() {
        let registers = FaultRegisters {
            pc: 0x0800_C123,
            lr: 0x0800_D001,
            cfsr: 1 << 9 | BFAR_HOLDS,
            hfsr: 1 << 30,
            mmfar: 7,
            bfar: 0xBAD0_0000,
        };
        assert_eq!(
            Stopped::from(Stop::Fault(registers)).to_string(),
            "data read or written where nothing answers (0xbad00000); CFSR 0x00008200, HFSR 0x40000000; \
             the place: arm-none-eabi-addr2line -fpie FIRMWARE.elf 0x0800c123 0x0800d001"
        );
        let division = Stopped::from(Stop::Fault(FaultRegisters { cfsr: 1 << 25, ..registers }));
        assert!(division.to_string().starts_with("a division by zero; CFSR"), "no address is known: {division}");
        let none = Stopped::from(Stop::Fault(FaultRegisters::default()));
        assert!(none.to_string().starts_with("a fault without a kind;"), "{none}");
    }
}
