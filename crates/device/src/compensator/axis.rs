//! One axis at work: its law, and what is known of its temperature and its wiper.

use zerorate_core::compensate::{AxisCompensation, AxisLaw, GroupOutcome, Mode};
use zerorate_core::drift::{Coverage, Knowledge};
use zerorate_core::group::GroupSums;
use zerorate_core::units::{Axis, Taps};
use zerorate_core::wire::{AxisReport, FaultCounts, Refusal, ScanFlags, TemperatureCheck};

use super::temperature::{self, Checked, TemperatureWatch};
use crate::trim_part::TrimPart;

/// An axis, with a law or without: what asks for the law takes it beside.
pub(super) struct AxisAtWork {
    axis: Axis,
    pub(super) state: AxisCompensation,
    pub(super) temperature: TemperatureWatch,
    /// The wiper stands where the part's own memory has it, and is left there.
    recalled: bool,
    /// What the last group said of the temperature that corrects the samples after it.
    of_group: ScanFlags,
}

impl AxisAtWork {
    /// An axis without a law, its wiper left where it stands.
    pub(super) fn new(axis: Axis, tap: Taps) -> Self {
        let state = AxisCompensation::new(None, tap);
        Self { axis, state, temperature: TemperatureWatch::default(), recalled: false, of_group: ScanFlags::default() }
    }

    /// Takes a law into use, keeping mode and tap.
    pub(super) fn install(&mut self, law: &AxisLaw) {
        let mode = self.state.mode();
        self.state = AxisCompensation::new(Some(law), self.state.tap());
        self.state.set_mode(mode);
    }

    pub(super) fn set_mode(&mut self, mode: Mode, law: Option<&AxisLaw>) -> Result<(), Refusal> {
        match law {
            None if mode != Mode::Off => return Err(Refusal::NoCalibration),
            Some(law) if mode.moves_wiper() && !law.moves_wiper() => return Err(Refusal::NoEdges),
            _ => self.state.set_mode(mode),
        }
        self.recalled = false;
        Ok(())
    }

    pub(super) fn write(
        &mut self,
        part: &mut impl TrimPart,
        tap: Taps,
        law: Option<&AxisLaw>,
        faults: &mut FaultCounts,
    ) -> Result<(), Refusal> {
        if part.write(self.axis, tap).is_err() {
            faults.trim_errors += 1;
            return Err(Refusal::TrimPartFailed);
        }
        self.recalled = false;
        if tap != self.state.tap() {
            self.state.wiper_written(law, tap);
        }
        Ok(())
    }

    /// The part has moved its wiper to where its memory has it: that is looked at bare, with the axis off.
    pub(super) fn recall(&mut self) {
        self.state.set_mode(Mode::Off);
        self.recalled = true;
    }

    /// What is to be thought of a sample, but for what the sample itself says.
    pub(super) fn flags(&self, has_law: bool) -> ScanFlags {
        let mode = self.state.mode();
        let at_work = mode != Mode::Off && has_law && self.state.has_begun();
        ScanFlags::of(mode).with(ScanFlags::AT_WORK, at_work).and(self.of_group)
    }

    /// Groups of so many samples were lost: their time passes all the same.
    pub(super) fn lose(&mut self, groups: u32, n: u32) {
        self.state.skip_lost(groups.saturating_mul(n));
        self.state.lose_groups(groups);
    }

    /// Closes a group whose temperature was checked: law, then wiper. `reach` is how far readings go.
    pub(super) fn close(
        &mut self,
        sums: GroupSums,
        (temperature, code): Checked,
        reach: [u16; 2],
        law: Option<&AxisLaw>,
        part: &mut impl TrimPart,
        faults: &mut FaultCounts,
    ) -> AxisReport {
        self.state.skip_samples(sums.n);
        let (tap, mode) = (self.state.tap(), self.state.mode());
        let outcome = self.state.close_group_at(law, &sums, code);
        // Written with every group, moved or not: where the wiper stands nobody knows after a write that failed, or after a
        // dip of the analogue supply, which puts it back to its tap of power-up. A write that fails leaves the shadow as it
        // was; the law asks again with the next group.
        let written =
            if self.recalled { Ok(()) } else { self.write(part, outcome.move_to.unwrap_or(tap), law, faults) };
        self.of_group = of_group(temperature, &outcome);
        let saturated = sums.is_saturated(reach);
        temperature::count(temperature, faults);
        faults.saturated += u32::from(saturated);
        faults.out_of_range += u32::from(matches!(outcome.coverage, Coverage::Below | Coverage::Above));
        AxisReport {
            sums,
            tap,
            mode,
            corrected_q16: outcome.corrected.0,
            coverage: outcome.coverage,
            saturated,
            moved_to: outcome.move_to.filter(|_| written.is_ok()),
            temperature,
            trim_failed: written.is_err(),
        }
    }
}

fn of_group(temperature: TemperatureCheck, outcome: &GroupOutcome) -> ScanFlags {
    ScanFlags::default()
        .with(ScanFlags::HELD, temperature != TemperatureCheck::Believed)
        .with(ScanFlags::OUTSIDE, matches!(outcome.coverage, Coverage::Below | Coverage::Above))
        .with(ScanFlags::UNCERTAIN, outcome.knowledge == Knowledge::Uncertain)
}
