//! The other end of the board's buses: the plant's parts, and the flash on the board.

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::{Operation, SpiDevice};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use zerorate_lockstep::{Answer, Board, Bus, Request, Transfer};
use zerorate_sim::{Flash, PlantDelay, PortSpi, PotentiometerSpi, SharedPlant};

/// The board's flash for records: pages of 4 KiB, as many as `zerorate-device` needs for two generations.
const FLASH_PAGES: usize = 5;

/// The parts that the board reaches.
pub(super) struct Buses {
    pub(super) plant: SharedPlant,
    port: PortSpi,
    potentiometer: PotentiometerSpi,
    delay: PlantDelay,
    flash: Flash<4096, 4>,
    board: Board,
}

impl Buses {
    /// The parts of a plant, and a blank flash.
    pub(super) fn new(plant: &SharedPlant, board: Board) -> Self {
        Self {
            plant: SharedPlant::clone(plant),
            port: PortSpi::new(plant),
            potentiometer: PotentiometerSpi::new(plant),
            delay: PlantDelay::new(plant),
            flash: Flash::erased(FLASH_PAGES),
            board,
        }
    }

    /// Does what the board asks of them; the whole answer, appended to `reply`. Polls and panics are not theirs.
    pub(super) fn serve(&mut self, request: &Request<'_>, reply: &mut Vec<u8>) {
        let begin = reply.len();
        reply.push(Answer::Done as u8);
        if self.carry_out(request, reply).is_none() {
            reply.truncate(begin);
            reply.push(Answer::Failed as u8);
        }
    }

    fn carry_out(&mut self, request: &Request<'_>, reply: &mut Vec<u8>) -> Option<()> {
        match request {
            Request::Hello { .. } => reply.extend(self.board.to_bytes()),
            Request::Transaction { bus: Bus::Port, transfers } => transact(&mut self.port, transfers, reply)?,
            Request::Transaction { bus: Bus::Potentiometer, transfers } => {
                transact(&mut self.potentiometer, transfers, reply)?;
            }
            Request::Delay { ns } => self.delay.delay_ns(*ns),
            Request::FlashRead { offset, length } => {
                let begin = reply.len();
                reply.resize(begin + usize::from(*length), 0);
                self.flash.read(*offset, &mut reply[begin..]).ok()?;
            }
            Request::FlashWrite { offset, bytes } => self.flash.write(*offset, bytes).ok()?,
            Request::FlashErase { from, to } => self.flash.erase(*from, *to).ok()?,
            Request::Poll(_) | Request::Panicked { .. } => {}
        }
        Some(())
    }
}

/// One SPI transaction; what was read is appended to `reply`. `None` when the bus fails.
fn transact(spi: &mut impl SpiDevice, transfers: &[Transfer<'_>], reply: &mut Vec<u8>) -> Option<()> {
    // What comes in: of each transfer, in order, one after the other.
    let lengths = transfers.iter().map(|transfer| match transfer {
        Transfer::Read(length) => usize::from(*length),
        Transfer::Exchange(bytes) => bytes.len(),
        Transfer::Write(_) | Transfer::Delay(_) => 0,
    });
    let begin = reply.len();
    reply.resize(begin + lengths.clone().sum::<usize>(), 0);
    let mut rest = &mut reply[begin..];
    let mut operations = Vec::with_capacity(transfers.len());
    for (transfer, length) in transfers.iter().zip(lengths) {
        let (read, further) = rest.split_at_mut(length);
        rest = further;
        operations.push(match transfer {
            Transfer::Read(_) => Operation::Read(read),
            Transfer::Write(bytes) => Operation::Write(bytes),
            Transfer::Exchange(bytes) => Operation::Transfer(read, bytes),
            Transfer::Delay(ns) => Operation::DelayNs(*ns),
        });
    }
    spi.transaction(&mut operations).ok()
}
