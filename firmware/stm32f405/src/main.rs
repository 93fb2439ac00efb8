//! The application on an STM32F405 at 168 MHz: the wiring is in firmware/README.md.

#![no_std]
#![no_main]

use cortex_m_rt as _;

mod flash;
mod probe;
mod scan_line;
mod supply;
mod unit;

use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
use heapless::spsc::{Consumer, Producer};
use nb::block;
use stm32f4xx_hal::gpio::{Edge, Input, Output, PA4, PB0, PB1, PB12, PinState, Speed};
use stm32f4xx_hal::pac::{self, EXTI, PWR, SPI1, SPI2, TIM2, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Enable};
use stm32f4xx_hal::serial::{self, Rx, Tx};
use stm32f4xx_hal::spi::{self, Spi};
use stm32f4xx_hal::timer::{self, CounterHz, SysDelay};
use stm32f4xx_hal::watchdog::IndependentWatchdog;
use zerorate_core::board::BoardNumbers;
use zerorate_device::acquisition::Timing;
use zerorate_device::application::{Application, Parts, Task};
use zerorate_device::compensator::{Compensator, Memory};
use zerorate_device::console::Buffer;
use zerorate_device::port::PortAcquisition;
use zerorate_device::restart::{Keeping, Kept};
use zerorate_device::store::FlashStore;
use zerorate_device::trim_part::Max5494Trim;
use zerorate_device::watchdog::Watchdog;
use zerorate_firmware::{Locked, Received, health, serve};

use crate::flash::ChipFlash;
use crate::probe::Probe;
use crate::scan_line::ScanLine;

/// The crystal, and the fastest clocks of the chip and its buses (data sheet, table 14).
const CRYSTAL_MHZ: u32 = 8;
const CORE_MHZ: u32 = 168;
const BUS_1_MHZ: u32 = 42;
const BUS_2_MHZ: u32 = 84;
/// Up to 10 MHz by docs/acquisition-port.md, up to 7 MHz by the MAX5494's sheet; both buses divide to 5.25 MHz.
const PORT_KHZ: u32 = 5250;
const POTENTIOMETER_KHZ: u32 = 5250;
/// The host's line.
const BAUD: u32 = 115_200;
/// The second line: a scan's frame of 20 bytes takes 0.43 ms there, a seventh of a scan period.
const SCAN_BAUD: u32 = 460_800;
/// How often the level of data ready is looked at, and a port that is not there yet is tried: an FPGA that is configured as late as
/// the processor starts is reached within 20 ms. So many looks are the tick that `zerorate-device` counts seconds by.
const LOOK_HZ: u32 = 50;
/// By the watchdog's own clock, which may be 47 kHz where its sheet says 32: 6.8 s then. Longer than the 5.5 s from a set to
/// the next one where the acquisition had to be set up anew.
const WATCHDOG_MS: u32 = 10_000;

type Port = PortAcquisition<ExclusiveDevice<Spi<SPI1>, PA4<Output>, NoDelay>>;
type Potentiometer = Max5494Trim<ExclusiveDevice<Spi<SPI2>, PB12<Output>, NoDelay>, SysDelay>;
type Store = FlashStore<ChipFlash>;
type AtWork = Compensator<Port, Keeping<Potentiometer, &'static Kept>, &'static mut Memory>;

/// The chip's own watchdog.
struct ChipWatchdog(IndependentWatchdog);

impl Watchdog for ChipWatchdog {
    fn feed(&mut self) {
        self.0.feed();
    }
}

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use super::*;

    #[shared]
    struct Shared {
        compensator: AtWork,
        scan_line: ScanLine,
        #[lock_free]
        data_ready_pin: PB0<Input>,
    }

    #[local]
    struct Local {
        task: Task<Store, ChipWatchdog, &'static Kept, &'static mut Buffer>,
        sending: Tx<USART2>,
        receiving: Rx<USART2>,
        received: Producer<'static, u8>,
        heard: Consumer<'static, u8>,
        scan_ready_pin: PB1<Input>,
        timer: CounterHz<TIM2>,
        exti: EXTI,
    }

    #[init(local = [bytes: Received = Received::new(), memory: Memory = Memory::new(), buffer: Buffer = Buffer::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let device = cx.device;
        // Before anything that can hang: a crystal that does not start is one.
        let mut watchdog = IndependentWatchdog::new(device.IWDG);
        watchdog.start(WATCHDOG_MS.millis());
        let started = zerorate_firmware::kept().started(supply::reset(&device.RCC));
        let mut probe = Probe::new();
        probe.started(&started);
        let clocks =
            Config::hse(CRYSTAL_MHZ.MHz()).sysclk(CORE_MHZ.MHz()).pclk1(BUS_1_MHZ.MHz()).pclk2(BUS_2_MHZ.MHz());
        let mut rcc = device.RCC.freeze(clocks);
        let mut exti = device.EXTI;
        PWR::enable(&mut rcc);
        supply::watch(&device.PWR, &exti);
        let (a, b) = (device.GPIOA.split(&mut rcc), device.GPIOB.split(&mut rcc));

        // The chip selects are high before anything else moves, and from their first moment on.
        let mut port_select = a.pa4.into_push_pull_output_in_state(PinState::High);
        let potentiometer_select = b.pb12.into_push_pull_output_in_state(PinState::High);
        port_select.set_speed(Speed::High);

        let pins = (Some(a.pa5), Some(a.pa6), Some(a.pa7));
        let port_bus = device.SPI1.spi(pins, MODE_0, PORT_KHZ.kHz(), &mut rcc);
        let pins = (Some(b.pb13), SPI2::NoMiso, Some(b.pb15));
        let potentiometer_bus = device.SPI2.spi(pins, MODE_0, POTENTIOMETER_KHZ.kHz(), &mut rcc);
        let mut core = cx.core;
        health::count_cycles(&mut core.DCB, &mut core.DWT, CORE_MHZ);
        let delay = core.SYST.delay(&rcc.clocks);
        let Ok(port) = ExclusiveDevice::new_no_delay(port_bus, port_select);
        let Ok(potentiometer) = ExclusiveDevice::new_no_delay(potentiometer_bus, potentiometer_select);

        supply::hold_in_reset_when_low(&device.FLASH, &device.PWR);
        let Ok(store) = Store::new(ChipFlash(device.FLASH), flash::records()) else { panic!() };
        let application = Application::start(Parts {
            acquisition: Port::new(port),
            trim: Potentiometer::new(potentiometer, delay),
            store,
            watchdog: ChipWatchdog(watchdog),
            kept: zerorate_firmware::kept(),
            started,
            unit: unit::serial(),
            timing: Timing::PAPER,
            board: BoardNumbers::PAPER,
            health: health::health,
            memory: cx.local.memory,
            buffer: cx.local.buffer,
        });
        probe.found(&application.identity());
        let Application { compensator, task } = application;

        let line = serial::Config::default().baudrate(BAUD.bps());
        let Ok(serial) = device.USART2.serial::<u8>((a.pa2, a.pa3), line, &mut rcc) else { panic!() };
        let (sending, mut receiving) = serial.split();
        receiving.listen();
        let (received, heard) = cx.local.bytes.split();
        let line = serial::Config::default().baudrate(SCAN_BAUD.bps());
        let Ok(sending_scans) = device.USART1.tx::<u8>(b.pb6, line, &mut rcc) else { panic!() };
        let scan_line = ScanLine::new(sending_scans);

        let mut system = device.SYSCFG.constrain(&mut rcc);
        let mut data_ready_pin = b.pb0.into_pull_down_input();
        data_ready_pin.make_interrupt_source(&mut system);
        data_ready_pin.trigger_on_edge(&mut exti, Edge::Rising);
        data_ready_pin.enable_interrupt(&mut exti);
        let mut scan_ready_pin = b.pb1.into_pull_down_input();
        scan_ready_pin.make_interrupt_source(&mut system);
        scan_ready_pin.trigger_on_edge(&mut exti, Edge::Rising);
        scan_ready_pin.enable_interrupt(&mut exti);

        let mut timer = device.TIM2.counter_hz(&mut rcc);
        let Ok(()) = timer.start(LOOK_HZ.Hz()) else { panic!() };
        timer.listen(timer::Event::Update);
        (
            Shared { compensator, scan_line, data_ready_pin },
            Local { task, sending, receiving, received, heard, scan_ready_pin, timer, exti },
        )
    }

    /// Without this RTIC goes round in a circle.
    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// The acquisition port's scan ready line. Before data ready, which rises with it for the last scan of a set: that scan is
    /// still of the group that closes.
    #[task(binds = EXTI1, priority = 4, shared = [compensator, scan_line], local = [scan_ready_pin])]
    fn scan_ready(mut cx: scan_ready::Context) {
        cx.local.scan_ready_pin.clear_interrupt_pending_bit();
        let report = serve(&mut cx.shared.compensator, Compensator::scan);
        if let Some(frame) = report.and_then(|report| report.frame().ok()) {
            cx.shared.scan_line.lock(|line| line.begin(frame));
        }
    }

    /// The second line takes a byte.
    #[task(binds = USART1, priority = 5, shared = [scan_line])]
    fn scan_line(mut cx: scan_line::Context) {
        cx.shared.scan_line.lock(|line| line.go_on());
    }

    /// The acquisition port's data ready line.
    #[task(binds = EXTI0, priority = 3, shared = [compensator, data_ready_pin])]
    fn data_ready(mut cx: data_ready::Context) {
        cx.shared.data_ready_pin.clear_interrupt_pending_bit();
        health::timed(|| serve(&mut cx.shared.compensator, Compensator::service));
        rtic::pend(pac::Interrupt::EXTI2);
    }

    /// The tick, and the looks between ticks.
    #[task(binds = TIM2, priority = 3, shared = [compensator, data_ready_pin], local = [timer, looks: u32 = 0])]
    fn tick(mut cx: tick::Context) {
        cx.local.timer.clear_flags(timer::Flag::Update);
        let set_waits = cx.shared.data_ready_pin.is_high();
        let looks = cx.local.looks;
        *looks += 1;
        let is_tick = *looks == LOOK_HZ;
        if is_tick {
            *looks = 0;
        }
        let work = |compensator: &mut AtWork| if is_tick { compensator.tick() } else { compensator.look(set_waits) };
        if set_waits {
            serve(&mut cx.shared.compensator, work);
        } else {
            // No set, so nothing of the record's: a port that is dead for days is asked again and again, and a watchdog that bites
            // just then is not to blame the record.
            cx.shared.compensator.lock(work);
        }
        if !is_tick && !set_waits {
            return;
        }
        rtic::pend(pac::Interrupt::EXTI2);
    }

    /// A dip of the processor's supply.
    #[task(binds = PVD, priority = 2, local = [exti])]
    fn dip(cx: dip::Context) {
        supply::clear(cx.local.exti);
        zerorate_firmware::kept().dipped();
    }

    /// The host's line: first of all, for the next byte is there 87 us later and the chip keeps one.
    #[task(binds = USART2, priority = 5, local = [receiving, received])]
    fn host_line(cx: host_line::Context) {
        // An error of the line is a frame whose CRC will not match, as is a byte too many.
        if let Ok(byte) = cx.local.receiving.read() {
            let _ = cx.local.received.enqueue(byte);
        }
        rtic::pend(pac::Interrupt::EXTI2);
    }

    /// Console and store, in an interrupt that no pin raises.
    #[task(binds = EXTI2, priority = 1, shared = [compensator], local = [task, sending, heard])]
    fn console(cx: console::Context) {
        let (sending, heard) = (cx.local.sending, cx.local.heard);
        let line = &mut |bytes: &[u8]| bytes.iter().all(|&byte| block!(sending.write(byte)).is_ok());
        cx.local.task.run(&mut Locked(cx.shared.compensator), core::iter::from_fn(|| heard.dequeue()), line);
    }
}

/// Clock idle low, data taken on the rising edge.
const MODE_0: spi::Mode = spi::Mode { polarity: spi::Polarity::IdleLow, phase: spi::Phase::CaptureOnFirstTransition };

/// The wiper is left where it is, and the processor starts anew.
#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    zerorate_firmware::panicked(info)
}
