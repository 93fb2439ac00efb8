#![doc = include_str!("../README.md")]

mod answer;
mod asked;
#[cfg(target_family = "wasm")]
mod file;
#[cfg(target_family = "wasm")]
mod interface;

pub use answer::Answer;
pub use asked::{Asked, AskedFile, FieldError};
