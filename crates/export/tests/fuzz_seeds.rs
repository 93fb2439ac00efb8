//! The fuzz targets' seeds, and a few hundred changed copies of each, through the same parsers: what the fuzzer finds once
//! does not come back. How long an input may take, and how much memory, the fuzzer watches: `cargo xtask fuzz`.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

#[path = "../../../fuzz/parsers.rs"]
mod parsers;

use std::fs;
use std::path::Path;

/// Changed copies of a seed.
const CHANGED: u32 = 150;

/// Cut copies of a seed.
const CUTS: usize = 40;

/// Numbers that look random, the same in every run (Park and Miller's generator).
struct Dice(u64);

impl Dice {
    // Below `sides`.
    #[allow(clippy::cast_possible_truncation)]
    fn roll(&mut self, sides: usize) -> usize {
        self.0 = self.0 * 16_807 % 2_147_483_647;
        (self.0 % sides.max(1) as u64) as usize
    }
}

/// A copy with some bytes changed, or a part of it doubled.
fn changed(seed: &[u8], dice: &mut Dice) -> Vec<u8> {
    const TELLING: [u8; 6] = [0, 1, 0x7f, 0x80, 0xff, b'9'];
    let mut bytes = seed.to_vec();
    if dice.roll(8) == 0 {
        let from = dice.roll(bytes.len());
        let part = bytes[from..(from + dice.roll(64)).min(bytes.len())].to_vec();
        let to = dice.roll(bytes.len());
        bytes.splice(to..to, part);
    }
    for _ in 0..=dice.roll(4) {
        let at = dice.roll(bytes.len());
        bytes[at] = if dice.roll(2) == 0 { TELLING[dice.roll(6)] } else { bytes[at] ^ (1 << dice.roll(8)) };
    }
    bytes
}

fn replay(target: &str, parser: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds").join(target);
    let mut files: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{} has no seeds", folder.display());
    for file in files {
        let seed = fs::read(&file).unwrap();
        parser(&seed);
        for cut in 0..CUTS {
            parser(&seed[..seed.len() * cut / CUTS]);
        }
        let mut dice = Dice(42);
        for _ in 0..CHANGED {
            parser(&changed(&seed, &mut dice));
        }
    }
}

#[test]
fn logs_of_px4_are_read_or_refused() {
    replay("ulog", parsers::log);
}

#[test]
fn logs_of_ardupilot_are_read_or_refused() {
    replay("dataflash", parsers::log);
}

#[test]
fn tables_are_read_or_refused() {
    replay("csv", parsers::log);
}

#[test]
fn calibrations_are_read_or_refused() {
    replay("calibration", parsers::calibration);
}

#[test]
fn device_records_are_read_or_refused() {
    replay("record", parsers::record);
}
