#![doc = include_str!("../README.md")]

pub mod address;
pub mod controller;
pub mod fault;
pub mod line;
pub mod modbus;
pub mod patience;
pub mod scpi;
pub mod supply;
