//! CRC-32/MPEG-2: polynomial 0x04C11DB7, initial value all ones, not reflected, not inverted.

/// The remainder of each top byte.
const TABLE: [u32; 256] = table();

/// A CRC in progress.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crc32(u32);

impl Crc32 {
    pub(crate) fn new() -> Self {
        Self(u32::MAX)
    }

    /// Takes bytes.
    pub(crate) fn push(&mut self, bytes: &[u8]) {
        for byte in bytes {
            let [top, ..] = self.0.to_be_bytes();
            self.0 = self.0 << 8 ^ TABLE[usize::from(top ^ byte)];
        }
    }

    pub(crate) fn value(self) -> u32 {
        self.0
    }
}

const fn table() -> [u32; 256] {
    let mut table = [0; 256];
    let mut top = 0_u32;
    while top < 256 {
        let mut remainder = top << 24;
        let mut bit = 0;
        while bit < 8 {
            remainder = if remainder >> 31 == 1 { remainder << 1 ^ 0x04C1_1DB7 } else { remainder << 1 };
            bit += 1;
        }
        table[top as usize] = remainder;
        top += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_catalogue_s_check_value_comes_out() {
        let mut crc = Crc32::new();
        crc.push(b"123456789");
        assert_eq!(crc.value(), 0x0376_E6E7);
    }

    /// Any two different sets of up to four flipped bits change the CRC of a write (docs/acquisition-port.md) differently, so
    /// no eight together leave it right.
    #[test]
    fn eight_flipped_bits_of_a_write_are_always_seen() {
        const BITS: usize = 80;
        let of_bit = |bit: usize| {
            let mut bytes = [0; BITS / 8 + 4];
            bytes[bit / 8] = 0x80 >> (bit % 8);
            let (mut with, mut without) = (Crc32::new(), Crc32::new());
            with.push(&bytes);
            without.push(&[0; BITS / 8 + 4]);
            with.value() ^ without.value()
        };
        let changes: Vec<u32> = (0..BITS).map(of_bit).collect();
        let mut of_sets = vec![(0, 0)];
        let mut from = 0;
        for _ in 0..4 {
            let to = of_sets.len();
            for set in from..to {
                let (next, change) = of_sets[set];
                of_sets.extend((next..BITS).map(|bit| (bit + 1, change ^ changes[bit])));
            }
            from = to;
        }
        let mut seen: Vec<u32> = of_sets.into_iter().map(|(_, change)| change).collect();
        let sets = seen.len();
        seen.sort_unstable();
        seen.dedup();
        // 80 over 0 to 4.
        assert_eq!((seen.len(), sets), (1_666_981, 1_666_981));
    }
}
