//! The names by which the page calls us, and those by which we call it: plain numbers and places in memory.
//!
//! The page asks for room (`request`), writes its request there as JSON, lets us `fit`, and reads JSON of `answer_length`
//! bytes at `answer`.

use std::sync::{Mutex, PoisonError};

use crate::answer::Answer;
use crate::asked::Asked;
use crate::file;

static REQUEST: Mutex<Vec<u8>> = Mutex::new(Vec::new());
static ANSWER: Mutex<Vec<u8>> = Mutex::new(Vec::new());

#[link(wasm_import_module = "page")]
unsafe extern "C" {
    /// Writes at most `length` bytes of a file, from `offset` on, to `into`; how many, or less than zero.
    fn read(place: u32, offset: f64, into: *mut u8, length: usize) -> i32;
    /// Takes the words of a failure of ours, before we end.
    fn failed(text: *const u8, length: usize);
}

/// A slice of the page's file, from `offset` on: how many bytes came, or nothing where it cannot be read.
fn slice(place: u32, offset: u64, into: &mut [u8]) -> Option<usize> {
    // Exact up to 2^53 bytes.
    #[allow(clippy::cast_precision_loss)]
    let offset = offset as f64;
    // SAFETY: the page writes no more than the length that it is given, all of which is ours.
    let came = unsafe { read(place, offset, into.as_mut_ptr(), into.len()) };
    usize::try_from(came).ok().map(|came| came.min(into.len()))
}

/// Room for a request of so many bytes.
#[unsafe(no_mangle)]
pub extern "C" fn request(length: usize) -> *mut u8 {
    let mut request = REQUEST.lock().unwrap_or_else(PoisonError::into_inner);
    request.clear();
    request.resize(length, 0);
    request.as_mut_ptr()
}

/// Does what was requested, and keeps the answer.
#[unsafe(no_mangle)]
pub extern "C" fn fit() {
    std::panic::set_hook(Box::new(|panic| {
        let text = panic.to_string();
        // SAFETY: the page reads the text before it returns.
        unsafe { failed(text.as_ptr(), text.len()) };
    }));
    let request = REQUEST.lock().unwrap_or_else(PoisonError::into_inner);
    let answer = match serde_json::from_slice::<Asked>(&request) {
        Ok(asked) => {
            let sources: Vec<_> =
                (0..).zip(&asked.files).map(|(place, asked)| file::source(place, asked, slice)).collect();
            Answer::of(&asked, &sources)
        }
        Err(error) => Answer::Error(format!("the page asked for what is not known: {error}: load the page again")),
    };
    let text = serde_json::to_vec(&answer);
    *ANSWER.lock().unwrap_or_else(PoisonError::into_inner) =
        text.unwrap_or_else(|error| format!("{{\"error\":\"{error}\"}}").into_bytes());
}

/// Where the answer is.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    ANSWER.lock().unwrap_or_else(PoisonError::into_inner).as_ptr()
}

/// How long it is, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn answer_length() -> usize {
    ANSWER.lock().unwrap_or_else(PoisonError::into_inner).len()
}
