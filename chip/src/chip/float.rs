//! The float unit as the image uses it: registers that are loaded and stored, two words at a time.
//!
//! Unicorn has no way to switch on its own in a Cortex-M4 (CPACR is a register of a device that it leaves out). So its
//! instructions are done here; the image moves bytes with them and calculates nothing.

/// A load or store of float registers, decoded (ARMv7-M, A6.6 and A7.7: VLDR, VSTR, VLDM, VSTM, VPUSH, VPOP).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transfer {
    /// The core's register with the address.
    pub base: u32,
    /// The first single register, and how many.
    pub first: usize,
    pub count: usize,
    pub load: bool,
    /// From the base register to the first word, and what is added to the base register.
    pub offset: i32,
    pub write_back: i32,
}

/// Whether a halfword begins an instruction of coprocessors.
pub const fn may_be(high: u16, low: u16) -> bool {
    high & 0xEC00 == 0xEC00 && low & 0x0E00 == 0x0A00
}

/// Decodes an instruction; `None` where it is none of these.
pub fn decode(high: u16, low: u16) -> Option<Transfer> {
    if high & 0xFE00 != 0xEC00 || low & 0x0E00 != 0x0A00 {
        return None;
    }
    let bit = |place: u16| high >> place & 1 == 1;
    let (before, up, wide, write, load) = (bit(8), bit(7), bit(6), bit(5), bit(4));
    let double = low >> 8 & 1 == 1;
    let (base, field) = (u32::from(high & 0xF), usize::from(low >> 12));
    let first = if double { 2 * (field + 16 * usize::from(wide)) } else { 2 * field + usize::from(wide) };
    let words = usize::from(low & 0xFF);
    let bytes = i32::from(low & 0xFF) * 4;
    let signed = if up { bytes } else { -bytes };
    let transfer = match (before, write) {
        // VLDR and VSTR.
        (true, false) => {
            Transfer { base, first, count: if double { 2 } else { 1 }, load, offset: signed, write_back: 0 }
        }
        // Increment after, with write-back or not; decrement before.
        (false, write) if up => {
            Transfer { base, first, count: words, load, offset: 0, write_back: if write { bytes } else { 0 } }
        }
        (true, true) if !up => Transfer { base, first, count: words, load, offset: -bytes, write_back: -bytes },
        _ => return None,
    };
    (transfer.count > 0 && transfer.first + transfer.count <= 32).then_some(transfer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_image_has_is_decoded_as_objdump_prints_it() {
        // vpush {d8-d9}; vpop {d8-d9}; vldr d9, [sp, #24]; vstmia r1, {d8-d9}
        let push = Transfer { base: 13, first: 16, count: 4, load: false, offset: -16, write_back: -16 };
        assert_eq!(decode(0xED2D, 0x8B04), Some(push));
        let pop = Transfer { base: 13, first: 16, count: 4, load: true, offset: 0, write_back: 16 };
        assert_eq!(decode(0xECBD, 0x8B04), Some(pop));
        let load = Transfer { base: 13, first: 18, count: 2, load: true, offset: 24, write_back: 0 };
        assert_eq!(decode(0xED9D, 0x9B06), Some(load));
        let store = Transfer { base: 1, first: 16, count: 4, load: false, offset: 0, write_back: 0 };
        assert_eq!(decode(0xEC81, 0x8B04), Some(store));
        // vmov.f32 s0, #1.0
        assert_eq!(decode(0xEEB7, 0x0A00), None);
    }
}
