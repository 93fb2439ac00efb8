//! Where a program stopped itself: what a person looks up in the source, or in the program's file.

use heapless::String;
use serde::{Deserialize, Serialize};

/// Bytes of a source file's name that are kept: its end tells more than its beginning. As many as a serial has, so that a
/// board needs the code for one length alone.
pub const FILE_BYTES: usize = 32;

/// How a program stopped itself, and where.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stop {
    /// A panic, at a place in its source.
    Panic {
        /// The source file; of a long name its end.
        file: String<FILE_BYTES>,
        /// The line in it.
        line: u32,
    },
    /// A fault of the processor.
    Fault(FaultRegisters),
}

impl Stop {
    /// A panic at a place in its source.
    #[must_use]
    pub fn panic_at(file: &str, line: u32) -> Self {
        let end = file.get(file.len().saturating_sub(FILE_BYTES)..).unwrap_or_default();
        Self::Panic { file: String::try_from(end).unwrap_or_default(), line }
    }
}

/// What a Cortex-M4 says of a fault (ARMv7-M, B1.5.6 and B3.2.15 to B3.2.18).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct FaultRegisters {
    /// The instruction that could not be done; at an imprecise bus fault, one after it.
    pub pc: u32,
    /// Where the function that it stands in returns to, unless it has called another since.
    pub lr: u32,
    /// The kinds of fault.
    pub cfsr: u32,
    /// Why it became a hard one.
    pub hfsr: u32,
    /// The address that memory management refused, where CFSR says that it holds.
    pub mmfar: u32,
    /// The address that the bus refused, where CFSR says that it holds.
    pub bfar: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_long_name_the_end_is_kept() {
        let place = |file: &str| match Stop::panic_at(file, 7) {
            Stop::Panic { file, line: 7 } => std::string::String::from(file.as_str()),
            other => panic!("{other:?}"),
        };
        assert_eq!(place("src/main.rs"), "src/main.rs");
        assert_eq!(place(&"0123456789".repeat(5)), "89012345678901234567890123456789");
        assert_eq!(place(&std::format!("{}x", "ü".repeat(30))), "", "cut within a letter");
    }
}
