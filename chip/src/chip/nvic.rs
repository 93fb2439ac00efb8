//! Exceptions: which are enabled, pending and active, and which may come next (ARMv7-M, B1.5 and B3.4).

/// Interrupts of the STM32F405 that are modelled (RM0090 rev 19, table 62).
pub const PVD: usize = 1;
pub const EXTI0: usize = 6;
pub const EXTI1: usize = 7;
pub const TIM2: usize = 28;
pub const USART1: usize = 37;
pub const USART2: usize = 38;

/// The exception of a hard fault, and that of interrupt 0.
pub const HARD_FAULT: u32 = 3;
const FIRST_INTERRUPT: u32 = 16;
/// Interrupts of the STM32F405.
const INTERRUPTS: usize = 82;
/// A chip of this family has the upper four bits of a priority.
const PRIORITY_SHIFT: u8 = 4;
/// Lower than any.
const THREAD: i32 = 256;

/// What masks exceptions.
#[derive(Debug, Clone, Copy, Default)]
pub struct Masks {
    pub primask: bool,
    pub basepri: u8,
}

pub struct Nvic {
    enabled: [bool; INTERRUPTS],
    pending: [bool; INTERRUPTS],
    priority: [u8; INTERRUPTS],
    /// The exceptions that were taken and have not returned, the last one running.
    active: Vec<u32>,
    hard_fault: bool,
}

impl Nvic {
    pub const fn new() -> Self {
        Self {
            enabled: [false; INTERRUPTS],
            pending: [false; INTERRUPTS],
            priority: [0; INTERRUPTS],
            active: Vec::new(),
            hard_fault: false,
        }
    }

    pub fn reset(&mut self) {
        *self = Self::new();
    }

    /// Registers from 0xE000E100 on.
    pub fn read(&self, offset: u32) -> u32 {
        match offset {
            0x000..0x080 => bits(&self.enabled, offset),
            0x080..0x100 => bits(&self.enabled, offset - 0x080),
            0x100..0x180 => bits(&self.pending, offset - 0x100),
            0x180..0x200 => bits(&self.pending, offset - 0x180),
            0x300.. => {
                let first = (offset - 0x300) as usize;
                let byte = |place: usize| u32::from(self.priority.get(first + place).copied().unwrap_or(0));
                (0..4).fold(0, |word, place| word | byte(place) << (8 * place))
            }
            _ => 0,
        }
    }

    /// A write of `size` bytes from 0xE000E100 on.
    pub fn write(&mut self, offset: u32, size: usize, word: u32) {
        match offset {
            0x000..0x080 => set(&mut self.enabled, offset, word, true),
            0x080..0x100 => set(&mut self.enabled, offset - 0x080, word, false),
            0x100..0x180 => set(&mut self.pending, offset - 0x100, word, true),
            0x180..0x200 => set(&mut self.pending, offset - 0x180, word, false),
            0x300..0x3F0 => {
                for (place, byte) in word.to_le_bytes().into_iter().take(size).enumerate() {
                    if let Some(priority) = self.priority.get_mut((offset - 0x300) as usize + place) {
                        *priority = byte & 0xF0;
                    }
                }
            }
            _ => {}
        }
    }

    /// A peripheral asks for its interrupt: it is pending, unless it runs already.
    pub fn asked(&mut self, interrupt: usize) {
        if !self.active.iter().any(|&exception| exception as usize == interrupt + FIRST_INTERRUPT as usize) {
            self.pending[interrupt] = true;
        }
    }

    /// A fault that no handler of its own takes.
    pub const fn fault(&mut self) {
        self.hard_fault = true;
    }

    fn priority_of(&self, exception: u32) -> i32 {
        match exception {
            HARD_FAULT => -1,
            _ => i32::from(self.priority[(exception - FIRST_INTERRUPT) as usize] >> PRIORITY_SHIFT),
        }
    }

    fn running(&self, masks: Masks) -> i32 {
        let active = self.active.iter().map(|&exception| self.priority_of(exception)).min().unwrap_or(THREAD);
        let base = if masks.basepri == 0 { THREAD } else { i32::from(masks.basepri >> PRIORITY_SHIFT) };
        let prime = if masks.primask { 0 } else { THREAD };
        active.min(base).min(prime)
    }

    /// The pending exception of the highest priority, of equals the one of the lowest number.
    fn first_pending(&self) -> Option<(i32, u32)> {
        if self.hard_fault {
            return Some((-1, HARD_FAULT));
        }
        let waits = (0..INTERRUPTS).filter(|&interrupt| self.pending[interrupt] && self.enabled[interrupt]);
        let exceptions = waits.filter_map(|interrupt| u32::try_from(interrupt).ok()).map(|n| n + FIRST_INTERRUPT);
        exceptions.map(|exception| (self.priority_of(exception), exception)).min()
    }

    /// Whether anything waits at all.
    pub fn waits(&self) -> bool {
        self.first_pending().is_some()
    }

    /// The exception that may come now.
    pub fn next(&self, masks: Masks) -> Option<u32> {
        self.first_pending().filter(|&(priority, _)| priority < self.running(masks)).map(|(_, exception)| exception)
    }

    /// It is taken.
    pub fn enter(&mut self, exception: u32) {
        if exception == HARD_FAULT {
            self.hard_fault = false;
        } else {
            self.pending[(exception - FIRST_INTERRUPT) as usize] = false;
        }
        self.active.push(exception);
    }

    /// The last one taken returns.
    pub fn leave(&mut self) {
        self.active.pop();
    }

    /// The exception that runs; 0 for none.
    pub fn current(&self) -> u32 {
        self.active.last().copied().unwrap_or(0)
    }
}

fn bits(flags: &[bool], offset: u32) -> u32 {
    let flag = |place: u32| flags.get((offset * 8 + place) as usize).copied().unwrap_or(false);
    (0..32).fold(0, |word, place| word | u32::from(flag(place)) << place)
}

fn set(flags: &mut [bool], offset: u32, word: u32, to: bool) {
    for place in (0..32).filter(|place| word >> place & 1 == 1) {
        if let Some(flag) = flags.get_mut((offset * 8 + place) as usize) {
            *flag = to;
        }
    }
}
