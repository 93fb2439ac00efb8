//! The AD7949's serial side, for a processor that drives the A/D itself (data sheet Rev. E, table 9 and "Reading/writing
//! after conversion, any speed hosts").
//!
//! A frame is 16 clocks. In: the 14-bit configuration, most significant bit first, and two bits that do not matter. Out: a
//! result of 14 bits, straight binary, most significant bit first, and two zeros. The rise of chip select samples the
//! input and converts it by the configuration of the frame before, so the result in frame k belongs to the configuration of
//! frame k - 2: six frames read the four channels of a scan, the first two results being left over from before.

/// A conversion at most, with the board's 5 V (t_CONV, table 5). A clock meanwhile disturbs it: no result of it is to be believed.
const CONVERSION_NS: u64 = 2200;

/// The part's registers.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ad7949 {
    /// The configuration in force; none before the first one after power-up, when the sheet calls it undefined, and after
    /// one that the bench does not have.
    configuration: Option<Configuration>,
    /// What is still to be sent of the frame, the next bit highest.
    sending: u16,
    /// What the conversion since the last frame gave.
    converted: u16,
    /// When that is done.
    converting_until_ns: u64,
    shift: u32,
    clocks: u32,
}

/// A configuration that this part of the bench can do.
#[derive(Debug, Clone, Copy)]
struct Configuration {
    channel: usize,
}

impl Configuration {
    /// Single-ended unipolar inputs (INCC 11x), the board's reference at the pin REF and neither the buffer, which would drive
    /// the same pin, nor the temperature sensor (REF 110), no sequencer (SEQ 00), no readback (RB 1). The input filter (BW) is far above the board's own low-pass: either setting does.
    fn checked(word: u16) -> Option<Self> {
        let field = |lowest: u32, bits: u32| word >> lowest & ((1 << bits) - 1);
        let (input, reference, sequencer, no_readback) = (field(10, 3), field(3, 3), field(1, 2), field(0, 1));
        let possible = input >= 0b110 && reference == 0b110 && sequencer == 0 && no_readback == 1;
        possible.then_some(Self { channel: usize::from(field(7, 3)) })
    }
}

impl Ad7949 {
    /// Chip select falls: the last conversion's result goes to the shift register. What is not done gives nothing.
    pub(crate) fn select(&mut self, now_ns: u64) {
        if now_ns < self.converting_until_ns {
            self.converted = 0;
        }
        self.sending = self.converted << 2;
        self.shift = 0;
        self.clocks = 0;
    }

    /// A clock: a bit in and a bit out.
    pub(crate) fn clock(&mut self, bit: bool) -> bool {
        let sent = self.sending >> 15 == 1;
        self.sending <<= 1;
        self.shift = self.shift << 1 | u32::from(bit);
        self.clocks += 1;
        sent
    }

    /// Chip select rises: the inputs, as they are held, are converted by the configuration so far; then the new one is
    /// taken over, if its bit 13 says so.
    pub(crate) fn deselect(&mut self, held: &[u16; 4], now_ns: u64) {
        self.converting_until_ns = now_ns + CONVERSION_NS;
        // Inputs 4 to 7 are grounded.
        self.converted = self.configuration.map_or(0, |cfg| held.get(cfg.channel).copied().unwrap_or(0));
        if self.clocks != 16 {
            return;
        }
        let [_, _, high, low] = self.shift.to_be_bytes();
        let word = u16::from_be_bytes([high, low]) >> 2;
        if word >> 13 & 1 == 1 {
            self.configuration = Configuration::checked(word);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spi::eight_clocks;

    const HELD: [u16; 4] = [0x1234, 0x0001, 0x3FFF, 0x2000];

    /// Overwrite, single-ended, full bandwidth, external reference, no sequencer, no readback.
    fn word(channel: u16) -> u16 {
        1 << 13 | 0b111 << 10 | channel << 7 | 1 << 6 | 0b110 << 3 | 1
    }

    /// A frame as soon as the conversion is done.
    fn frame(part: &mut Ad7949, word: u16, held: &[u16; 4]) -> u16 {
        let now_ns = part.converting_until_ns;
        frame_at(part, word, held, now_ns)
    }

    fn frame_at(part: &mut Ad7949, word: u16, held: &[u16; 4], now_ns: u64) -> u16 {
        part.select(now_ns);
        let result = (word << 2).to_be_bytes().map(|byte| eight_clocks(byte, |bit| part.clock(bit)));
        part.deselect(held, now_ns);
        u16::from_be_bytes(result)
    }

    #[test]
    fn a_result_belongs_to_the_configuration_two_frames_before() {
        let mut part = Ad7949::default();
        let results: Vec<u16> = [0, 1, 2, 3, 0, 0].map(|channel| frame(&mut part, word(channel), &HELD) >> 2).into();
        assert_eq!(results[2..], HELD);
    }

    #[test]
    fn the_inputs_are_sampled_in_the_frame_between_the_configuration_and_its_result() {
        let mut part = Ad7949::default();
        frame(&mut part, word(0), &[1, 0, 0, 0]);
        frame(&mut part, word(0), &[2, 0, 0, 0]);
        assert_eq!(frame(&mut part, word(0), &[3, 0, 0, 0]) >> 2, 2);
    }

    #[test]
    fn a_frame_before_the_conversion_is_done_brings_nothing_of_it() {
        let mut part = Ad7949::default();
        frame_at(&mut part, word(0), &HELD, 0);
        frame_at(&mut part, word(0), &HELD, 3000);
        assert_eq!(frame_at(&mut part, word(0), &HELD, 5199), 0);
        assert_eq!(frame_at(&mut part, word(0), &HELD, 8200) >> 2, HELD[0]);
    }

    #[test]
    fn without_the_overwrite_bit_the_configuration_stays() {
        let mut part = Ad7949::default();
        frame(&mut part, word(2), &HELD);
        frame(&mut part, 0, &HELD);
        frame(&mut part, 0, &HELD);
        assert_eq!(frame(&mut part, 0, &HELD) >> 2, HELD[2]);
    }

    #[test]
    fn a_mode_it_does_not_have_reads_zero_and_a_frame_of_another_length_configures_nothing() {
        let mut part = Ad7949::default();
        for wrong in [word(1) & !(1 << 12), word(1) & !(1 << 4), word(1) | 1 << 3, word(1) | 0b110, word(1) & !1] {
            for _ in 0..3 {
                assert_eq!(frame(&mut part, wrong, &HELD), 0, "{wrong:#b}");
            }
        }
        frame(&mut part, word(2), &HELD);
        let now_ns = part.converting_until_ns;
        part.select(now_ns);
        eight_clocks(0xFF, |bit| part.clock(bit));
        part.deselect(&HELD, now_ns);
        assert_eq!(frame(&mut part, word(0), &HELD) >> 2, HELD[2]);
        assert_eq!(frame(&mut part, word(0), &HELD) >> 2, HELD[2]);
    }

    #[test]
    fn the_spare_inputs_are_grounded() {
        let mut part = Ad7949::default();
        for channel in 4..8 {
            (0..2).for_each(|_| _ = frame(&mut part, word(channel), &HELD));
            assert_eq!(frame(&mut part, word(channel), &HELD), 0);
        }
    }
}
