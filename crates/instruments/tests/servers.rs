//! Against servers that nobody here wrote: pymodbus with a lagging chamber behind it, sinstruments' supply; and between them
//! and us a line that does what lines do.
//!
//! `cargo xtask test instruments` gives the Python with both in `ZERORATE_INSTRUMENTS_PYTHON`; without it nothing is run.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used, missing_docs)]
#![cfg(unix)]

#[path = "servers/fault_line.rs"]
mod fault_line;
#[path = "servers/modbus.rs"]
mod modbus;
#[path = "servers/scpi.rs"]
mod scpi;
#[path = "servers/server.rs"]
mod server;
