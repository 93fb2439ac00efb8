//! The chip: its parts, and which of them an address means. The core is Unicorn's (`machine`).

pub mod board;
mod exti;
pub mod flash;
pub mod float;
mod gpio;
pub mod memory;
pub mod nvic;
mod power;
pub mod rcc;
mod spi;
pub mod system;
pub mod time;
mod timer;
mod usart;
mod watchdog;

use self::board::{Board, Bus};
use self::exti::Exti;
use self::flash::Flash;
use self::gpio::Gpio;
use self::nvic::Nvic;
use self::power::Power;
use self::rcc::{Rcc, Reset};
use self::spi::Spi;
use self::system::System;
use self::time::{NEVER, Ticks};
use self::timer::Timer;
use self::usart::Usart;
use self::watchdog::IndependentWatchdog;

/// The pins of the two chip selects (firmware/README.md).
const PORT_SELECT: u32 = 4;
const POTENTIOMETER_SELECT: u32 = 12;
/// Pins of port B: data ready, scan ready, and the second line with its alternate function (data sheet, table 9).
const DATA_READY: u32 = 0;
const SCAN_READY: u32 = 1;
const SCAN_LINE: u32 = 6;
const OF_USART1: u32 = 7;

/// Everything about the core.
pub struct Chip {
    /// Virtual time.
    pub clock: Ticks,
    /// When the core is to be looked after; it runs undisturbed until then.
    pub alarm: Ticks,
    /// What an instruction takes.
    pub instruction: Ticks,
    pub rcc: Rcc,
    power: Power,
    gpio_a: Gpio,
    gpio_b: Gpio,
    exti: Exti,
    spi: [Spi; 2],
    selected: [bool; 2],
    /// The host's line.
    pub usart: Usart,
    /// The second line.
    pub scan_line: Usart,
    pub timer: Timer,
    pub flash: Flash,
    pub watchdog: IndependentWatchdog,
    pub nvic: Nvic,
    pub system: System,
    pub board: Board,
    /// What the program did that the chip would not have taken, or that is not modelled.
    pub wrong: Vec<String>,
}

impl Chip {
    pub fn new(board: Board) -> Self {
        Self {
            clock: 0,
            alarm: 0,
            instruction: 1,
            rcc: Rcc::new(),
            power: Power::new(),
            gpio_a: Gpio::default(),
            gpio_b: Gpio::default(),
            exti: Exti::default(),
            spi: Default::default(),
            selected: [false; 2],
            usart: Usart::at(usart::HOST_BAUD),
            scan_line: Usart::at(usart::SCAN_BAUD),
            timer: Timer::new(),
            flash: Flash::new(),
            watchdog: IndependentWatchdog::new(),
            nvic: Nvic::new(),
            system: System::default(),
            board,
            wrong: Vec::new(),
        }
    }

    /// Everything but memory as after a reset.
    pub fn reset(&mut self, reset: Reset) {
        self.rcc.reset(reset);
        self.power.reset();
        self.gpio_a.reset();
        self.gpio_b.reset();
        self.move_selects();
        self.exti.reset();
        self.spi.iter_mut().for_each(Spi::reset);
        self.usart.reset();
        self.scan_line.reset();
        self.timer.reset();
        self.flash.reset();
        self.watchdog.reset();
        self.nvic.reset();
        self.system.reset();
        self.instruction = self.rcc.core_ticks();
    }

    /// What has happened up to now happens; interrupts that are asked for are pending. The reset that it ends in, if any.
    pub fn settle(&mut self) -> Option<Reset> {
        self.shift(0);
        self.shift(1);
        self.usart.advance(self.clock);
        self.scan_line.advance(self.clock);
        if !self.board.plant_stands {
            self.timer.advance(self.clock);
        }
        self.pass(self.clock);
        let asks = [
            (nvic::PVD, self.exti.asks(exti::PVD)),
            (nvic::EXTI0, self.exti.asks(0)),
            (nvic::EXTI1, self.exti.asks(1)),
            (nvic::TIM2, self.timer.asks()),
            (nvic::USART1, self.scan_line.asks()),
            (nvic::USART2, self.usart.asks()),
        ];
        asks.into_iter().filter(|&(_, asks)| asks).for_each(|(interrupt, _)| self.nvic.asked(interrupt));
        if self.watchdog.due() <= self.clock {
            return Some(Reset::Watchdog);
        }
        std::mem::take(&mut self.system.reset_asked).then_some(Reset::Software)
    }

    /// The supply goes to so many volts; the reset that it is.
    pub fn supply(&mut self, volts: f64) -> Option<Reset> {
        let (rises, reset) = self.power.supply(volts, self.flash.brown_out_level());
        if rises {
            self.exti.edge_of_pvd();
        }
        reset
    }

    /// When something happens by itself next.
    pub fn due(&self) -> Ticks {
        let lines = self.usart.due().min(self.scan_line.due());
        // Where the plant's time stands seconds are given, too.
        let tick = if self.board.plant_stands { NEVER } else { self.timer.due() };
        [lines, tick, self.board.due(), self.watchdog.due()].into_iter().min().unwrap_or(NEVER)
    }

    fn pass(&mut self, to: Ticks) {
        let data_ready = self.board.pass(to);
        if self.board.scan_came() {
            // It fell as the scan began.
            self.gpio_b.driven |= 1 << SCAN_READY;
            [false, true].into_iter().for_each(|rises| self.exti.edge_of_port_b(SCAN_READY, rises));
        }
        if let Some(rises) = data_ready {
            self.gpio_b.driven = self.gpio_b.driven & !(1 << DATA_READY) | u32::from(rises) << DATA_READY;
            self.exti.edge_of_port_b(DATA_READY, rises);
        }
    }

    /// Bytes whose last clock has come reach the part.
    fn shift(&mut self, index: usize) {
        let bus = [Bus::Port, Bus::Potentiometer][index];
        while let Some((at, byte)) = self.spi[index].finished(self.clock) {
            self.pass(at);
            let answer = self.board.exchange(bus, byte);
            // Nobody drives the potentiometer's line back.
            self.spi[index].take(answer);
        }
    }

    /// The chip selects as the pins have them now.
    fn move_selects(&mut self) {
        let low = [self.gpio_a.pulls_low(PORT_SELECT), self.gpio_b.pulls_low(POTENTIOMETER_SELECT)];
        for (index, bus) in [Bus::Port, Bus::Potentiometer].into_iter().enumerate() {
            if low[index] == self.selected[index] {
                continue;
            }
            self.selected[index] = low[index];
            self.shift(index);
            self.pass(self.clock);
            if low[index] {
                self.board.select(bus);
            } else {
                if self.spi[index].is_shifting() {
                    self.wrong.push(format!("{bus:?}: chip select rose within a byte"));
                }
                self.board.deselect(bus, self.clock);
            }
            // A set may have been released.
            self.pass(self.clock);
        }
    }

    /// A word of a peripheral's register, by the peripheral's address.
    pub fn load(&mut self, address: u32) -> u32 {
        let (base, offset) = (address & !0x3FF, address & 0x3FC);
        if !self.rcc.clocks(address) {
            self.wrong.push(format!("{address:#010x} read, its clock off"));
            return 0;
        }
        let plain = |word| (word, None);
        let now = self.clock;
        let (word, waits) = match base {
            0x4000_0000 => plain(self.timer.read(offset)),
            0x4000_3000 => plain(self.watchdog.read(offset)),
            0x4000_3800 => {
                self.shift(1);
                self.spi[1].read(offset)
            }
            0x4000_4400 => {
                self.usart.advance(now);
                self.usart.read(offset)
            }
            0x4001_1000 => {
                self.scan_line.advance(now);
                self.scan_line.read(offset)
            }
            0x4001_3000 => {
                self.shift(0);
                self.spi[0].read(offset)
            }
            0x4001_3800 => plain(self.exti.read_syscfg(offset)),
            0x4001_3C00 => plain(self.exti.read(offset)),
            0x4002_0000 => plain(self.gpio_a.read(offset)),
            0x4002_0400 => plain(self.gpio_b.read(offset)),
            0x4002_3800 => self.rcc.read(offset, now),
            0x4002_3C00 => plain(self.flash.read(offset)),
            0x4000_7000 => plain(self.power.read(offset)),
            // Port H (the crystal's pins): taken, and without effect.
            0x4002_1C00 => plain(0),
            _ => {
                self.wrong.push(format!("{address:#010x} read, which is not modelled"));
                plain(0)
            }
        };
        self.wait(waits);
        word
    }

    /// A write of a word, or of a part of one in its lower bits, to a peripheral's register.
    pub fn store(&mut self, address: u32, word: u32) {
        let (base, offset) = (address & !0x3FF, address & 0x3FC);
        if !self.rcc.clocks(address) {
            self.wrong.push(format!("{address:#010x} written, its clock off"));
            return;
        }
        let now = self.clock;
        let done = match base {
            0x4000_0000 => {
                self.timer.write(offset, word, now, self.rcc.timer_ticks());
                Ok(())
            }
            0x4000_3000 => {
                self.watchdog.write(offset, word, now);
                Ok(())
            }
            0x4000_3800 => {
                self.shift(1);
                self.spi[1].write(offset, word, now, self.rcc.bus_1_ticks())
            }
            0x4000_4400 => {
                self.usart.advance(now);
                self.usart.write(offset, word, now, self.rcc.bus_1_ticks())
            }
            0x4001_1000 => {
                self.scan_line.advance(now);
                if self.scan_line.sends(offset) && !self.gpio_b.is_of(SCAN_LINE, OF_USART1) {
                    self.wrong.push("a byte for the second line, whose pin is not USART1's".into());
                }
                self.scan_line.write(offset, word, now, self.rcc.bus_2_ticks())
            }
            0x4001_3000 => {
                self.shift(0);
                self.spi[0].write(offset, word, now, self.rcc.bus_2_ticks())
            }
            0x4001_3800 => {
                self.exti.write_syscfg(offset, word);
                Ok(())
            }
            0x4001_3C00 => {
                self.exti.write(offset, word);
                Ok(())
            }
            0x4002_0000 | 0x4002_0400 => {
                let gpio = if base == 0x4002_0000 { &mut self.gpio_a } else { &mut self.gpio_b };
                gpio.write(offset, word);
                self.move_selects();
                Ok(())
            }
            0x4002_3800 => {
                self.rcc.write(offset, word, now);
                self.instruction = self.rcc.core_ticks();
                Ok(())
            }
            0x4002_3C00 => {
                self.clock += self.flash.write(offset, word);
                Ok(())
            }
            0x4000_7000 => {
                if self.power.write(offset, word) {
                    self.exti.edge_of_pvd();
                }
                Ok(())
            }
            0x4002_1C00 => Ok(()),
            _ => Err("written, which is not modelled"),
        };
        if let Err(what) = done {
            self.wrong.push(format!("{address:#010x}: {what}"));
        }
        // What was written may raise an interrupt or move an alarm; buses and pins do neither.
        if !matches!(base, 0x4001_3000 | 0x4000_3800 | 0x4002_0000) {
            self.alarm = 0;
        }
    }

    /// A word of the core's own registers, from 0xE000E000 on.
    pub fn load_core(&mut self, offset: u32) -> u32 {
        if (0x100..0x500).contains(&offset) {
            return self.nvic.read(offset - 0x100);
        }
        let Some((word, waits)) = self.system.read(offset, self.clock, self.nvic.current()) else {
            self.wrong.push(format!("{offset:#05x} of the core read, which is not modelled"));
            return 0;
        };
        self.wait(waits);
        // A delay is of whole microseconds; the program sets its counter to a cycle of it more or less.
        let delayed = (self.system.take_delayed() + time::MICROSECOND / 2) / time::MICROSECOND;
        self.board.took_ns(1000 * delayed);
        word
    }

    /// A word of the core's trace unit.
    pub fn load_trace(&mut self, offset: u32) -> u32 {
        let word = self.system.trace(offset, self.clock, self.rcc.core_ticks());
        if word.is_none() {
            self.wrong.push(format!("{offset:#05x} of the trace unit read, which is not modelled"));
        }
        word.unwrap_or(0)
    }

    /// A write to the core's trace unit.
    pub fn store_trace(&mut self, offset: u32, word: u32) {
        if !self.system.write_trace(offset, word) {
            self.wrong.push(format!("{offset:#05x} of the trace unit written, which is not modelled"));
        }
    }

    /// A write of `size` bytes to the core's own registers.
    pub fn store_core(&mut self, offset: u32, size: usize, word: u32) {
        self.alarm = 0;
        if (0x100..0x500).contains(&offset) {
            self.nvic.write(offset - 0x100, size, word);
        } else if !self.system.write(offset, word, self.clock, self.rcc.core_ticks()) {
            self.wrong.push(format!("{offset:#05x} of the core written, which is not modelled"));
        }
    }

    /// The program asks a flag again and again: time goes to where it changes, or to the next alarm.
    fn wait(&mut self, until: Option<Ticks>) {
        if let Some(until) = until {
            self.clock = self.clock.max(until.min(self.alarm));
        }
    }
}
