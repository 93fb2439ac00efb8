//! Edges of pins as interrupts (RM0090 rev 19, chapters 9 and 12): SYSCFG's choice of port, EXTI's masks and pending bits.

const IMR: u32 = 0x00;
const RTSR: u32 = 0x08;
const FTSR: u32 = 0x0C;
const SWIER: u32 = 0x10;
const PR: u32 = 0x14;
/// SYSCFG_EXTICR1.
const EXTICR1: u32 = 0x08;
/// The PVD's line.
pub const PVD: u32 = 16;
/// Port B in EXTICR's nibbles.
const PORT_B: u32 = 1;

#[derive(Default)]
pub struct Exti {
    words: [u32; 6],
    syscfg: [u32; 9],
}

impl Exti {
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    pub fn read(&self, offset: u32) -> u32 {
        self.words.get(offset as usize / 4).copied().unwrap_or(0)
    }

    pub fn write(&mut self, offset: u32, word: u32) {
        match offset {
            PR => self.words[PR as usize / 4] &= !word,
            SWIER => self.words[PR as usize / 4] |= word,
            _ => {
                if let Some(place) = self.words.get_mut(offset as usize / 4) {
                    *place = word;
                }
            }
        }
    }

    pub fn read_syscfg(&self, offset: u32) -> u32 {
        self.syscfg.get(offset as usize / 4).copied().unwrap_or(0)
    }

    pub fn write_syscfg(&mut self, offset: u32, word: u32) {
        if let Some(place) = self.syscfg.get_mut(offset as usize / 4) {
            *place = word;
        }
    }

    /// A pin of port B, one of the first four, has changed its level.
    pub fn edge_of_port_b(&mut self, pin: u32, rises: bool) {
        let chosen = self.syscfg[EXTICR1 as usize / 4] >> (4 * pin) & 0xF == PORT_B;
        let register = if rises { RTSR } else { FTSR };
        if chosen {
            self.words[PR as usize / 4] |= self.read(register) & 1 << pin;
        }
    }

    /// The PVD's output has risen, which is line 16.
    pub fn edge_of_pvd(&mut self) {
        self.words[PR as usize / 4] |= self.read(RTSR) & 1 << PVD;
    }

    /// Whether a line asks for its interrupt.
    pub fn asks(&self, line: u32) -> bool {
        self.read(PR) & self.read(IMR) & 1 << line != 0
    }
}
