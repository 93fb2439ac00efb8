//! The project's Rust read as syntax, for checks that look at names: no macro is expanded and no type is known.
//!
//! Tests are left out, whether by `#[cfg(test)]` or by where a file stands.

mod attributes;
mod mentions;
mod named;
mod packages;
mod tree;

pub use attributes::{attributes_of, only_in_tests};
pub use mentions::{Kind, Mention, Mentions};
pub use named::{name_of, type_path};
pub use packages::{Package, packages};
pub use tree::Crate;
