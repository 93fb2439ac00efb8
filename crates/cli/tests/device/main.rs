//! Boards in real time, on a pseudo-terminal as on a serial port, and on TCP: every verb, bad lines, boards that go, and
//! a person at the bench.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used, missing_docs)]
#![cfg(unix)]

#[allow(dead_code)] // The other tests make recordings with it too.
#[path = "../command/bench.rs"]
mod bench;
mod board;
#[allow(dead_code)] // Nor all that a line does.
#[path = "../../../instruments/tests/servers/fault_line.rs"]
mod fault_line;
mod manual;
mod night;
mod profile;
#[allow(dead_code)] // Nor every helper.
#[path = "../command/schema.rs"]
mod schema;
mod self_test;
#[path = "../../../instruments/tests/servers/server.rs"]
mod server;
mod together;
mod unplugged;
mod verbs;
