//! A board's groups as they come, in the units of people.

use std::time::Duration;

use serde::Serialize;
use zerorate_core::drift::Coverage;
use zerorate_core::units::Axis;
use zerorate_core::wire::{Request, SampleWindow, TemperatureCheck};

use super::Board;
use crate::client::{ClientError, Group};
use crate::setup::SetUp;

/// A group.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LiveGroup {
    /// Its number.
    pub group: u32,
    /// Groups lost since the acquisition started, as the board counts them.
    pub lost: u32,
    /// X and Y.
    pub axes: [LiveAxis; 2],
}

/// One axis of a group.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LiveAxis {
    /// `x` or `y`.
    pub axis: &'static str,
    /// Mean temperature reading, counts.
    pub temperature_counts: f64,
    /// The same in degrees C by the set-up's scale: a part's own is some degrees off.
    pub temperature_c: f64,
    /// Mean zero-rate reading, counts.
    pub zro_counts: f64,
    /// Mean of the corrected reading, counts.
    pub corrected_counts: f64,
    /// The corrected reading as a rate: its distance from the centre, degrees a second.
    pub rate_dps: f64,
    /// The tap while the group was taken.
    pub tap: u16,
    /// The tap that was written when it closed, if it changed.
    pub moved_to: Option<u16>,
    /// The mode while it was taken.
    pub mode: &'static str,
    /// What to look at: `below`, `above`, `invalid`, `saturated`, `temperature-stuck`, `temperature-jumped`,
    /// `temperature-saturated`, `trim-failed`.
    pub flags: Vec<&'static str>,
}

impl Board {
    /// Makes the board send its groups; starts the acquisition if it stands still. `true` if it did.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn watch(&mut self) -> Result<bool, ClientError> {
        let running = self.device.identify()?.running;
        self.device.order(Request::SetStream { groups: true, samples: SampleWindow::NONE })?;
        if running {
            return Ok(false);
        }
        self.device.order(Request::SetAcquisition { run: true })?;
        self.started = true;
        Ok(true)
    }

    /// The next group, if it comes in time.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn next_live(&mut self, patience: Duration, setup: &SetUp) -> Result<Option<LiveGroup>, ClientError> {
        Ok(self.device.group_within(patience)?.map(|group| LiveGroup::of(&group, setup)))
    }

    /// Leaves the board as it was found: no stream, and no acquisition that it did not have before.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn leave(&mut self) -> Result<(), ClientError> {
        self.device.order(Request::SetStream { groups: false, samples: SampleWindow::NONE })?;
        if std::mem::take(&mut self.started) {
            self.device.order(Request::SetAcquisition { run: false })?;
        }
        self.device.discard_groups();
        Ok(())
    }
}

impl LiveGroup {
    pub(super) fn of(group: &Group, setup: &SetUp) -> Self {
        let report = &group.report;
        let axes = Axis::BOTH.map(|axis| {
            let of = &report.axes[axis.index()];
            let corrected_counts = of.corrected().0;
            let coverage = match of.coverage {
                Coverage::Inside => None,
                Coverage::Below => Some("below"),
                Coverage::Above => Some("above"),
                // Without a calibration there is no range to be inside of.
                Coverage::Invalid if of.mode == super::Mode::Off => None,
                Coverage::Invalid => Some("invalid"),
            };
            let temperature = match of.temperature {
                TemperatureCheck::Believed => None,
                TemperatureCheck::Stuck => Some("temperature-stuck"),
                TemperatureCheck::Jumped => Some("temperature-jumped"),
                TemperatureCheck::Saturated => Some("temperature-saturated"),
            };
            LiveAxis {
                axis: axis.name(),
                temperature_counts: of.sums.mean_temperature().0,
                temperature_c: setup.celsius(of.sums.mean_temperature()).0,
                zro_counts: of.sums.mean_zro().0,
                corrected_counts,
                rate_dps: (corrected_counts - setup.board.centre_counts) / setup.board.counts_per_dps,
                tap: of.tap.get(),
                moved_to: of.moved_to.map(super::Taps::get),
                mode: of.mode.name(),
                flags: [
                    coverage,
                    of.saturated.then_some("saturated"),
                    temperature,
                    of.trim_failed.then_some("trim-failed"),
                ]
                .into_iter()
                .flatten()
                .collect(),
            }
        });
        Self { group: report.group.0, lost: report.lost, axes }
    }
}
