//! The AD7949 at its pins (data sheet Rev. D): read and written after the conversion, without a busy indicator.
//!
//! CNV's rise holds the input that the configuration of the frame before names and converts it; then the configuration
//! that came in this frame takes over. So a result belongs to the configuration of two frames before.

use crate::Ps;

/// Clocks of a frame.
const FRAME_CLOCKS: u32 = 16;
/// Bits of a configuration and of a result.
const WORD_BITS: u32 = 14;

/// The configuration's bits 9 to 7.
const CHANNEL: u32 = 0b111 << 7;
/// The rest of it, by table 9: overwrite 1, INCC 111 (unipolar, to ground), BW 1 (full bandwidth), REF 110 (the board's
/// reference at the pin REF; buffer and temperature sensor off), SEQ 00 (no sequencer), RB 1 (no read-back).
#[allow(clippy::inconsistent_digit_grouping, clippy::unusual_byte_groupings)] // By fields.
const THE_BOARDS: u32 = 0b1_111_000_1_110_00_1;

/// The data sheet's limits that a master can break, in picoseconds.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// t_CONV: CNV's rise to the end of conversion, at most.
    pub conversion_ps: Ps,
    /// t_ACQ: end of conversion, or what was clocked after it, to CNV's rise, at least.
    pub acquisition_ps: Ps,
    /// SCK low and high, at least.
    pub half_clock_ps: Ps,
}

impl Limits {
    /// Below 4.5 V, the slower: 3.2 us and 1.8 us (table 4). SCK so that SDO (t_DSDO 24 ns) is there for its rise.
    pub const DATA_SHEET: Self = Self { conversion_ps: 3_200_000, acquisition_ps: 1_800_000, half_clock_ps: 24_000 };
    /// For the fast scale, which a real part could not follow.
    pub const NONE: Self = Self { conversion_ps: 0, acquisition_ps: 0, half_clock_ps: 0 };
}

/// A frame that is through: what it brought, if its result was of one of the inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// When CNV fell.
    pub began_ps: Ps,
    /// The input and its counts; `None` before the first configuration.
    pub result: Option<(usize, u16)>,
}

/// The part.
#[derive(Debug)]
pub struct Ad7949 {
    limits: Limits,
    cnv: bool,
    sck: bool,
    /// The input that the next conversion takes.
    channel: Option<usize>,
    converted: Option<(usize, u16)>,
    converting_until_ps: Ps,
    frame_began_ps: Ps,
    sck_changed_ps: Ps,
    rises: u32,
    falls: u32,
    shifted_in: u32,
    /// What a master did that the sheet forbids.
    pub faults: Vec<String>,
}

impl Ad7949 {
    /// A part at power-up.
    #[must_use]
    pub const fn new(limits: Limits) -> Self {
        Self {
            limits,
            cnv: true,
            sck: false,
            channel: None,
            converted: None,
            converting_until_ps: 0,
            frame_began_ps: 0,
            sck_changed_ps: 0,
            rises: 0,
            falls: 0,
            shifted_in: 0,
            faults: Vec::new(),
        }
    }

    /// The pins have these levels now; `input` gives the counts of a channel when it is converted. Returns the frame that
    /// ended with this.
    pub fn pins(
        &mut self,
        now_ps: Ps,
        cnv: bool,
        sck: bool,
        din: bool,
        input: impl FnOnce(usize) -> u16,
    ) -> Option<Frame> {
        let mut ended = None;
        if self.cnv && !cnv {
            self.frame_began_ps = now_ps;
            (self.rises, self.falls, self.shifted_in) = (0, 0, 0);
            if now_ps < self.converting_until_ps {
                self.fault(now_ps, "CNV fell before the conversion was over");
            }
        }
        if self.sck != sck {
            if !cnv && now_ps - self.sck_changed_ps.max(self.frame_began_ps) < self.limits.half_clock_ps {
                self.fault(now_ps, "SCK is too fast");
            }
            self.sck_changed_ps = now_ps;
            if cnv {
                self.fault(now_ps, "SCK moved while CNV was high");
            } else if sck {
                self.rises += 1;
                if self.rises <= WORD_BITS {
                    self.shifted_in = self.shifted_in << 1 | u32::from(din);
                }
            } else {
                self.falls += 1;
            }
        }
        if !self.cnv && cnv {
            ended = self.convert(now_ps, input);
        }
        (self.cnv, self.sck) = (cnv, sck);
        ended
    }

    /// SDO: the result, most significant bit first. Nothing drives it otherwise, and a pull-up holds it.
    #[must_use]
    pub fn sdo(&self) -> bool {
        let counts = self.converted.map_or(0x3FFF, |(_, counts)| u32::from(counts));
        self.cnv || self.falls >= WORD_BITS || counts >> (WORD_BITS - 1 - self.falls) & 1 == 1
    }

    fn convert(&mut self, now_ps: Ps, input: impl FnOnce(usize) -> u16) -> Option<Frame> {
        if now_ps - self.converting_until_ps.max(self.frame_began_ps) < self.limits.acquisition_ps {
            self.fault(now_ps, "the input was acquired for too short a time");
        }
        let frame = Frame { began_ps: self.frame_began_ps, result: self.converted };
        self.converted = self.channel.map(|channel| (channel, input(channel)));
        self.converting_until_ps = now_ps + self.limits.conversion_ps;
        if self.rises != FRAME_CLOCKS || self.falls != FRAME_CLOCKS {
            self.fault(now_ps, "a frame had not 16 clocks");
            return None;
        }
        let word = self.shifted_in;
        if word & !CHANNEL != THE_BOARDS {
            self.fault(now_ps, "a configuration that the board is not built for");
        }
        self.channel = Some((word >> 7 & 0b111) as usize);
        Some(frame)
    }

    fn fault(&mut self, now_ps: Ps, what: &str) {
        self.faults.push(format!("at {now_ps} ps: {what}"));
    }
}
