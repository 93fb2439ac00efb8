//! Boards in real time, on a pseudo-terminal as on a serial port, and on TCP: every verb, bad lines, boards that go, and
//! a person at the bench.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used, missing_docs)]
#![cfg(unix)]

#[allow(dead_code)] // The other tests make recordings with it too.
#[path = "../command/bench.rs"]
mod bench;
mod board;
mod manual;
mod night;
#[allow(dead_code)] // Nor every helper.
#[path = "../command/schema.rs"]
mod schema;
mod self_test;
mod unplugged;
mod verbs;
