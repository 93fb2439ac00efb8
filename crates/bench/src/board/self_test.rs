//! A board's test of itself: what it was asked, what it gave, and between which limits that had to be.

use serde::Serialize;
use zerorate_core::compensate::Q16;
use zerorate_core::record::DeviceRecord;
use zerorate_core::units::Axis;
use zerorate_core::wire::{CalibrationState, FaultCounts, Health, Request, SampleWindow, TemperatureCheck};

use super::{Board, Mode, Taps};
use crate::client::{ClientError, Group, wording};
use crate::link::LinkError;
use crate::setup::SetUp;

/// Taps by which a wiper is moved, to either side.
const AWAY: u16 = 8;
/// Groups after which readings are judged.
const GROUPS: u32 = 4;
/// A tap may differ by so much of what it should be: the potentiometer's tolerance and the resistors'.
const TAP_TOLERANCE: f64 = 0.1;
/// Recalled, a wiper is within so many taps of where it should be. Gyros warm up meanwhile.
const RECALL_TAPS: f64 = 0.5;
/// At most so much of a stack was ever used, percent.
const STACK_PERCENT: f64 = 75.0;
/// The interrupt takes at most so much of a group's time, percent.
const INTERRUPT_PERCENT: f64 = 10.0;

const POTENTIOMETER: &str = "check the potentiometer's SPI wiring, its supplies and the gyros' circuit";

/// What came of a test.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SelfTest {
    /// The unit's serial.
    pub unit_serial: String,
    /// Whether nothing has failed.
    pub passed: bool,
    /// What was looked at, in this order.
    pub checks: Vec<Check>,
}

/// One thing that was looked at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// Its name.
    pub check: String,
    /// What came out; `None` where it is no number, or was not run.
    pub value: Option<f64>,
    /// The value's unit.
    pub unit: &'static str,
    /// The least that it may be.
    pub least: Option<f64>,
    /// The most that it may be.
    pub most: Option<f64>,
    /// What is thought of it.
    pub verdict: Verdict,
    /// What to do where it has failed, or why it was not run.
    pub remark: Option<String>,
}

/// What is thought of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// It is as it should be.
    Passed,
    /// It is not.
    Failed,
    /// It could not be looked at.
    NotRun,
}

impl Verdict {
    /// In words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::NotRun => "not run",
        }
    }
}

impl Check {
    /// A number between limits.
    fn number(check: impl Into<String>, value: f64, unit: &'static str, limits: [f64; 2], remedy: &str) -> Self {
        let [least, most] = limits.map(Some);
        let check = Self { check: check.into(), value: Some(value), unit, least, most, ..Self::sentence("", None) };
        // NaN is between no limits.
        if value >= limits[0] && value <= limits[1] { check } else { check.failed(remedy) }
    }

    /// A question of yes or no; `fault` says what to do where it is no.
    fn sentence(check: impl Into<String>, fault: Option<&str>) -> Self {
        let passed = Self {
            check: check.into(),
            value: None,
            unit: "",
            least: None,
            most: None,
            verdict: Verdict::Passed,
            remark: None,
        };
        match fault {
            None => passed,
            Some(fault) => passed.failed(fault),
        }
    }

    fn not_run(check: impl Into<String>, why: &str) -> Self {
        Self { verdict: Verdict::NotRun, remark: Some(why.to_owned()), ..Self::sentence(check, None) }
    }

    fn failed(self, remedy: &str) -> Self {
        Self { verdict: Verdict::Failed, remark: Some(remedy.to_owned()), ..self }
    }
}

impl Board {
    /// Has the board test itself, and its circuit by its own readings: the acquisition is started anew, the wipers are moved to
    /// both sides of the middle tap and recalled from the potentiometer's memory. Then modes, taps and acquisition are put
    /// back to how they were met.
    ///
    /// # Errors
    /// [`ClientError`], where the line to the board fails; what the board cannot do is a check that has failed.
    pub fn self_test(&mut self, setup: &SetUp) -> Result<SelfTest, ClientError> {
        self.identity = self.device.identify()?;
        let before = self.faults()?;
        let stored = self.device.read_calibration().unwrap_or_default();
        let record = DeviceRecord::decode(&stored);
        let mut checks = vec![store(self.identity.calibration, stored.len(), record.is_ok())];
        let per_tap = Axis::BOTH.map(|axis| {
            let of_record = record.as_ref().map(|record| Q16(record.axis(axis).law.trim.per_tap).to_counts());
            of_record.unwrap_or_else(|_| setup.nominal_counts_per_tap())
        });
        let port = self.start_anew()?;
        let answers = port.is_none();
        checks.push(Check::sentence("acquisition port: identity, version, settings read back", port));
        let first = if answers { self.judged_group()? } else { None };
        match first {
            Some(group) => {
                checks.push(Check::sentence("sets of samples", None));
                checks.extend(Axis::BOTH.into_iter().flat_map(|axis| readings(&group, axis)));
                // Groups that come while orders wait for theirs are not to be read later.
                self.leave()?;
                self.wipers(setup, per_tap, &mut checks)?;
                // A part that cannot be written has been told of already.
                let _ = unless_refused(self.device.set_taps(self.identity.taps))?;
                self.go_on()?;
            }
            None => {
                let no_sets = "start the board anew; where that does not help check the A/D and the port's clock";
                checks.push(if answers {
                    Check::sentence("sets of samples", Some(no_sets))
                } else {
                    Check::not_run("sets of samples", "the port does not answer")
                });
                let why = "there are no readings to see it by";
                checks.extend(["wipers", "wipers recalled"].map(|check| Check::not_run(check, why)));
            }
        }
        checks.extend(health(&self.device.health()?, self.device.group_period().as_secs_f64()));
        checks.extend(buses(&before, &self.faults()?));
        self.put_back()?;
        let passed = checks.iter().all(|check| check.verdict != Verdict::Failed);
        Ok(SelfTest { unit_serial: self.serial().to_owned(), passed, checks })
    }

    /// Starts the acquisition anew, which takes a port that says who it is and keeps what it is told; what to do where it does
    /// not.
    fn start_anew(&mut self) -> Result<Option<&'static str>, ClientError> {
        self.device.order(Request::SetStream { groups: true, samples: SampleWindow::NONE })?;
        // A port that cannot be stopped cannot be started either.
        let _ = unless_refused(self.device.order(Request::SetAcquisition { run: false }))?;
        let started = unless_refused(self.device.order(Request::SetAcquisition { run: true }))?;
        self.device.discard_groups();
        Ok(started.is_none().then_some("check the SPI wiring to the acquisition port, and that it is of version 2"))
    }

    /// The group by which readings are judged, if it comes: a temperature that stands still is known by its second.
    fn judged_group(&mut self) -> Result<Option<Group>, ClientError> {
        let mut group = None;
        for _ in 0..GROUPS {
            match self.device.next_group() {
                Ok(next) => group = Some(next),
                Err(ClientError::NoGroups | ClientError::Link(LinkError::Silent)) => return Ok(None),
                Err(error) => return Err(error),
            }
        }
        Ok(group)
    }

    /// Moves the wipers to both sides of the middle tap and back, and has the potentiometer recall its own.
    fn wipers(&mut self, setup: &SetUp, per_tap: [f64; 2], checks: &mut Vec<Check>) -> Result<(), ClientError> {
        self.set_mode(&Axis::BOTH, Mode::Off, None)?;
        let middle = setup.middle();
        let [above, below] = [i32::from(AWAY), -i32::from(AWAY)].map(|by| moved(middle, by));
        let mut at = |tap| -> Result<Option<[f64; 2]>, ClientError> {
            match unless_refused(self.device.set_taps([tap; 2]))? {
                Some(_) => self.readings(setup).map(Some),
                None => Ok(None),
            }
        };
        let (middle_counts, above_counts, below_counts) = (at(middle)?, at(above)?, at(below)?);
        let (Some(middle_counts), Some(above_counts), Some(below_counts)) = (middle_counts, above_counts, below_counts)
        else {
            checks
                .push(Check::sentence("wipers", Some("the potentiometer could not be written: check its SPI wiring")));
            checks.push(Check::not_run("wipers recalled", "the wipers cannot be moved"));
            return Ok(());
        };
        for axis in Axis::BOTH {
            let (of, name) = (axis.index(), axis.name().to_uppercase());
            let limits = [1.0 - TAP_TOLERANCE, 1.0 + TAP_TOLERANCE].map(|part| part * per_tap[of]);
            for (side, far) in [("plus", &above_counts), ("minus", &below_counts)] {
                let a_tap = (far[of] - middle_counts[of]).abs() / f64::from(AWAY);
                let rises = (far[of] > middle_counts[of]) == (side == "plus");
                let a_tap = if rises { a_tap } else { -a_tap };
                let check = format!("wiper {name}, {side} {AWAY} taps: a tap");
                checks.push(Check::number(check, a_tap, "counts", limits, POTENTIOMETER));
            }
        }
        let recalled = match unless_refused(self.device.order(Request::RecallPowerUpTap))? {
            Some(_) => self.readings(setup)?,
            None => [f64::NAN; 2],
        };
        let remedy = "the potentiometer does not keep the middle tap: `zerorate device first-time` stores it; where that does not help change the part";
        for axis in Axis::BOTH {
            let of = axis.index();
            let off = (recalled[of] - middle_counts[of]) / per_tap[of];
            let check = format!("wiper {}, recalled from the part's memory: off", axis.name().to_uppercase());
            checks.push(Check::number(check, off, "taps", [-RECALL_TAPS, RECALL_TAPS], remedy));
        }
        Ok(())
    }

    /// The acquisition as it was met.
    fn put_back(&mut self) -> Result<(), ClientError> {
        self.started = !self.identity.running;
        // What does not answer has been told of already.
        unless_refused(self.leave()).map(|_| ())
    }
}

/// A tap so many taps from another, within the part.
fn moved(tap: Taps, by: i32) -> Taps {
    u16::try_from(i32::from(tap.get()) + by).ok().and_then(Taps::new).unwrap_or(tap)
}

/// What was done; `None` where the board would not.
fn unless_refused<T>(done: Result<T, ClientError>) -> Result<Option<T>, ClientError> {
    match done {
        Ok(done) => Ok(Some(done)),
        Err(ClientError::Refused(_)) => Ok(None),
        Err(error) => Err(error),
    }
}

/// The flash, by what it holds.
fn store(state: CalibrationState, bytes: usize, is_whole: bool) -> Check {
    let check = Check::sentence("flash: the stored record, read back", None);
    #[allow(clippy::cast_precision_loss)] // a few kilobytes
    let check = Check { value: Some(bytes as f64), unit: "bytes", ..check };
    match state {
        CalibrationState::Blank => check,
        CalibrationState::InUse if is_whole => check,
        CalibrationState::InUse => check.failed(
            "what is read back is no whole record: deploy it again; where that does not help the flash has failed",
        ),
        other => check.failed(&wording::of_calibration(other)),
    }
}

/// One axis's readings, as the board judges them.
fn readings(group: &Group, axis: Axis) -> [Check; 2] {
    let of = &group.report.axes[axis.index()];
    let name = axis.name().to_uppercase();
    let temperature = match of.temperature {
        TemperatureCheck::Believed | TemperatureCheck::Jumped => None,
        TemperatureCheck::Stuck => Some("it stands still: check the gyro's temperature output and its wire"),
        TemperatureCheck::Saturated => {
            Some("it is at an end of the converter: check the gyro's temperature output and its wire")
        }
    };
    let zro = of
        .saturated
        .then_some("it is at an end of the converter: check that the gyro is plugged in, and the amplifier");
    let number = |what: &str, value: f64, fault: Option<&str>| Check {
        value: Some(value),
        unit: "counts",
        ..Check::sentence(format!("{what} {name}"), fault)
    };
    [number("temperature", of.sums.mean_temperature().0, temperature), number("reading", of.sums.mean_zro().0, zro)]
}

/// What the board knows of its processor.
fn health(health: &Health, group_s: f64) -> [Check; 2] {
    let percent = |part: f64, of: f64| 100.0 * part / of;
    let stack = match health.stack {
        None => Check::not_run("stack used", "the program runs on a stack that is not its own"),
        Some(stack) => Check::number(
            "stack used",
            percent(stack.used.into(), stack.size.into()),
            "%",
            [0.0, STACK_PERCENT],
            "the firmware comes near the end of its stack: give it more memory, or report this",
        ),
    };
    let interrupt = match health.interrupt {
        None => Check::not_run("longest interrupt", "no cycles are counted here"),
        Some(interrupt) => Check::number(
            "longest interrupt, of a group's time",
            percent(f64::from(interrupt.longest_cycles) / f64::from(interrupt.cycles_per_us) / 1e6, group_s),
            "%",
            [0.0, INTERRUPT_PERCENT],
            "something holds up the data-ready interrupt: check the buses' clocks, and stream fewer samples",
        ),
    };
    [stack, interrupt]
}

/// What went wrong on the buses meanwhile.
fn buses(before: &FaultCounts, after: &FaultCounts) -> [Check; 3] {
    let count = |check: &str, count: fn(&FaultCounts) -> u32, remedy: &str| {
        let more = count(after).saturating_sub(count(before));
        Check::number(check, more.into(), "", [0.0, 0.0], remedy)
    };
    [
        count(
            "acquisition errors meanwhile",
            |faults| faults.acquisition_errors,
            "check the SPI wiring to the acquisition port: its length, its ground, its clock",
        ),
        count("trim errors meanwhile", |faults| faults.trim_errors, POTENTIOMETER),
        Check::number(
            "restarts since power came",
            after.restarts.into(),
            "",
            [0.0, 0.0],
            "`zerorate device info` says why it started anew",
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use zerorate_core::wire::{Interrupt, Stack};

    #[test]
    fn a_record_that_is_damaged_or_cannot_be_read_back_fails_with_what_to_do() {
        assert_eq!(store(CalibrationState::Blank, 0, false).verdict, Verdict::Passed, "a new board has none");
        assert_eq!(store(CalibrationState::InUse, 900, true).verdict, Verdict::Passed);
        for (state, says) in [
            (CalibrationState::InUse, "deploy it again"),
            (CalibrationState::OlderInUse, "the last one is damaged"),
            (CalibrationState::Damaged, "deploy it again"),
            (CalibrationState::Unreachable, "flash"),
        ] {
            let found = store(state, 900, false);
            assert_eq!(found.verdict, Verdict::Failed);
            assert!(found.remark.as_ref().unwrap().contains(says), "{found:?}");
        }
    }

    #[test]
    fn a_stack_that_is_nearly_full_and_an_interrupt_that_is_too_long_fail() {
        let of = |used, longest_cycles| Health {
            stack: Some(Stack { size: 1000, used }),
            interrupt: Some(Interrupt { longest_cycles, cycles_per_us: 168 }),
        };
        // A tenth of 1.5 s at 168 MHz is 25.2 million cycles.
        let verdicts = |health_of| health(&health_of, 1.5).map(|check| check.verdict);
        assert_eq!(verdicts(of(750, 25_200_000)), [Verdict::Passed; 2]);
        assert_eq!(verdicts(of(751, 25_200_001)), [Verdict::Failed; 2]);
        assert_eq!(verdicts(Health::default()), [Verdict::NotRun; 2]);
    }

    #[test]
    fn errors_that_are_new_fail_and_old_ones_do_not() {
        let old = FaultCounts { acquisition_errors: 7, trim_errors: 2, ..FaultCounts::default() };
        assert!(buses(&old, &old).iter().all(|check| check.verdict == Verdict::Passed));
        let new = FaultCounts { acquisition_errors: 8, trim_errors: 3, restarts: 1, ..FaultCounts::default() };
        assert!(buses(&old, &new).iter().all(|check| check.verdict == Verdict::Failed));
    }
}
