//! The application on the emulated board: QEMU's mps2-an386, a Cortex-M4F. The plant is at the other end of the
//! lock-step channel; the host talks on UART0.

#![no_std]
#![no_main]
#![allow(clippy::cast_possible_truncation)] // addresses are 32 bits here

use cortex_m_rt as _;

mod chip;
mod semihosting;

use heapless::String;
use heapless::spsc::{Consumer, Producer};
use zerorate_core::board::BoardNumbers;
use zerorate_device::acquisition::Timing;
use zerorate_device::application::{Application, Parts, Task};
use zerorate_device::compensator::{Compensator, Memory};
use zerorate_device::console::Buffer;
use zerorate_device::port::PortAcquisition;
use zerorate_device::restart::{Keeping, Kept, Reset};
use zerorate_device::store::FlashStore;
use zerorate_device::trim_part::Max5494Trim;
use zerorate_device::watchdog::NoWatchdog;
use zerorate_firmware::{Locked, Received, health, serve};
use zerorate_lockstep::{Answer, Board, Bus, BusFailed, Channel, LockstepFlash, LockstepSpi, Poll};

use crate::chip::{Receiving, Sending};
use crate::semihosting::Fifos;

type Port = PortAcquisition<LockstepSpi<'static, Fifos>>;
type Potentiometer = Max5494Trim<LockstepSpi<'static, Fifos>, &'static Channel<Fifos>>;
type Store = FlashStore<LockstepFlash<'static, Fifos, FLASH_BYTES, PAGE_BYTES>>;

/// The flash for records, as the bench has it: a record of the greatest length and its neighbour's page in each half.
const PAGE_BYTES: usize = 4096;
const FLASH_BYTES: usize = 4 * PAGE_BYTES;

/// The lock-step channel to the host. Empty until it is open; a panic says its last word through it.
static CHANNEL: Channel<Fifos> = Channel::closed();

#[rtic::app(device = crate::chip, peripherals = false)]
mod app {
    use super::*;

    #[shared]
    struct Shared {
        compensator: Compensator<Port, Keeping<Potentiometer, &'static Kept>, &'static mut Memory>,
        /// How far the line to the host has come.
        progress: Poll,
    }

    #[local]
    struct Local {
        task: Task<Store, NoWatchdog, &'static Kept, &'static mut Buffer>,
        sending: Sending,
        receiving: Receiving,
        received: Producer<'static, u8>,
        heard: Consumer<'static, u8>,
    }

    #[init(local = [bytes: Received = Received::new(), memory: Memory = Memory::new(), buffer: Buffer = Buffer::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let board = open();
        let Ok(store) = Store::new(LockstepFlash::new(&CHANNEL), 0..FLASH_BYTES as u32) else { panic!() };
        let Application { compensator, task } = Application::start(Parts {
            acquisition: Port::new(LockstepSpi::new(&CHANNEL, Bus::Port)),
            trim: Potentiometer::new(LockstepSpi::new(&CHANNEL, Bus::Potentiometer), &CHANNEL),
            store,
            watchdog: NoWatchdog,
            kept: zerorate_firmware::kept(),
            started: zerorate_firmware::kept().started(Reset::Untold),
            unit: String::try_from(board.serial()).unwrap_or_default(),
            timing: Timing {
                scan_period_us: board.scan_period_us,
                set_length: board.set_length,
                oversampling: board.oversampling,
            },
            board: BoardNumbers::PAPER,
            health: health::health,
            memory: cx.local.memory,
            buffer: cx.local.buffer,
        });
        let (received, heard) = cx.local.bytes.split();
        let (receiving, sending) = chip::uart0();
        (Shared { compensator, progress: Poll::default() }, Local { task, sending, receiving, received, heard })
    }

    /// Waits in the channel for the next set, and stands for the pin and the timer that say so.
    #[idle(shared = [progress])]
    fn idle(mut cx: idle::Context) -> ! {
        loop {
            // With interrupts off, so that a byte that comes after the question still wakes from the sleep.
            critical_section::with(|_| {
                let progress = cx.shared.progress.lock(|progress| *progress);
                match CHANNEL.poll(progress) {
                    Ok(Answer::SetReady) => rtic::pend(chip::Interrupt::PORT0),
                    Ok(Answer::Second) => rtic::pend(chip::Interrupt::TIMER0),
                    // The host has sent bytes that are still on their way.
                    Ok(_) => cortex_m::asm::wfi(),
                    // Nobody is left to work for.
                    Err(_) => semihosting::give_up(b"the bench has gone\n\0"),
                }
            });
        }
    }

    /// Data ready.
    #[task(binds = PORT0, priority = 3, shared = [compensator])]
    fn data_ready(mut cx: data_ready::Context) {
        serve(&mut cx.shared.compensator, Compensator::service);
        rtic::pend(chip::Interrupt::PORT1);
    }

    /// The tick.
    #[task(binds = TIMER0, priority = 3, shared = [compensator])]
    fn tick(mut cx: tick::Context) {
        serve(&mut cx.shared.compensator, Compensator::tick);
        rtic::pend(chip::Interrupt::PORT1);
    }

    /// The host's line.
    #[task(binds = UART0_RX, priority = 2, local = [receiving, received])]
    fn host_line(cx: host_line::Context) {
        while let Some(byte) = cx.local.receiving.take() {
            // A byte too many is a frame whose CRC will not match.
            let _ = cx.local.received.enqueue(byte);
        }
        rtic::pend(chip::Interrupt::PORT1);
    }

    /// Console and store.
    #[task(binds = PORT1, priority = 1, shared = [compensator, progress], local = [task, sending, heard])]
    fn console(mut cx: console::Context) {
        let (task, sending, heard) = (cx.local.task, cx.local.sending, cx.local.heard);
        let line = &mut |bytes: &[u8]| {
            sending.send(bytes);
            true
        };
        task.run(&mut Locked(cx.shared.compensator), core::iter::from_fn(|| heard.dequeue()), line);
        let progress = Poll { received: task.taken(), sent: sending.sent() };
        cx.shared.progress.lock(|shared| *shared = progress);
    }
}

/// Opens the channel and learns what board this is.
fn open() -> Board {
    let opened = Fifos::open().map_err(|_| BusFailed).and_then(|line| CHANNEL.open(line));
    match opened {
        Ok(board) => board,
        Err(_) => semihosting::give_up(
            b"this firmware needs the simulated bench at the other end: zerorate calibrate --device emulated\n\0",
        ),
    }
}

/// The wiper is left where it is; the host is told, and the processor starts anew.
#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    if let Some(place) = info.location() {
        // The host may be gone; the fault is counted all the same.
        let _ = CHANNEL.panicked(place.file(), place.line());
    }
    zerorate_firmware::panicked(info)
}
