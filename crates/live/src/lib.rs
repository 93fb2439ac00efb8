#![doc = include_str!("../README.md")]

mod guard;
mod listen;
mod parts;
mod reader;
mod request;
mod server;
mod unheard;

pub use guard::Guard;
pub use listen::{Listen, UnknownListen};
pub use request::{Refusal, Wanted, decide};
pub use server::{Live, LiveError};
