#![no_std]
#![doc = include_str!("../README.md")]

#[cfg(test)]
extern crate std;

#[cfg(test)]
mod tests;

pub mod acquisition;
pub mod ad7949;
pub mod application;
pub mod compensator;
pub mod console;
pub mod direct;
pub mod port;
pub mod restart;
pub mod store;
pub mod trim_part;
pub mod watchdog;
