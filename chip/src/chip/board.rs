//! The board about the chip: the parts on its pins, on the plant's time.

use zerorate_sim::{Pins, PortSpi, PotentiometerSpi, SPI_BYTE_NS, SharedPlant};

use super::time::{NEVER, Ticks, nanoseconds, ticks_of_ns};

/// The two buses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bus {
    /// SPI1: the acquisition port.
    Port,
    /// SPI2: the potentiometer.
    Potentiometer,
}

/// A chip select of the port that goes high by itself, at any bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cut {
    /// Clocks of the port's bus before it.
    pub after: u32,
    /// Clocks for which it stays high; `None`: until the program selects the port anew.
    pub lasts: Option<u32>,
}

/// Sums of scans as the A/D gave them, of the four channels in the order of the burst.
pub type Sums = [u64; 4];

/// Nanoseconds from scan to scan.
pub const SCAN_NS: u64 = 3_000_000;

/// The plant's parts as the chip's pins reach them.
pub struct Board {
    /// The plant.
    pub plant: SharedPlant,
    port: Pins,
    potentiometer: Pins,
    /// The plant's time stands and is moved by somebody else, but for what the program does that takes time on the native board
    /// as well: bytes on the buses and delays.
    pub plant_stands: bool,
    data_ready: bool,
    /// When data ready last rose: the set's last scan.
    pub ready_at: Ticks,
    /// How often it has risen.
    pub sets: u32,
    /// The sums of the scans since the port's start up to each of them, without the port; zeros first.
    sums: Vec<Sums>,
    /// The line scan ready is connected. It costs the emulator more than all else, and most cases do not look at it.
    pub scan_ready_connected: bool,
    /// Where it is: the scans since the port's start, and when each was there.
    pub scanned: Vec<(Ticks, [u16; 4])>,
    /// Scans whose edges the chip has not seen.
    edges: u32,
    /// Scans that came at another time than a period after the one before, and a start's first.
    pub odd_scans: u32,
    expected_ns: Option<u64>,
    /// A cut to come, or under way.
    pub cut: Option<Cut>,
    /// Clocks of the port's bus before a bit of its answer that is bent; 0: none is.
    pub bend_after: u32,
    /// Cuts that have happened.
    pub cuts: u32,
    /// Frames that the port was sent.
    pub asked: u32,
    clocked: u32,
    /// From the last scan of a set to each frame for the potentiometer, when its chip select rose.
    pub written_after: Vec<Ticks>,
    /// Selections during which nothing was clocked.
    pub empty_frames: u32,
}

impl Board {
    /// The board about a plant, whose time goes on from where it is.
    pub fn new(plant: &SharedPlant) -> Self {
        Self {
            plant: SharedPlant::clone(plant),
            port: PortSpi::new(plant).pins(),
            potentiometer: PotentiometerSpi::new(plant).pins(),
            plant_stands: false,
            data_ready: false,
            ready_at: 0,
            sets: 0,
            sums: vec![[0; 4]],
            scan_ready_connected: false,
            scanned: Vec::new(),
            edges: 0,
            odd_scans: 0,
            expected_ns: None,
            cut: None,
            bend_after: 0,
            cuts: 0,
            asked: 0,
            clocked: 0,
            written_after: Vec::new(),
            empty_frames: 0,
        }
    }

    /// Lets the plant's time pass; whether data ready has risen or fallen.
    pub fn pass(&mut self, now: Ticks) -> Option<bool> {
        if !self.plant_stands {
            self.pass_ns(nanoseconds(now));
        }
        let level = self.plant.borrow().data_ready();
        if level == self.data_ready {
            return None;
        }
        self.data_ready = level;
        if level {
            (self.ready_at, self.sets) = (now, self.sets + 1);
        }
        Some(level)
    }

    fn pass_ns(&mut self, until_ns: u64) {
        let plant = SharedPlant::clone(&self.plant);
        let mut plant = plant.borrow_mut();
        loop {
            let next_ns = plant.next_scan_ns();
            if next_ns != self.expected_ns {
                // The port was started or stopped: it begins a new set.
                self.sums.truncate(1);
                self.scanned.clear();
                self.expected_ns = next_ns;
                self.odd_scans += 1;
            }
            let Some(scan_ns) = next_ns.filter(|&ns| ns <= until_ns) else { break };
            plant.pass_until_ns(scan_ns);
            self.scanned(plant.held(), ticks_of_ns(scan_ns));
            self.expected_ns = Some(scan_ns + SCAN_NS);
        }
        plant.pass_until_ns(until_ns);
    }

    /// A scan was taken.
    fn scanned(&mut self, held: [u16; 4], at: Ticks) {
        let mut sums = self.sums.last().copied().unwrap_or_default();
        sums.iter_mut().zip(held).for_each(|(sum, sample)| *sum += u64::from(sample));
        self.sums.push(sums);
        if self.scan_ready_connected {
            self.scanned.push((at, held));
            self.edges += 1;
        }
    }

    /// Whether the line scan ready has fallen and risen since this was last asked.
    pub const fn scan_came(&mut self) -> bool {
        std::mem::replace(&mut self.edges, 0) > 0
    }

    /// Scans since the port's start.
    pub const fn scans(&self) -> usize {
        self.sums.len() - 1
    }

    /// The scan after the last of `n` that follow one another, begin at `from` or later, and have these sums; none where the
    /// A/D gave no such scans.
    pub fn end_of(&self, n: usize, sums: Sums, from: usize) -> Option<usize> {
        (from + n..self.sums.len()).find(|&end| {
            let (before, after) = (self.sums[end - n], self.sums[end]);
            (0..4).all(|channel| after[channel] - before[channel] == sums[channel])
        })
    }

    /// When the plant next does something by itself.
    pub fn due(&self) -> Ticks {
        if self.plant_stands {
            return NEVER;
        }
        self.plant.borrow().next_scan_ns().map_or(NEVER, ticks_of_ns)
    }

    /// The chip's chip select goes low.
    pub fn select(&mut self, bus: Bus) {
        self.clocked = 0;
        self.asked += u32::from(bus == Bus::Port);
        if bus == Bus::Port && self.cut.is_some_and(|cut| cut.after == 0 && cut.lasts.is_none()) {
            self.cut = None;
        }
        self.pins(bus).select();
    }

    /// What takes so long was done; where the plant's time does not stand it has passed.
    pub fn took_ns(&mut self, ns: u64) {
        if self.plant_stands {
            self.plant.borrow_mut().pass_ns(ns);
        }
    }

    /// A byte is clocked.
    pub fn exchange(&mut self, bus: Bus, byte: u8) -> u8 {
        self.clocked += 1;
        self.took_ns(SPI_BYTE_NS);
        (0..8).rev().fold(0, |answer, place| {
            if bus == Bus::Port {
                self.disturb();
            }
            let bit = self.pins(bus).clock(byte >> place & 1 == 1);
            answer << 1 | u8::from(bit != (bus == Bus::Port && self.is_bent()))
        })
    }

    /// The chip's chip select goes high.
    pub fn deselect(&mut self, bus: Bus, now: Ticks) {
        if self.clocked == 0 {
            self.empty_frames += 1;
        } else if bus == Bus::Potentiometer {
            self.written_after.push(now - self.ready_at);
        }
        self.pins(bus).deselect();
    }

    const fn pins(&mut self, bus: Bus) -> &mut Pins {
        match bus {
            Bus::Port => &mut self.port,
            Bus::Potentiometer => &mut self.potentiometer,
        }
    }

    /// Whether a bit of the port's answer is the one that is bent.
    const fn is_bent(&mut self) -> bool {
        let is_it = self.bend_after == 1;
        self.bend_after = self.bend_after.saturating_sub(1);
        is_it
    }

    /// Chip select goes high and low by itself, where it is to, before a bit of the port's.
    fn disturb(&mut self) {
        let Some(cut) = &mut self.cut else { return };
        if cut.after > 0 {
            cut.after -= 1;
            if cut.after == 0 {
                self.port.deselect();
                self.cuts += 1;
            }
            return;
        }
        let Some(lasts) = &mut cut.lasts else { return };
        *lasts = lasts.saturating_sub(1);
        if *lasts == 0 {
            self.port.select();
            self.cut = None;
        }
    }
}
