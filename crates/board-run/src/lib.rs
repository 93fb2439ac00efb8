#![doc = include_str!("../README.md")]

pub mod folder;
pub mod summary;
pub mod uncertainty;
