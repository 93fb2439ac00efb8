//! The application on a board, whatever the board: [`parts`] in the shape in which interrupts and tasks share them, and
//! [`fault`], what is left of a panic.
//!
//! It holds no registers: a board's folder has its clock, pins, lines and interrupt vectors.

#![no_std]

pub mod fault;
pub mod parts;
