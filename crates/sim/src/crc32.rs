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

    /// Takes the four bytes of a word, high byte first.
    pub(crate) fn push(&mut self, word: u32) {
        for byte in word.to_be_bytes() {
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
        // The RevEng catalogue's check is over "123456789": eight bytes as words, and the ninth by the table.
        let mut crc = Crc32::new();
        crc.push(0x3132_3334);
        crc.push(0x3536_3738);
        let last = crc.0 << 8 ^ TABLE[usize::from(crc.0.to_be_bytes()[0] ^ 0x39)];
        assert_eq!(last, 0x0376_E6E7);
    }
}
