//! What is where (RM0090 rev 19, 2.3), and the image.

use anyhow::{Context, Result, ensure};
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Object, ObjectSymbol};

/// The program's flash: what linker file memory.x gives it.
pub const FLASH: u32 = 0x0800_0000;
pub const PROGRAM_BYTES: usize = 768 * 1024;
/// SRAM 1 and 2.
pub const RAM: u32 = 0x2000_0000;
pub const RAM_BYTES: usize = 128 * 1024;
/// The page of the chip's signature: the flash's size is a halfword in it.
pub const SIGNATURE: u32 = 0x1FFF_7000;
pub const FLASH_SIZE: u32 = 0x1FFF_7A22;
pub const FLASH_KIB: u16 = 1024;
/// Peripherals, their bits' alias, and the core's own registers.
pub const PERIPHERALS: u32 = 0x4000_0000;
pub const PERIPHERAL_BYTES: u32 = 0x0008_0000;
pub const BITS: u32 = 0x4200_0000;
pub const BITS_BYTES: u32 = 32 * PERIPHERAL_BYTES;
pub const CORE: u32 = 0xE000_E000;
/// Where a return from an exception branches to.
pub const RETURN_PAGE: u32 = 0xFFFF_F000;

/// The program as it is flashed.
#[derive(Clone)]
pub struct Image {
    /// The program's flash.
    pub flash: Vec<u8>,
    /// Where the panic handler is.
    pub panic: u32,
}

impl Image {
    /// The image in an ELF: its segments at their physical addresses.
    ///
    /// # Errors
    /// When it is none for this chip.
    pub fn of_elf(bytes: &[u8]) -> Result<Self> {
        let elf: ElfFile32 = ElfFile32::parse(bytes).context("no ELF of 32 bits")?;
        let endian = elf.endian();
        let mut flash = vec![0xFF; PROGRAM_BYTES];
        for segment in elf.elf_program_headers() {
            let data = segment.data(endian, bytes).ok().context("a segment that is not in the file")?;
            if data.is_empty() || segment.p_type(endian) != object::elf::PT_LOAD {
                continue;
            }
            let at = segment.p_paddr(endian).wrapping_sub(FLASH) as usize;
            let place = flash.get_mut(at..at + data.len()).context("a segment outside the program's flash")?;
            place.copy_from_slice(data);
        }
        let is_panic = |name: &str| name.ends_with("rust_begin_unwind");
        let panic = elf.symbols().find(|symbol| symbol.name().is_ok_and(is_panic)).context("no panic handler in it")?;
        let panic = u32::try_from(panic.address())? & !1;
        ensure!(flash[..4] != [0xFF; 4], "no vectors in it");
        Ok(Self { flash, panic })
    }
}
