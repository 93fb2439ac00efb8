//! The board around the block: its clock, its A/D, and what disturbs them.

use std::collections::VecDeque;
use std::fmt;

use crate::Ps;
use crate::ad7949::{Ad7949, Frame, Limits};
use crate::model::{Inputs, Model, Outputs, Scale};

/// Half a period of 24 MHz.
const HALF_CLOCK_PS: Ps = 20_833;

/// Frames of a pass: four channels through a pipeline of two.
const FRAMES: usize = 6;

/// One conversion of each channel, as the A/D delivered them: a pass. Without oversampling it is a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scan {
    /// When its first frame began.
    pub began_ps: Ps,
    /// Temperature X, zero-rate X, temperature Y, zero-rate Y.
    pub samples: [u16; 4],
}

/// Something that comes from outside at an arbitrary moment, and goes again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Disturbance {
    /// The reset is pressed.
    Reset,
    /// SCK is inverted.
    Sck,
    /// Chip select is inverted.
    ChipSelect,
    /// MOSI is inverted.
    Mosi,
}

/// The board.
pub struct Bench {
    model: Model,
    scale: Scale,
    now_ps: Ps,
    next_edge_ps: Ps,
    /// What the board drives, disturbances left out.
    driven: Inputs,
    outputs: Outputs,
    disturbed: [bool; 4],
    /// Beginnings and ends to come, in order.
    disturbances: VecDeque<(Ps, Disturbance, bool)>,
    converter: Ad7949,
    input: Box<dyn FnMut(usize) -> u16>,
    /// What is to happen as a pass begins, and when the last did.
    hold: Box<dyn FnMut()>,
    pass_began_ps: Option<Ps>,
    frames: Vec<Frame>,
    scans: Vec<Scan>,
    scans_count_from_ps: Ps,
    scan_ready_rises: u32,
}

impl Bench {
    /// A board after its reset. `input` gives the counts of an A/D input each time it is converted.
    #[must_use]
    pub fn new(scale: Scale, seed: u32, input: impl FnMut(usize) -> u16 + 'static) -> Self {
        Self::of(Model::new(scale, seed, true), scale, seed, Box::new(input))
    }

    /// The same for a master that breaks the port's rules, which is what the RTL's assertions are for.
    #[must_use]
    pub fn without_assertions(scale: Scale, seed: u32, input: impl FnMut(usize) -> u16 + 'static) -> Self {
        Self::of(Model::new(scale, seed, false), scale, seed, Box::new(input))
    }

    fn of(mut model: Model, scale: Scale, seed: u32, input: Box<dyn FnMut(usize) -> u16>) -> Self {
        let driven = Inputs { clk: false, rst_n: false, spi_sck: false, spi_csn: true, spi_mosi: false, adc_sdo: true };
        // In silicon chip select's level resets the SPI slave; to a simulator it is the edge that does.
        model.eval(Inputs { spi_csn: false, ..driven });
        let outputs = model.eval(driven);
        let limits = if scale == Scale::Board { Limits::DATA_SHEET } else { Limits::NONE };
        let mut bench = Self {
            model,
            scale,
            now_ps: 0,
            // The clock's phase against a master that starts at round times.
            next_edge_ps: u64::from(seed) * 7919 % (2 * HALF_CLOCK_PS),
            driven,
            outputs,
            disturbed: [false; 4],
            disturbances: VecDeque::new(),
            converter: Ad7949::new(limits),
            input,
            hold: Box::new(|| ()),
            pass_began_ps: None,
            frames: Vec::new(),
            scans: Vec::new(),
            scans_count_from_ps: 0,
            scan_ready_rises: 0,
        };
        bench.pass(10 * 2 * HALF_CLOCK_PS);
        bench.driven.rst_n = true;
        bench.pass(10 * 2 * HALF_CLOCK_PS);
        bench
    }

    /// Has this done whenever a pass begins, before any of its conversions: for a simulated board that moves on from pass
    /// to pass.
    pub fn at_each_pass(&mut self, hold: impl FnMut() + 'static) {
        self.hold = Box::new(hold);
    }

    /// The time.
    #[must_use]
    pub fn now_ps(&self) -> Ps {
        self.now_ps
    }

    /// So many microseconds of SCAN_PERIOD take this long.
    #[must_use]
    pub fn period_ps(&self, microseconds: u64) -> Ps {
        microseconds * self.scale.clocks_per_us() * 2 * HALF_CLOCK_PS
    }

    /// Lets time pass.
    pub fn pass(&mut self, ps: Ps) {
        let until_ps = self.now_ps + ps;
        loop {
            let disturbance_ps = self.disturbances.front().map_or(Ps::MAX, |&(at_ps, ..)| at_ps);
            let next_ps = self.next_edge_ps.min(disturbance_ps);
            if next_ps > until_ps {
                break;
            }
            self.now_ps = self.now_ps.max(next_ps);
            if disturbance_ps <= self.next_edge_ps {
                if let Some((_, what, begins)) = self.disturbances.pop_front() {
                    self.disturbed[what as usize] = begins;
                }
                self.settle();
            } else {
                self.next_edge_ps += HALF_CLOCK_PS;
                self.driven.clk = !self.driven.clk;
                self.settle();
            }
        }
        self.now_ps = until_ps;
    }

    /// Lets something come in a while, and go after another.
    pub fn disturb(&mut self, what: Disturbance, in_ps: Ps, for_ps: Ps) {
        let begins_ps = self.now_ps + in_ps;
        self.disturbances.push_back((begins_ps, what, true));
        self.disturbances.push_back((begins_ps + for_ps, what, false));
        self.disturbances.make_contiguous().sort_by_key(|&(at_ps, ..)| at_ps);
    }

    /// Drives chip select (low is selected), SCK and MOSI.
    pub fn drive_spi(&mut self, csn: bool, sck: bool, mosi: bool) {
        (self.driven.spi_csn, self.driven.spi_sck, self.driven.spi_mosi) = (csn, sck, mosi);
        self.settle();
    }

    /// MISO's level.
    #[must_use]
    pub fn miso(&self) -> bool {
        self.outputs.spi_miso
    }

    /// The data ready line.
    #[must_use]
    pub fn data_ready(&self) -> bool {
        self.outputs.data_ready
    }

    /// The scan ready line.
    #[must_use]
    pub fn scan_ready(&self) -> bool {
        self.outputs.scan_ready
    }

    /// How often it has risen since the last [`Self::count_scans`].
    #[must_use]
    pub fn scan_ready_rises(&self) -> u32 {
        self.scan_ready_rises
    }

    /// The passes that the A/D has delivered, those that began before the last [`Self::count_scans`] left out.
    #[must_use]
    pub fn scans(&self) -> &[Scan] {
        &self.scans
    }

    /// Forgets the scans so far, the one under way included.
    pub fn count_scans(&mut self) {
        self.scans.clear();
        self.scan_ready_rises = 0;
        self.scans_count_from_ps = self.now_ps;
    }

    /// What the block did to the A/D that its data sheet forbids.
    #[must_use]
    pub fn converter_faults(&self) -> &[String] {
        &self.converter.faults
    }

    /// Forgets those; a reset in the middle of a frame makes some.
    pub fn forget_converter_faults(&mut self) {
        self.converter.faults.clear();
    }

    fn settle(&mut self) {
        let [reset, sck, csn, mosi] = self.disturbed;
        let mut inputs = self.driven;
        inputs.rst_n &= !reset;
        inputs.spi_sck ^= sck;
        inputs.spi_csn ^= csn;
        inputs.spi_mosi ^= mosi;
        let outputs = self.model.eval(inputs);
        let converter_pins = |outputs: &Outputs| (outputs.adc_cnv, outputs.adc_sck, outputs.adc_din);
        if converter_pins(&outputs) != converter_pins(&self.outputs) {
            let (cnv, sck, din) = converter_pins(&outputs);
            if self.outputs.adc_cnv && !cnv {
                self.note_fall();
            }
            let frame = self.converter.pins(self.now_ps, cnv, sck, din, &mut self.input);
            self.driven.adc_sdo = self.converter.sdo();
            if let Some(frame) = frame {
                self.note(frame);
            }
        }
        self.scan_ready_rises += u32::from(outputs.scan_ready && !self.outputs.scan_ready);
        self.outputs = outputs;
    }

    /// CNV falls: with the first frame of a pass, a pass begins.
    fn note_fall(&mut self) {
        // A pass takes 38 us on the board and 74 of the fast scale's, and the next one begins after 100 at least.
        let is_over = |began_ps: Ps| self.now_ps - began_ps >= self.period_ps(80);
        if self.pass_began_ps.is_none_or(is_over) {
            self.pass_began_ps = Some(self.now_ps);
            self.frames.clear();
            (self.hold)();
        }
    }

    /// Puts the frames of a pass together.
    fn note(&mut self, frame: Frame) {
        self.frames.push(frame);
        if self.frames.len() < FRAMES {
            return;
        }
        let mut samples = [0; 4];
        for (channel, frame) in self.frames[2..].iter().enumerate() {
            match frame.result {
                Some((of, counts)) if of == channel => samples[channel] = counts,
                other => self.converter.faults.push(format!("channel {channel}'s frame brought {other:?}")),
            }
        }
        let began_ps = self.frames[0].began_ps;
        self.frames.clear();
        if began_ps >= self.scans_count_from_ps {
            self.scans.push(Scan { began_ps, samples });
        }
    }
}

impl fmt::Debug for Bench {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bench").field("scale", &self.scale).field("now_ps", &self.now_ps).finish_non_exhaustive()
    }
}
