#![no_main]

#[path = "../limits.rs"]
mod limits;

use zerorate_live::{Guard, decide};

/// A request's head: whoever does not know the token, or names another host, gets nothing.
fn request(bytes: &[u8]) {
    let local = "192.168.1.7:5495".parse().unwrap();
    let holds = |part: &[u8]| bytes.windows(part.len()).any(|own| own == part);
    let guard = Guard { token: Some("0123456789abcdef".into()), name: None };
    if decide(bytes, &guard, local).is_ok() {
        assert!(holds(b"token=0123456789abcdef") && holds(b"192.168.1.7"));
    }
    if decide(bytes, &Guard::default(), local).is_ok() {
        assert!(holds(b"192.168.1.7"));
    }
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| limits::held(request, bytes));
