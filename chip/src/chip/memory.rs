//! What is where (RM0090 rev 19, 2.3), and the image.

use anyhow::{Context, Result, ensure};
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Object, ObjectSymbol};

use super::flash::{RECORD_BYTES, RECORDS, SECTOR};

/// The flash: the vectors, then the records (`flash`), then the program.
pub const FLASH: u32 = 0x0800_0000;
pub const FLASH_BYTES: usize = 1024 * FLASH_KIB as usize;
/// SRAM 1 and 2.
pub const RAM: u32 = 0x2000_0000;
pub const RAM_BYTES: usize = 128 * 1024;
/// The core-coupled memory.
pub const COUPLED: u32 = 0x1000_0000;
pub const COUPLED_BYTES: usize = 64 * 1024;
/// Sector 3, where the unit's serial is (firmware/README.md).
const UNIT: u32 = 0x0800_C000;
/// The page of the chip's signature: the flash's size is a halfword in it.
pub const SIGNATURE: u32 = 0x1FFF_7000;
pub const FLASH_SIZE: u32 = 0x1FFF_7A22;
pub const FLASH_KIB: u16 = 1024;
/// Peripherals, their bits' alias, the core's trace unit, and its own registers.
pub const PERIPHERALS: u32 = 0x4000_0000;
pub const PERIPHERAL_BYTES: u32 = 0x0008_0000;
pub const BITS: u32 = 0x4200_0000;
pub const BITS_BYTES: u32 = 32 * PERIPHERAL_BYTES;
pub const TRACE: u32 = 0xE000_1000;
pub const CORE: u32 = 0xE000_E000;
/// Where a return from an exception branches to.
pub const RETURN_PAGE: u32 = 0xFFFF_F000;

/// A place in the program that panics: an index out of bounds, told by the `Location` that its code loads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PanicSite {
    /// Its code: MOVW R2 and MOVT R2 with the location's address, and the call.
    pub code: u32,
    pub file: String,
    pub line: u32,
}

/// The program as it is flashed.
#[derive(Clone)]
pub struct Image {
    /// All of the flash, nothing where the records are.
    pub flash: Vec<u8>,
    /// A place in the program that panics.
    pub panic: PanicSite,
    /// An instruction of the program that loads R0 from where R0 says.
    pub load: u32,
    /// A function that is called while a set is worked on.
    pub within_set: u32,
    /// Where the lines for a probe lie in memory.
    pub probe: u32,
}

impl Image {
    /// The image in an ELF: its segments at their physical addresses.
    ///
    /// # Errors
    /// When it is none for this chip.
    pub fn of_elf(bytes: &[u8]) -> Result<Self> {
        let elf: ElfFile32 = ElfFile32::parse(bytes).context("no ELF of 32 bits")?;
        let endian = elf.endian();
        let mut flash = vec![0xFF; FLASH_BYTES];
        for segment in elf.elf_program_headers() {
            let data = segment.data(endian, bytes).ok().context("a segment that is not in the file")?;
            if data.is_empty() || segment.p_type(endian) != object::elf::PT_LOAD {
                continue;
            }
            let at = segment.p_paddr(endian).wrapping_sub(FLASH) as usize;
            let records = (RECORDS - FLASH) as usize..(RECORDS - FLASH) as usize + RECORD_BYTES;
            ensure!(at + data.len() <= records.start || at >= records.end, "a segment where the records are");
            let place = flash.get_mut(at..at + data.len()).context("a segment outside the flash")?;
            place.copy_from_slice(data);
        }
        let is_check = |name: &str| name.ends_with("panic_bounds_check");
        let symbol = |is_it: &dyn Fn(&str) -> bool| -> Option<u32> {
            let symbol = elf.symbols().find(|symbol| symbol.name().is_ok_and(is_it))?;
            u32::try_from(symbol.address() & !1).ok()
        };
        let check = symbol(&is_check).context("no index checked in it")?;
        let panic = panic_site(&flash, check).context("no index checked that is known")?;
        let within_set = symbol(&|name| name.contains(WITHIN_SET)).context("no temperature looked at in it")?;
        let probe = symbol(&|name| name == "_SEGGER_RTT").context("no lines for a probe in it")?;
        ensure!(flash[..4] != [0xFF; 4], "no vectors in it");
        let begin = (RECORDS - FLASH) as usize + RECORD_BYTES;
        let load = (begin..FLASH_BYTES).step_by(2).find(|&at| halfword(&flash, at) == Some(LDR_R0_R0));
        let load = FLASH + u32::try_from(load.context("no load by R0 in it")?)?;
        Ok(Self { flash, panic, load, within_set, probe })
    }

    /// The same, with what stands where a unit's serial does.
    #[must_use]
    pub fn with_serial(mut self, bytes: &[u8]) -> Self {
        let at = (UNIT - FLASH) as usize;
        self.flash[at..at + SECTOR].fill(0xFF);
        self.flash[at..at + bytes.len()].copy_from_slice(bytes);
        self
    }
}

/// In the mangled name of what looks at a set's temperature.
const WITHIN_SET: &str = "TemperatureWatch4look";

const LDR_R0_R0: u16 = 0x6800;

fn halfword(flash: &[u8], at: usize) -> Option<u16> {
    flash.get(at..at + 2).map(|bytes| u16::from_le_bytes([bytes[0], bytes[1]]))
}

fn word(flash: &[u8], address: u32) -> Option<u32> {
    let bytes = flash.get(address.checked_sub(FLASH)? as usize..)?.first_chunk()?;
    Some(u32::from_le_bytes(*bytes))
}

/// The first code that gives a location to the check of an index, and calls it.
fn panic_site(flash: &[u8], check: u32) -> Option<PanicSite> {
    (FLASH..FLASH + u32::try_from(flash.len()).ok()?).step_by(2).find_map(|code| {
        let at = (code - FLASH) as usize;
        let [a, b, c, d, e, f] = [0, 2, 4, 6, 8, 10].map(|offset| halfword(flash, at + offset));
        let location = immediate(a?, b?, 0xF240)? | immediate(c?, d?, 0xF2C0)? << 16;
        if call(code + 8, e?, f?)? != check {
            return None;
        }
        let [name, length, line] = [0, 4, 8].map(|offset| word(flash, location + offset));
        let name = flash.get(name?.checked_sub(FLASH)? as usize..)?.get(..length? as usize)?;
        Some(PanicSite { code, file: String::from_utf8(name.to_vec()).ok()?, line: line? })
    })
}

/// The immediate of a MOVW or MOVT to R2 (ARMv7-M, A7.7.76, T3, and A7.7.79).
fn immediate(high: u16, low: u16, kind: u16) -> Option<u32> {
    let is_it = high & 0xFBF0 == kind && low & 0x8F00 == 0x0200;
    let (high, low) = (u32::from(high), u32::from(low));
    is_it.then_some((high & 0xF) << 12 | (high >> 10 & 1) << 11 | (low >> 12 & 7) << 8 | low & 0xFF)
}

/// Where a BL branches to (ARMv7-M, A7.7.18), near enough for a program of less than 4 MiB.
fn call(at: u32, high: u16, low: u16) -> Option<u32> {
    let is_it = high & 0xF800 == 0xF000 && low & 0xF800 == 0xF800;
    let (high, low) = (u32::from(high), u32::from(low));
    let offset = (high & 0x3FF) << 12 | (low & 0x7FF) << 1;
    let offset = if high & 0x400 == 0 { offset } else { offset | 0xFFC0_0000 };
    is_it.then_some((at + 4).wrapping_add(offset))
}
