//! The verdict on a log, with its reasons.

use serde::{Deserialize, Serialize};

use crate::units::{TemperatureUnit, from_to};

/// Groups for each coefficient, at least: with fewer, a fold held out takes a coefficient's data with it.
pub const MIN_ROWS_A_COEFFICIENT: u64 = 2;

/// A log in which a larger fraction of the rows was dropped gets a warning.
const WARNED_FRACTION: f64 = 1e-3;

/// The coldest that a gyro is tested at is above this, degrees C.
const COLDEST_C: f64 = -100.0;
/// The hottest (oil wells have 175 C) is below this; a chamber's temperatures in kelvin are above it.
const HOTTEST_C: f64 = 200.0;

/// What stands in every sentence about a unit that was guessed.
pub const TAKEN_AS: &str = "names no unit: taken as";

/// What stands in the sentence about a log of one direction.
pub const NO_HYSTERESIS: &str = "the log says nothing of hysteresis";

/// What a fit of a log may do about a narrow range; whoever has no such option leaves it out.
pub const OR_ALLOW_NARROW: &str = ", or allow a narrow one in the fit of a log (`allow_narrow`)";

/// Whether a temperature can be a gyro's in degrees C.
pub(crate) fn is_celsius(temperature: f64) -> bool {
    (COLDEST_C..=HOTTEST_C).contains(&temperature)
}

/// What a log is good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Nothing speaks against it.
    #[default]
    Good,
    /// Fitted, with something to look at.
    Warning,
    /// Not fitted, or fitted only to be looked at: no calibration comes of it.
    Rejected,
}

impl Verdict {
    /// The one word for it, on screens as in JSON and tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Warning => "warning",
            Self::Rejected => "rejected",
        }
    }
}

/// What a verdict rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ReasonKind {
    /// Rejected: the temperature span is too small. A warning where it was allowed.
    NarrowSpan,
    /// Rejected: temperatures that can be no degrees C.
    NotCelsius,
    /// Rejected: the temperature never changes.
    StuckTemperature,
    /// Rejected: fewer rows or groups than the model needs.
    TooFewGroups,
    /// Rejected: no row with both a temperature and a rate.
    NoFiniteRows,
    /// Rejected: the recording ends before its ramp does.
    CutRun,
    /// Rejected: most groups of the span are missing, or their numbers are damaged.
    LostGroups,
    /// Rejected: the reading never changes over a fold of the recording.
    StuckReading,
    /// Rejected: groups far from the curve, too many or too far for noise.
    Outliers,
    /// Rejected: groups at an end of the converter.
    Saturated,
    /// Rejected: the wiper moved during the ramp.
    WiperMoved,
    /// Rejected: the recording has no serial, or another than its file's name.
    WrongSerial,
    /// Rejected: another recording has the same serial.
    DuplicateSerial,
    /// Warning: another recording of a lot holds the same readings.
    Copied,
    /// Warning: rows without a number.
    MissingValues,
    /// Warning: rows far from their neighbours.
    Spikes,
    /// Warning: an interval in which the unit was moved.
    Rotation,
    /// Warning: the rate jumped and stayed, with no change of temperature to match.
    Step,
    /// Warning: the first readings after the start settle towards the others.
    StartUp,
    /// Warning: nothing was logged for a while.
    Gap,
    /// Warning: the temperature stood still for a while though it has noise, or then jumped.
    FrozenTemperature,
    /// Warning: for a while the rate was one number, without its noise.
    StoppedReading,
    /// Warning: the temperature jumped faster than a part can heat, and stayed there.
    TemperatureJump,
    /// Warning: the temperature comes in coarse steps.
    CoarseTemperature,
    /// Warning: the rate comes in steps larger than its noise.
    CoarseRate,
    /// Warning: the file was cut off or is damaged; what is whole of it was read.
    Truncated,
    /// Warning: within the range, temperatures that were not measured.
    Unmeasured,
    /// Warning: some of several logs share hardly a temperature with the others, so that their zeros are not told from the drift.
    LogsApart,
    /// Warning: the same numbers stand in the log twice, rows or columns.
    Repeated,
    /// Warning: the temperature went one way over most of its span, so that hysteresis was not seen.
    OneDirection,
    /// Warning: more is left of an axis than was recorded, about the mean or less a zero at the start: of a verification, or of a
    /// fit's own held-out folds.
    WorseThanUncorrected,
    /// Warning, of a verification: more is left of an axis than twice what the calibration's fit told.
    MoreThanTold,
    /// Warning, of a verification: temperatures that were not measured for the calibration.
    OutsideRange,
    /// Rejected: no sensor of the log is one of those wanted.
    NoSensor,
    /// Warning: nothing says the unit of the rates, or of temperatures hotter than most gyros bear, and one was guessed.
    GuessedUnit,
    /// Warning: the rate jumps and stays, by so little beside its drift that it may be the part's own way: it was left in.
    Jump,
    /// Nothing says a unit, and the one that logs have was assumed: it is told, and speaks against nothing.
    AssumedUnit,
}

impl ReasonKind {
    /// What the kind makes of a log by itself.
    #[must_use]
    pub fn verdict(self) -> Verdict {
        match self {
            Self::NarrowSpan
            | Self::NotCelsius
            | Self::StuckTemperature
            | Self::TooFewGroups
            | Self::NoFiniteRows
            | Self::NoSensor
            | Self::CutRun
            | Self::LostGroups
            | Self::StuckReading
            | Self::Outliers
            | Self::Saturated
            | Self::WiperMoved
            | Self::WrongSerial
            | Self::DuplicateSerial => Verdict::Rejected,
            Self::Copied
            | Self::MissingValues
            | Self::Spikes
            | Self::Rotation
            | Self::Step
            | Self::Jump
            | Self::StartUp
            | Self::Gap
            | Self::FrozenTemperature
            | Self::StoppedReading
            | Self::TemperatureJump
            | Self::CoarseTemperature
            | Self::CoarseRate
            | Self::OneDirection
            | Self::WorseThanUncorrected
            | Self::MoreThanTold
            | Self::OutsideRange
            | Self::Truncated
            | Self::Repeated
            | Self::Unmeasured
            | Self::LogsApart
            | Self::GuessedUnit => Verdict::Warning,
            Self::AssumedUnit => Verdict::Good,
        }
    }
}

/// One reason: its kind for programs, its text for people.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reason {
    /// The kind.
    pub kind: ReasonKind,
    /// A sentence that says what was found, where, and what to do.
    pub text: String,
}

impl Reason {
    /// A reason.
    #[must_use]
    pub fn new(kind: ReasonKind, text: impl Into<String>) -> Self {
        Self { kind, text: text.into() }
    }
}

/// A verdict and all its reasons.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Judgement {
    /// The verdict: the worst of the reasons'.
    pub verdict: Verdict,
    /// The reasons, in the order found.
    pub reasons: Vec<Reason>,
}

impl Judgement {
    /// Adds a reason with the verdict of its kind.
    pub fn add(&mut self, reason: Reason) {
        let verdict = reason.kind.verdict();
        self.add_as(verdict, reason);
    }

    /// Adds a reason that counts as another verdict than its kind's.
    pub fn add_as(&mut self, verdict: Verdict, reason: Reason) {
        self.verdict = self.verdict.max(verdict);
        if !self.reasons.contains(&reason) {
            self.reasons.push(reason);
        }
    }

    /// The judgement on a log whose axes were judged one by one: all reasons; rejected where every axis is, or the log
    /// itself; a warning where one axis is not good.
    #[must_use]
    pub fn of_axes<'a>(log: &Self, axes: impl Iterator<Item = &'a Self> + Clone) -> Self {
        let mut whole = log.clone();
        let best = axes.clone().map(|axis| axis.verdict).min();
        let worst = axes.clone().map(|axis| axis.verdict).max().map(|worst| worst.min(Verdict::Warning));
        whole.verdict = whole.verdict.max(best.unwrap_or_default()).max(worst.unwrap_or_default());
        for reason in axes.flat_map(|axis| &axis.reasons).filter(|reason| !log.reasons.contains(reason)) {
            if !whole.reasons.contains(reason) {
                whole.reasons.push(reason.clone());
            }
        }
        whole
    }

    /// Whether the log was rejected.
    #[must_use]
    pub fn rejected(&self) -> bool {
        self.verdict == Verdict::Rejected
    }

    /// Judges the temperature span of what would be fitted, in the temperature's unit; `allow_narrow` makes a narrow
    /// span a warning, for then the range is written and enforced. A constant temperature is never allowed.
    pub fn span(&mut self, min: f64, max: f64, unit: TemperatureUnit, allow_narrow: bool) {
        let (span, least, name) = (max - min, unit.min_span(), unit.name());
        // A sensor's rounding is no span: a thousandth of what is needed.
        if span < 1e-3 * least {
            let text = format!(
                "the temperature stays at {min:.2} {name}: the log was not warmed, its sensor is stuck, or the wrong column was read"
            );
            self.add(Reason::new(ReasonKind::StuckTemperature, text));
        } else if span < least {
            let verdict = if allow_narrow { Verdict::Warning } else { Verdict::Rejected };
            let advice =
                if allow_narrow { "the calibration holds for this range alone" } else { "record a wider range" };
            let or_allow = if allow_narrow { "" } else { OR_ALLOW_NARROW };
            let text = format!(
                "the temperature spans {span:.1} {name} ({}), less than {least:.0} {name}: {advice}{or_allow}",
                from_to(min, max)
            );
            self.add_as(verdict, Reason::new(ReasonKind::NarrowSpan, text));
        }
    }

    /// Judges whether temperatures can be degrees C.
    pub fn celsius(&mut self, min: f64, max: f64, unit: TemperatureUnit) {
        if unit == TemperatureUnit::C && !(is_celsius(min) && is_celsius(max)) {
            let text = format!(
                "the temperature goes from {min:.0} to {max:.0}, which no gyro sees in degrees C: it is in another unit, or the \
                 wrong column was read"
            );
            self.add(Reason::new(ReasonKind::NotCelsius, text));
        }
    }

    /// Judges whether there are enough rows (each a `noun`: row or group) for so many coefficients.
    pub fn rows(&mut self, axis: &str, rows: u64, noun: &str, coefficients: usize) {
        let least = MIN_ROWS_A_COEFFICIENT * coefficients as u64;
        if rows == 0 {
            let text = format!("{axis}: no row has both a temperature and a rate");
            self.add(Reason::new(ReasonKind::NoFiniteRows, text));
        } else if rows < least {
            let text = format!(
                "{axis}: {rows} {noun}{} cannot settle {coefficients} coefficients ({least} are needed): record for longer, or choose a smaller model",
                if rows == 1 { "" } else { "s" }
            );
            self.add(Reason::new(ReasonKind::TooFewGroups, text));
        }
    }

    /// Warns of rows dropped for one reason when they are more than a thousandth of all.
    pub fn dropped(&mut self, kind: ReasonKind, axis: &str, what: &str, dropped: u64, of: u64) {
        if dropped as f64 > WARNED_FRACTION * of as f64 {
            let text = format!("{axis}: {dropped} of {of} rows were left out: {what}");
            self.add(Reason::new(kind, text));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(min: f64, max: f64, unit: TemperatureUnit, allow_narrow: bool) -> (Verdict, Vec<ReasonKind>) {
        let mut judgement = Judgement::default();
        judgement.span(min, max, unit, allow_narrow);
        (judgement.verdict, judgement.reasons.iter().map(|reason| reason.kind).collect())
    }

    #[test]
    fn a_span_under_ten_degrees_is_rejected_unless_allowed() {
        use ReasonKind::NarrowSpan;
        assert_eq!(span(-17.0, -12.0, TemperatureUnit::C, false), (Verdict::Rejected, vec![NarrowSpan]));
        assert_eq!(span(-17.0, -12.0, TemperatureUnit::C, true), (Verdict::Warning, vec![NarrowSpan]));
        assert_eq!(span(-17.0, -7.0, TemperatureUnit::C, false), (Verdict::Good, vec![]));
        assert_eq!(span(9000.0, 9339.0, TemperatureUnit::Counts, false).0, Verdict::Rejected);
        assert_eq!(span(9000.0, 9340.0, TemperatureUnit::Counts, false).0, Verdict::Good);
    }

    #[test]
    fn a_stuck_temperature_is_rejected_even_where_a_narrow_span_is_allowed() {
        let stuck = (Verdict::Rejected, vec![ReasonKind::StuckTemperature]);
        assert_eq!(span(25.0, 25.0, TemperatureUnit::C, true), stuck);
    }

    #[test]
    fn kelvin_and_the_like_are_not_taken_for_celsius() {
        let judged = |min: f64, max: f64, unit: TemperatureUnit| {
            let mut judgement = Judgement::default();
            judgement.celsius(min, max, unit);
            judgement.verdict
        };
        assert_eq!(judged(-40.0, 175.0, TemperatureUnit::C), Verdict::Good);
        // -40 to 60 C in kelvin, and the paper's chamber in counts.
        assert_eq!(judged(233.15, 333.15, TemperatureUnit::C), Verdict::Rejected);
        assert_eq!(judged(8500.0, 11_900.0, TemperatureUnit::C), Verdict::Rejected);
        assert_eq!(judged(8500.0, 11_900.0, TemperatureUnit::Counts), Verdict::Good);
    }

    #[test]
    fn reasons_are_written_in_kebab_case() {
        let reason = Reason::new(ReasonKind::NarrowSpan, "too narrow");
        assert_eq!(serde_json::to_string(&reason).unwrap(), r#"{"kind":"narrow-span","text":"too narrow"}"#);
        for verdict in [Verdict::Good, Verdict::Warning, Verdict::Rejected] {
            assert_eq!(serde_json::to_value(verdict).unwrap(), verdict.name());
        }
    }

    #[test]
    fn the_verdict_is_the_worst_of_the_reasons() {
        let mut judgement = Judgement::default();
        judgement.dropped(ReasonKind::Spikes, "x", "spikes", 1, 10_000);
        assert_eq!(judgement.verdict, Verdict::Good);
        judgement.dropped(ReasonKind::Spikes, "x", "spikes", 80, 8400);
        assert_eq!(judgement.verdict, Verdict::Warning);
        judgement.rows("x", 7, "group", 4);
        judgement.dropped(ReasonKind::Spikes, "y", "spikes", 80, 8400);
        assert_eq!((judgement.verdict, judgement.reasons.len()), (Verdict::Rejected, 3));
    }
}
