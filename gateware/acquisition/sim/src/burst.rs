//! The set's burst and a write as docs/acquisition-port.md lays them out.

use crc::{CRC_32_MPEG_2, Crc};

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_MPEG_2);

/// Words before the samples, their CRC included.
const HEAD_WORDS: usize = 16;

/// Words 0 to 14.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Head {
    /// The set's number.
    pub number: u32,
    /// Scans.
    pub length: u32,
    /// Sets were lost just before this one.
    pub lost_before: bool,
    /// Sets lost since RESTART.
    pub lost: u32,
    /// Sum of each channel's samples.
    pub sums: [u64; 4],
    /// Sum of their squares.
    pub squares: [u64; 4],
}

impl Head {
    /// What the head of a set of these scans must be, by adding them up.
    #[must_use]
    pub fn of(number: u32, lost_before: bool, lost: u32, scans: &[[u16; 4]]) -> Self {
        let total = |term: fn(u64) -> u64| {
            core::array::from_fn(|channel| scans.iter().map(|scan| term(u64::from(scan[channel]))).sum())
        };
        let length = u32::try_from(scans.len()).unwrap_or(u32::MAX);
        Self { number, length, lost_before, lost, sums: total(|x| x), squares: total(|x| x * x) }
    }
}

/// The words before the last, if the last is their CRC.
#[must_use]
pub fn checked(words: &[u32]) -> Option<&[u32]> {
    let (crc, content) = words.split_last()?;
    let mut digest = CRC.digest();
    content.iter().for_each(|word| digest.update(&word.to_be_bytes()));
    (digest.finalize() == *crc).then_some(content)
}

/// The head of a burst, if its CRC matches.
#[must_use]
pub fn head(burst: &[u32]) -> Option<Head> {
    let words = checked(burst.get(..HEAD_WORDS)?)?;
    assert_eq!(words[1] & 0xFFFE, 0, "reserved bits of word 1");
    Some(Head {
        number: words[0],
        length: words[1] >> 16,
        lost_before: words[1] & 1 == 1,
        lost: words[2],
        sums: core::array::from_fn(|channel| u64::from(words[3 + channel])),
        squares: core::array::from_fn(|channel| {
            u64::from(words[7 + 2 * channel]) << 32 | u64::from(words[8 + 2 * channel])
        }),
    })
}

/// The samples of a burst of so many scans, if their CRC matches.
#[must_use]
#[allow(clippy::cast_possible_truncation)] // Halves of words.
pub fn scans(burst: &[u32], length: usize) -> Option<Vec<[u16; 4]>> {
    let words = checked(burst.get(HEAD_WORDS..=HEAD_WORDS + 2 * length)?)?;
    let scan = |pair: &[u32]| [(pair[0] >> 16) as u16, pair[0] as u16, (pair[1] >> 16) as u16, pair[1] as u16];
    Some(words.chunks_exact(2).map(scan).collect())
}

/// The bytes that write a word.
#[must_use]
pub fn written(address: u8, word: u32) -> [u8; 10] {
    let [a, b, c, d] = word.to_be_bytes();
    let [e, f, g, h] = CRC.checksum(&[0x80 | address, 0, a, b, c, d]).to_be_bytes();
    [0x80 | address, 0, a, b, c, d, e, f, g, h]
}
