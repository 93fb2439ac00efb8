#![no_std]
#![doc = include_str!("../README.md")]

#[cfg(test)]
extern crate std;

mod board;
mod message;

pub use board::{BusFailed, Channel, Line, LockstepFlash, LockstepSpi};
pub use message::{Answer, Board, Bus, MAX_REQUEST, MAX_TRANSACTION, Poll, Request, SERIAL_BYTES, Transfer, VERSION};
