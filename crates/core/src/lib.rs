#![no_std]
#![doc = include_str!("../README.md")]

#[cfg(test)]
extern crate std;

pub mod board;
pub mod checksum;
pub mod compensate;
pub mod drift;
pub mod group;
pub mod record;
pub mod trim;
pub mod units;
pub mod wire;
