//! What is fuzzed, for the fuzzer and for the ordinary test that replays the seeds (crates/export/tests/fuzz_seeds.rs).

#![allow(dead_code, clippy::unwrap_used)]

use zerorate_cal::calibration::Calibration;
use zerorate_cal::fit::fit;
use zerorate_cal::log_fit::FitOptions;
use zerorate_cal::source::Source;
use zerorate_core::record::{DeviceRecord, MAX_RECORD_BYTES, RECORD_VERSION};
use zerorate_core::units::Axis;
use zerorate_export::{ExportOptions, Format, export};

/// A log of any kind: recognised by its content, read, conditioned, judged and fitted.
pub fn log(bytes: &[u8]) {
    let options = FitOptions { allow_narrow: true, ..FitOptions::default() };
    match fit(&[Source::bytes("log", bytes)], &options) {
        Ok(fit) => assert!(fit.judgement.rejected() || !fit.axes.is_empty()),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// A calibration: what is read must be written again the same, and everything made of it must be made or refused.
pub fn calibration(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let calibration = match Calibration::from_json(text) {
        Ok(calibration) => calibration,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    if let Ok(written) = calibration.to_json() {
        assert_eq!(Calibration::from_json(&written).unwrap().to_json().unwrap(), written);
    }
    let _ = calibration.to_device_record();
    for format in Format::ALL {
        let _ = export(&calibration, format, &ExportOptions { device_id: Some(1), instance: None });
    }
}

/// A device record: what is taken must be encoded again the same, and its laws must be made or refused. The input is taken
/// as it is, and as the body of a record with the right head and CRC, which no fuzzer would guess.
pub fn record(bytes: &[u8]) {
    decode(bytes);
    let mut whole = [b"ZRCR", &RECORD_VERSION.to_le_bytes()[..], bytes].concat();
    whole.extend(crc_32(&whole).to_le_bytes());
    decode(&whole);
}

fn decode(bytes: &[u8]) {
    let Ok(record) = DeviceRecord::decode(bytes) else { return };
    let mut room = [0; MAX_RECORD_BYTES];
    // Not each part of a record that is read need be finite, so bytes are compared and not numbers.
    let encoded = record.encode(&mut room).unwrap().to_vec();
    let again = DeviceRecord::decode(&encoded).unwrap();
    assert_eq!(again.encode(&mut room).unwrap(), encoded);
    for axis in [Axis::X, Axis::Y] {
        let _ = record.axis(axis).law();
    }
}

/// CRC-32 as in zip files (ISO 3309), a bit at a time.
fn crc_32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 })
    })
}
