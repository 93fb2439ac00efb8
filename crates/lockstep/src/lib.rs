#![no_std]
#![doc = include_str!("../README.md")]

#[cfg(test)]
extern crate std;

mod board;
mod message;

pub use board::{
    BusFailed, Channel, Line, LockstepDelay, LockstepFlash, LockstepSpi, SharedChannel, open, panicked, poll,
};
pub use message::{
    Answer, Board, Bus, MAX_REQUEST, MAX_TRANSACTION, Malformed, Poll, Request, SERIAL_BYTES, Transfer, VERSION,
};
