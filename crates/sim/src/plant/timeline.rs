//! How the plant's time moves: what happens at which instant, and in which order.

use zerorate_core::units::{Axis, Taps};

use super::{Moved, Plant};
use crate::channel::WiperVolts;
use crate::fault::{Bus, Fault};
use crate::truth::{AxisTruth, Sums, Truth};

/// While scanning, temperatures and slow noise move on once this has passed: on the steepest ramp of 2.5 K/min the
/// temperature moves 0.14 count and the reading 0.04 count in it.
const SLOW_STEP_NS: u64 = 100_000_000;

/// In a wait they move on in steps of a second; each step is exact for air on a straight line.
const WAIT_STEP_NS: u64 = 1_000_000_000;

impl Plant {
    pub(crate) fn transfer_fails(&mut self, bus: Bus) -> bool {
        self.faults.break_transfer(bus)
    }

    pub(crate) fn transfer_is_mute(&mut self, bus: Bus) -> bool {
        self.faults.mutes_transfer(bus)
    }

    /// Whether the port is told to scan, and can.
    pub(super) fn port_scans(&self) -> bool {
        self.port.running() && !self.faults.contains(Fault::NoScans)
    }

    pub(crate) fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// The last scan as the A/D sees it, counts: temperature X, zero-rate X, temperature Y, zero-rate Y.
    #[must_use]
    pub fn held(&self) -> [u16; 4] {
        self.held
    }

    /// Lets time pass by whole nanoseconds.
    pub fn pass_ns(&mut self, time_ns: u64) {
        let until_ns = self.now_ns + time_ns;
        while self.port_scans() && self.port_scan_ns <= until_ns {
            _ = self.port_scan();
        }
        if !self.port_scans() && self.block_scan_ns.is_none() {
            while self.slow_ns + WAIT_STEP_NS <= until_ns {
                self.move_slow(self.slow_ns + WAIT_STEP_NS);
            }
            if self.slow_ns + SLOW_STEP_NS <= until_ns {
                self.move_slow(until_ns);
            }
        }
        self.now_ns = until_ns;
    }

    /// After a frame to the potentiometer: wipers that moved do so electrically after the latency.
    pub(crate) fn wipers_written(&mut self) {
        let at_ns = self.now_ns.max(self.scanned_ns + u64::from(self.parameters.wiper_latency_us) * 1000);
        for axis in Axis::BOTH {
            let tap = self.potentiometer.wiper(axis);
            let last = self.moved.iter().rev().find(|moved| moved.axis == axis).map(|moved| moved.tap);
            if tap != last.unwrap_or(self.taps[axis.index()]) {
                self.moved.push(Moved { at_ns, axis, tap });
            }
        }
    }

    /// After a transfer with the port: if it started anew, its first scan is a period away.
    pub(crate) fn port_written(&mut self) {
        if self.port.take_changed() {
            self.sums = Sums::default();
            self.port_scan_ns = self.now_ns + self.port.scan_period_ns();
        }
    }

    pub(super) fn port_scan(&mut self) -> Option<Truth> {
        self.scan(self.port_scan_ns, self.port.scan_period_ns(), self.port.passes());
        let full = self.port.push(self.held);
        self.port_scan_ns += self.port.scan_period_ns();
        let truth = self.truth(full?);
        self.sums = Sums::default();
        Some(truth)
    }

    /// Moves slow things on to a scan, where it is time.
    pub(super) fn slow_up_to(&mut self, at_ns: u64) {
        if at_ns - self.slow_ns >= SLOW_STEP_NS {
            self.move_slow(at_ns);
        }
    }

    /// Moves the low-passes on to each wiper's move up to an instant, and the wiper.
    pub(super) fn move_wipers(&mut self, until_ns: u64) {
        while let Some(moved) = self.moved.first().copied().filter(|moved| moved.at_ns <= until_ns) {
            self.moved.remove(0);
            let dt_s = seconds(moved.at_ns.saturating_sub(self.filtered_ns));
            self.channels.iter_mut().for_each(|channel| channel.filter(dt_s));
            self.filtered_ns = self.filtered_ns.max(moved.at_ns);
            self.taps[moved.axis.index()] = moved.tap;
            self.refresh();
        }
    }

    /// Moves chamber, temperatures and slow noise on to an instant.
    fn move_slow(&mut self, to_ns: u64) {
        let dt_s = seconds(to_ns - self.slow_ns);
        let from_c = self.chamber.air_c();
        self.chamber.advance(dt_s);
        let to_c = self.chamber.air_c();
        self.board.follow(from_c, to_c, self.parameters.board_time_constant_s, dt_s);
        self.converter.warm(self.board.temperature_c);
        for channel in &mut self.channels {
            channel.thermal.advance(from_c, to_c, dt_s);
            channel.gyro.advance(dt_s);
        }
        self.slow_ns = to_ns;
        self.refresh();
    }

    pub(super) fn refresh(&mut self) {
        let board_c = self.board.temperature_c;
        for ((channel, divider), tap) in self.channels.iter_mut().zip(&self.dividers).zip(self.taps) {
            let wiper =
                WiperVolts { actual_v: divider.volts(tap, board_c), middle_v: divider.volts(Taps::MIDDLE, board_c) };
            channel.refresh(wiper, self.input, board_c);
        }
    }

    /// The settled, noise-free reading at a tap, in counts.
    pub(super) fn steady_counts(&self, axis: Axis, tap: Taps) -> f64 {
        let board_c = self.board.temperature_c;
        let wiper_v = self.dividers[axis.index()].volts(tap, board_c);
        self.converter.stepless(self.channels[axis.index()].steady_v(wiper_v, self.input, board_c))
    }

    pub(super) fn truth(&self, set: u32) -> Truth {
        let scans = f64::from(self.sums.scans);
        let axes = Axis::BOTH.map(|axis| {
            let sums = &self.sums.axes[axis.index()];
            let package_c = sums.package_c / scans;
            let [drift, with_wiper, turning] = sums.signals_v.map(|sum| self.converter.stepless(sum / scans));
            AxisTruth {
                temperature_counts: self.converter.stepless(self.channels[axis.index()].sensor_v(package_c)),
                drift_counts: drift,
                wiper_counts: with_wiper - drift,
                rotation_counts: turning - with_wiper,
                package_c,
                die_c: sums.die_c / scans,
            }
        });
        Truth {
            set,
            scans: self.sums.scans,
            chamber_c: self.sums.chamber_c / scans,
            chamber_set_c: self.chamber.set_point_c(),
            axes,
        }
    }
}

#[allow(clippy::cast_precision_loss)] // 2^53 ns are a hundred days.
pub(super) fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}
