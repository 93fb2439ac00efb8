//! The board's side: handles on buses whose parts are at the other end of the channel.

use core::cell::RefCell;

use critical_section::Mutex;
use embedded_hal::delay::DelayNs;
use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use embedded_storage::nor_flash::{self, NorFlash, NorFlashErrorKind, ReadNorFlash};
use heapless::Vec;

use crate::message::{Answer, Board, Bus, MAX_REQUEST, Poll, Request, Transfer, VERSION};

/// Two pipes to the host: every byte arrives, or it is an error.
pub trait Line {
    /// What can go wrong.
    type Error: core::fmt::Debug;

    /// Writes all bytes.
    ///
    /// # Errors
    /// When the host is gone.
    fn write(&mut self, bytes: &[u8]) -> Result<(), Self::Error>;

    /// Fills `bytes`, waiting as long as it takes.
    ///
    /// # Errors
    /// When the host is gone.
    fn read(&mut self, bytes: &mut [u8]) -> Result<(), Self::Error>;
}

/// The bus, or the host, could not do what was asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BusFailed;

impl embedded_hal::spi::Error for BusFailed {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl nor_flash::NorFlashError for BusFailed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// The channel to the host: a request out, its answer in.
///
/// Interrupts and tasks share it. Each request is asked and answered with interrupts off: half of one must not be
/// overtaken by another.
pub struct Channel<L>(Mutex<RefCell<Option<L>>>);

impl<L> Channel<L> {
    /// A channel whose line is not there yet: every request fails.
    pub const fn closed() -> Self {
        Self(Mutex::new(RefCell::new(None)))
    }

    /// A channel on a line.
    pub const fn new(line: L) -> Self {
        Self(Mutex::new(RefCell::new(Some(line))))
    }
}

impl<L: Line> Channel<L> {
    /// Gives the channel its line, says that the board has started, and learns what board it is.
    ///
    /// # Errors
    /// [`BusFailed`], when the host is gone or speaks another version.
    pub fn open(&self, line: L) -> Result<Board, BusFailed> {
        critical_section::with(|section| self.0.replace(section, Some(line)));
        let mut bytes = [0; Board::BYTES];
        self.ask(&Request::Hello { version: VERSION }, &mut bytes)?;
        let board = Board::from_bytes(&bytes);
        if board.version == VERSION { Ok(board) } else { Err(BusFailed) }
    }

    /// Asks what has happened: [`Answer::SetReady`], [`Answer::Second`], or nothing but bytes of the host on their way.
    ///
    /// # Errors
    /// [`BusFailed`], when the host is gone.
    pub fn poll(&self, poll: Poll) -> Result<Answer, BusFailed> {
        let mut buffer = [0; 16];
        let request = Request::Poll(poll).encode(&mut buffer).ok_or(BusFailed)?;
        self.exchange(request, &mut core::iter::empty())
    }

    /// Says where the firmware has panicked.
    ///
    /// # Errors
    /// [`BusFailed`], when the host is gone, or the panic happened within a request.
    pub fn panicked(&self, file: &str, line: u32) -> Result<(), BusFailed> {
        self.ask(&Request::Panicked { file, line }, &mut [])
    }

    /// Asks for some bytes, or for none.
    fn ask(&self, request: &Request<'_>, answer: &mut [u8]) -> Result<(), BusFailed> {
        let mut buffer = [0; 2 + MAX_REQUEST];
        let request = request.encode(&mut buffer).ok_or(BusFailed)?;
        self.exchange(request, &mut core::iter::once(answer)).map(|_| ())
    }

    /// Sends an encoded request, alone, and reads the bytes of its answer.
    fn exchange(&self, request: &[u8], answers: &mut dyn Iterator<Item = &mut [u8]>) -> Result<Answer, BusFailed> {
        critical_section::with(|section| {
            let mut line = self.0.borrow(section).try_borrow_mut().map_err(|_| BusFailed)?;
            let line = line.as_mut().ok_or(BusFailed)?;
            line.write(request).map_err(|_| BusFailed)?;
            let mut byte = [0];
            line.read(&mut byte).map_err(|_| BusFailed)?;
            let answer = Answer::of(byte[0]).filter(|answer| *answer != Answer::Failed).ok_or(BusFailed)?;
            for bytes in answers {
                line.read(bytes).map_err(|_| BusFailed)?;
            }
            Ok(answer)
        })
    }
}

/// An SPI device at the other end of a channel.
pub struct LockstepSpi<'c, L> {
    channel: &'c Channel<L>,
    bus: Bus,
}

impl<'c, L> LockstepSpi<'c, L> {
    /// A part on the board's SPI.
    pub const fn new(channel: &'c Channel<L>, bus: Bus) -> Self {
        Self { channel, bus }
    }
}

impl<L> ErrorType for LockstepSpi<'_, L> {
    type Error = BusFailed;
}

impl<L: Line> SpiDevice for LockstepSpi<'_, L> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), BusFailed> {
        let mut transfers = Vec::new();
        for operation in &*operations {
            let transfer = match operation {
                Operation::Read(bytes) => Transfer::Read(u16::try_from(bytes.len()).map_err(|_| BusFailed)?),
                Operation::Write(bytes) => Transfer::Write(bytes),
                Operation::TransferInPlace(bytes) => Transfer::Exchange(bytes),
                Operation::Transfer(read, write) if read.len() == write.len() => Transfer::Exchange(write),
                Operation::Transfer(..) => return Err(BusFailed),
                Operation::DelayNs(ns) => Transfer::Delay(*ns),
            };
            transfers.push(transfer).map_err(|_| BusFailed)?;
        }
        let mut request = [0; 2 + MAX_REQUEST];
        let request = Request::Transaction { bus: self.bus, transfers }.encode(&mut request).ok_or(BusFailed)?;
        let mut reads = operations.iter_mut().filter_map(|operation| match operation {
            Operation::Read(bytes) | Operation::TransferInPlace(bytes) | Operation::Transfer(bytes, _) => {
                Some(&mut **bytes)
            }
            Operation::Write(_) | Operation::DelayNs(_) => None,
        });
        self.channel.exchange(request, &mut reads).map(|_| ())
    }
}

/// A delay on the bench's timeline.
impl<L: Line> DelayNs for &Channel<L> {
    fn delay_ns(&mut self, ns: u32) {
        // Without a host there is no bench, and no time to wait for.
        let _ = self.ask(&Request::Delay { ns }, &mut []);
    }
}

/// A NOR flash at the other end of a channel: `CAPACITY` bytes in sectors of `SECTOR`, written by words.
pub struct LockstepFlash<'c, L, const CAPACITY: usize, const SECTOR: usize> {
    channel: &'c Channel<L>,
}

impl<'c, L, const CAPACITY: usize, const SECTOR: usize> LockstepFlash<'c, L, CAPACITY, SECTOR> {
    /// Bytes in one request.
    const CHUNK: usize = 512;

    /// The flash.
    pub const fn new(channel: &'c Channel<L>) -> Self {
        Self { channel }
    }
}

impl<L, const CAPACITY: usize, const SECTOR: usize> nor_flash::ErrorType for LockstepFlash<'_, L, CAPACITY, SECTOR> {
    type Error = BusFailed;
}

impl<L: Line, const CAPACITY: usize, const SECTOR: usize> ReadNorFlash for LockstepFlash<'_, L, CAPACITY, SECTOR> {
    const READ_SIZE: usize = 1;

    // Inlined, every reader of the flash would have its own: 700 bytes.
    #[inline(never)]
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), BusFailed> {
        let mut at = offset;
        for chunk in bytes.chunks_mut(Self::CHUNK) {
            let length = u16::try_from(chunk.len()).map_err(|_| BusFailed)?;
            self.channel.ask(&Request::FlashRead { offset: at, length }, chunk)?;
            at += u32::from(length);
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        CAPACITY
    }
}

impl<L: Line, const CAPACITY: usize, const SECTOR: usize> NorFlash for LockstepFlash<'_, L, CAPACITY, SECTOR> {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), BusFailed> {
        self.channel.ask(&Request::FlashErase { from, to }, &mut [])
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), BusFailed> {
        let mut at = offset;
        for chunk in bytes.chunks(Self::CHUNK) {
            self.channel.ask(&Request::FlashWrite { offset: at, bytes: chunk }, &mut [])?;
            at += u32::try_from(chunk.len()).map_err(|_| BusFailed)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
