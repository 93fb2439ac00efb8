//! The passes of a scan: what the four inputs are at each, and the samples that they make.

use zerorate_core::units::Axis;

use super::{Plant, timeline};
use crate::fault::Fault;
use crate::oversampling::{Pass, mean};

impl Plant {
    /// Goes to the next pass of a scan of so many, numbered from 1, when something else than the port here drives the A/D: its
    /// inputs are held until the pass after it. The scans are [`crate::PlantParameters::direct_scan_period_us`] apart; the port
    /// must not run.
    ///
    /// What is drawn for a pass is the port's own, so whoever converts sees the same from the same seed.
    pub fn next_pass(&mut self, number: u32, of: u32) {
        let period_ns = u64::from(self.parameters.direct_scan_period_us) * 1000;
        let scan_ns = match (self.block_scan_ns, self.scanned_ns + period_ns) {
            (Some(scan_ns), _) => scan_ns,
            (None, missed_ns) if missed_ns < self.now_ns => self.now_ns + period_ns,
            (None, scan_ns) => scan_ns,
        };
        let pass = Pass { number, of, scan_ns, period_ns };
        self.pass(pass);
        if pass.is_last() {
            self.block_scan_ns = self.block_scan_ns.map(|scan_ns| scan_ns + period_ns);
        }
    }

    /// A block outside of the plant, with a clock of its own, starts to scan through [`Self::next_pass`]: its first scan is a
    /// period from now and the others are on its grid, however long a set takes to be read meanwhile.
    pub fn block_starts(&mut self) {
        self.block_scan_ns = Some(self.now_ns + u64::from(self.parameters.direct_scan_period_us) * 1000);
    }

    /// It stands still.
    pub fn block_stops(&mut self) {
        self.block_scan_ns = None;
    }

    /// Takes a scan of so many passes, and holds its samples.
    pub(super) fn scan(&mut self, scan_ns: u64, period_ns: u64, of: u32) {
        let mut sums = [0; 4];
        for number in 1..=of {
            self.pass(Pass { number, of, scan_ns, period_ns });
            sums.iter_mut().zip(self.held).for_each(|(sum, counts)| *sum += u32::from(counts));
        }
        self.held = sums.map(|sum| mean(sum, of));
    }

    /// Holds the four inputs at a pass.
    fn pass(&mut self, pass: Pass) {
        let at_ns = pass.at_ns();
        if pass.is_first() {
            self.begin_scan(pass.scan_ns);
        }
        self.move_wipers(at_ns);
        let (dt_s, at_s) = (timeline::seconds(at_ns - self.filtered_ns), timeline::seconds(at_ns));
        let share = 1.0 / f64::from(pass.of);
        for ((channel, sums), (held, noise_free_v)) in self
            .channels
            .iter_mut()
            .zip(&mut self.sums.axes)
            .zip(self.held.chunks_exact_mut(2).zip(&mut self.noise_free_v))
        {
            let [temperature_v, zero_rate_v] = channel.pass(dt_s, at_s, pass);
            let signals_v = channel.filtered_v();
            sums.signals_v.iter_mut().zip(signals_v).for_each(|(sum, volts)| *sum += volts * share);
            let [.., turning_v] = signals_v;
            *noise_free_v = if pass.is_first() { 0.0 } else { *noise_free_v } + turning_v * share;
            if self.faults.contains(Fault::FrozenTemperature(channel.axis)) {
                held[0] ^= 1;
            } else if !self.faults.contains(Fault::StuckTemperature(channel.axis)) {
                held[0] = self.converter.convert(temperature_v);
            }
            if !self.faults.is_empty() {
                held[0] = self.faults.temperature(channel.axis, held[0]);
            }
            held[1] = if self.faults.contains(Fault::SaturatedInput(channel.axis)) {
                self.converter.convert(channel.high_rail_v())
            } else {
                self.converter.convert(zero_rate_v)
            };
        }
        self.filtered_ns = at_ns;
        if pass.is_last() {
            self.now_ns = self.now_ns.max(at_ns);
            self.scanned_ns = at_ns;
        }
    }

    /// Before a scan's first pass: all that moves with whole scans.
    fn begin_scan(&mut self, scan_ns: u64) {
        self.slow_up_to(scan_ns);
        let scan_dt_s = timeline::seconds(scan_ns - self.scanned_ns);
        self.sums.scans += 1;
        self.sums.chamber_c += self.chamber.air_c();
        for axis in Axis::BOTH.map(Axis::index) {
            let (channel, sums) = (&mut self.channels[axis], &mut self.sums.axes[axis]);
            channel.draw(scan_dt_s);
            sums.package_c += channel.thermal.package_c();
            sums.die_c += channel.thermal.die_c();
        }
    }
}
