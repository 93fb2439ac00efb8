#![no_main]

#[path = "../limits.rs"]
mod limits;
#[path = "../parsers.rs"]
mod parsers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| limits::held(parsers::log, bytes));
