//! The unit's serial: text in a sector of its own, which whoever builds the board writes with the probe. So every unit has the
//! same program, and a new program leaves the serial where it is.

use zerorate_core::record::{UNREADABLE, UnitSerial};

#[allow(unsafe_code)]
// SAFETY: memory.x says so; what stands there is never written by this program.
unsafe extern "C" {
    static __unit: [u8; PLACE];
}

/// As long as a serial may be, and the end after it.
const PLACE: usize = 33;
/// What flash holds where nothing was written.
const ERASED: u8 = 0xFF;

/// The serial, up to the first byte that ends it; empty where nothing was written: then the board takes any unit's record. What is
/// no text was written by mistake, and is the serial of no record: zeros, or a text that does not begin where it should (a file of
/// 16-bit letters begins with a byte that reads as erased).
pub fn serial() -> UnitSerial {
    #[allow(unsafe_code)]
    // SAFETY: the linker has left a whole sector to it; any bytes will do.
    let place = unsafe { &__unit };
    let written = place.iter().copied().take_while(|&byte| !matches!(byte, ERASED | 0 | b'\r' | b'\n'));
    let readable = |byte: u8| if (b' '..=b'~').contains(&byte) { char::from(byte) } else { UNREADABLE };
    let mut serial = UnitSerial::new();
    for byte in written {
        if serial.push(readable(byte)).is_err() {
            // Too long for any record's: the same.
            serial.clear();
            let _ = serial.push(UNREADABLE);
            break;
        }
    }
    if serial.is_empty() && place.iter().any(|&byte| byte != ERASED) {
        let _ = serial.push(UNREADABLE);
    }
    serial
}
