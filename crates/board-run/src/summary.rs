//! A run in numbers: `summary.json`, for scripts and for the run's page.
//!
//! Figures known on a simulated bench alone are left out on a real one. A field may be added within a schema; none is
//! taken away or given another meaning.

use std::collections::BTreeMap;
use std::io;
use std::time::SystemTime;

use chrono::{DateTime, SecondsFormat, Utc};
use serde::{Deserialize, Serialize};
use thiserror::Error;
use zerorate_core::compensate::Mode;
use zerorate_core::units::Axis;

use zerorate_cal::calibration::Origin;
use zerorate_cal::quality::Verdict;
use zerorate_recording::Phase;
use zerorate_source::{Faulty, Source, in_quotes};

/// The version of the summary's form.
pub const SCHEMA: u32 = 2;

/// The oldest version that is read: its checks have `pass` for `passed`.
const OLDEST_SCHEMA: u32 = 1;

/// A test with more of its groups outside of the temperatures that were fitted is told. A ramp is sent to where the first was,
/// and a gyro that is still settling is a little beyond its end for a twentieth of the way back.
const FEW_OUTSIDE: f64 = 0.05;
/// Less than a twentieth of a change is told as none.
const SAME: f64 = 0.05;
/// A ramp that covers less of the temperatures asked for was cut short: in an hour a gyro's inside follows nine tenths of the
/// chamber's way.
const MOST_OF_THE_RAMP: f64 = 0.8;

/// The run in numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The simulated plant's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plant: Option<String>,
    /// The simulated plant's seed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// The unit's serial.
    pub serial: String,
    /// Good; a warning where a compensation made its axis worse in a test, where a test left the temperatures that were
    /// fitted or the ramp was cut short; rejected where a check was not passed.
    pub verdict: Verdict,
    /// When the run began, or went on after it was stopped: RFC 3339, to the second ([`stamp`]). `None` of a simulated run, which is the same
    /// whenever it is made, and of one by an older version.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub started: Option<String>,
    /// How long the run took by the wall clock, seconds.
    pub wall_s: f64,
    /// The trim part of the board, as `max5494`.
    pub trim_part: String,
    /// Counts in one deg/s; negative where the reading falls with the rate.
    pub counts_per_dps: f64,
    /// The axes by name, `x` and `y`.
    pub axes: BTreeMap<String, AxisSummary>,
    /// The compensation tests: X heating, X cooling, then Y heating, each by trim and hybrid.
    pub tests: Vec<TestResult>,
    /// What was checked.
    pub checks: Vec<Check>,
    /// The recordings of the run, by which its files are told from another run's.
    pub recordings: Vec<Origin>,
    /// The traditional test; `None` where it was left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub soaks: Option<Soaks>,
    /// What was outside its limit, a sentence each.
    pub failed_checks: Vec<String>,
    /// What to look at, a sentence each.
    pub warnings: Vec<String>,
}

/// A time as a summary has it.
#[must_use]
pub fn stamp(time: SystemTime) -> String {
    DateTime::<Utc>::from(time).to_rfc3339_opts(SecondsFormat::Secs, true)
}

/// One axis in numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisSummary {
    /// The drift model, as `poly:2`.
    pub model: String,
    /// The drift's coefficients in temperature counts, constant first, counts; a table's knots.
    pub drift_raw_coefficients: Vec<f64>,
    /// Zero-rate output over the heating ramp's hour, without compensation, peak to peak.
    pub drift_pp_counts: f64,
    /// V0: mean of the trimmed readings (eq. 4).
    pub v0_counts: f64,
    /// a, each point against its own trimmed reading.
    pub trim_slope_taps_per_count: f64,
    /// b, the same.
    pub trim_intercept_taps: f64,
    /// a by the paper's formula (eq. 2 to 4).
    pub paper_trim_slope_taps_per_count: f64,
    /// b by the paper's formula.
    pub paper_trim_intercept_taps: f64,
    /// The plant's own slope over the taps that the experiment used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plant_slope_taps_per_count: Option<f64>,
    /// The least and greatest temperature fitted, counts.
    pub temperature_counts: [f64; 2],
    /// The least and greatest temperature of the heating ramp, over which the drift's peak to peak is told, counts. `None` of a
    /// run by an older version.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heating_temperature_counts: Option<[f64; 2]>,
    /// How much of the way from the set-up's cold to its hot end the ramp measured, by the set-up's scale: 1 for all of it.
    /// `None` of a run by an older version.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_of_asked_range: Option<f64>,
    /// The largest distance of the fitted curve from the plant's deterministic curve of this run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curve_error_counts: Option<f64>,
    /// Residual of the fit, rms, in-sample.
    pub fit_rms_counts: f64,
    /// Residual of the fit, peak to peak, in-sample.
    pub fit_pp_counts: f64,
    /// Residual of the folds, each predicted by the fit of the others, rms; `None` where they do not settle the model.
    pub held_out_rms_counts: Option<f64>,
    /// The same, peak to peak.
    pub held_out_pp_counts: Option<f64>,
}

/// One direction of a compensation test. All figures are of group means over the hour of the ramp, on a run that no
/// model has seen: held out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TestResult {
    /// How the axis was compensated.
    #[serde(with = "zerorate_recording::named")]
    pub mode: Mode,
    /// The compensated axis.
    #[serde(with = "zerorate_recording::named")]
    pub axis: Axis,
    /// The axis left alone.
    #[serde(with = "zerorate_recording::named")]
    pub control: Axis,
    /// Heating or cooling.
    #[serde(with = "zerorate_recording::named")]
    pub direction: Phase,
    /// What is left on the compensated axis, counts peak to peak.
    pub residual_pp_counts: f64,
    /// The same, rms about its mean.
    pub residual_rms_counts: f64,
    /// What the compensated axis does in the same direction without compensation, counts peak to peak: in the
    /// full-temperature test; where that has no ramp in the direction, or one between other temperatures, in the ramp of
    /// this test, the measured effect of its taps taken away.
    pub uncompensated_pp_counts: f64,
    /// The least and greatest temperature of the ramp, counts; `None` of a run by an older version.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_counts: Option<[f64; 2]>,
    /// The share of its groups half a kelvin or more outside of the temperatures that the full-temperature test measured, 0 to 1: there the law
    /// holds the nearer end's drift. `None` of a run by an older version.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outside: Option<f64>,
    /// What a plain quadratic of the full-temperature test, taken off in numbers, would have left of this ramp, counts peak to
    /// peak; `None` where it could not be fitted, and of a run by an older version.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quadratic_pp_counts: Option<f64>,
    /// The control, counts peak to peak.
    pub control_pp_counts: f64,
    /// What noise alone makes: the same groups with the plant's own drift and wiper voltage removed, counts
    /// peak to peak. Known on a simulated bench alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub floor_pp_counts: Option<f64>,
    /// Wiper writes after the first.
    pub wiper_writes: u32,
    /// Tap changes of the noise-free law with the same dead band along the plant's true temperature, from the tap of the
    /// first write on. Known on a simulated bench alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub taps_crossed: Option<u32>,
    /// Mean of the compensated axis, counts.
    pub mean_counts: f64,
    /// The largest jump of the corrected samples in the second after a tap change, less its size elsewhere, counts.
    pub largest_step_counts: f64,
}

/// Something that was checked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Check {
    /// What, in words.
    pub what: String,
    /// The limit, with its unit.
    pub limit: String,
    /// What was measured, with its unit.
    pub measured: String,
    /// Whether it is within the limit.
    #[serde(alias = "pass")]
    pub passed: bool,
}

impl Check {
    /// What was measured, beside the limit.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Self { what, limit, measured, .. } = self;
        format!("{what}: {measured}, limit {limit}")
    }
}

/// One ramp beside the soaks that it replaces.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Soaks {
    /// Chamber time of the ramp, its first soak included, hours.
    pub ramp_hours: f64,
    /// Chamber time of all soaks and the ways between them, hours.
    pub soak_hours: f64,
    /// The chamber time that the ramp saves: that of the soaks which lie on it, less its own, hours.
    pub hours_saved: f64,
    /// The axes by name, `x` and `y`.
    #[serde(flatten)]
    pub axes: BTreeMap<String, AxisSoaks>,
}

/// The soaks of one axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisSoaks {
    /// The largest distance of a soak from the ramp's curve, counts, of those that are not
    /// [`outside`](SoakPoint::outside_ramp); `None` where none is.
    pub max_difference_counts: Option<f64>,
    /// The soaks, in the order in which they were made.
    pub points: Vec<SoakPoint>,
}

/// The mean of one soak.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SoakPoint {
    /// The chamber's set point.
    pub chamber_c: f64,
    /// The gyro's own temperature reading.
    pub temperature_counts: f64,
    /// The zero-rate output.
    pub zro_counts: f64,
    /// The ramp's fitted curve at that temperature.
    pub ramp_counts: f64,
    /// Whether the temperature lies outside of those that the ramp measured, by more than a chamber is held to: then
    /// nothing can be compared.
    #[serde(default)]
    pub outside_ramp: bool,
}

impl AxisSoaks {
    /// How many of the soaks are compared with the ramp.
    #[must_use]
    pub fn compared(&self) -> usize {
        self.points.iter().filter(|soak| !soak.outside_ramp).count()
    }
}

/// Why a summary cannot be read, with its name.
pub type SummaryError = Faulty<SummaryFault>;

/// Why a summary cannot be read.
#[derive(Debug, Error)]
pub enum SummaryFault {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    /// It is another file, or one of a version that wrote less.
    #[error("not the summary of a run, or written by an older zerorate: {}: calibrate the unit again", in_quotes(&.0.to_string()))]
    NotOne(#[from] serde_json::Error),
    /// A schema that this code does not know.
    #[error("schema {found}, and this program knows schemas {OLDEST_SCHEMA} to {SCHEMA}: use a newer zerorate")]
    UnknownSchema {
        /// The schema found.
        found: u32,
    },
}

impl Summary {
    /// Reads a summary.
    ///
    /// # Errors
    /// [`SummaryFault`].
    pub fn read(source: &Source) -> Result<Self, SummaryError> {
        let read = || {
            let text = io::read_to_string(source.open()?)?;
            let summary: Self = serde_json::from_str(&text)?;
            if (OLDEST_SCHEMA..=SCHEMA).contains(&summary.schema) {
                Ok(summary)
            } else {
                Err(SummaryFault::UnknownSchema { found: summary.schema })
            }
        };
        read().map_err(|fault| source.faulty(fault))
    }

    /// The test of an axis in a mode and a direction, if it was run.
    #[must_use]
    pub fn test(&self, axis: Axis, mode: Mode, direction: Phase) -> Option<&TestResult> {
        self.tests.iter().find(|test| (test.axis, test.mode, test.direction) == (axis, mode, direction))
    }

    /// The tests that speak for the run, by trim and by hybrid: those of the first one's axis, heating.
    #[must_use]
    pub fn headline(&self) -> [Option<&TestResult>; 2] {
        let axis = self.tests.first().map(|test| test.axis);
        [Mode::Trim, Mode::Hybrid].map(|mode| self.test(axis?, mode, Phase::Heating))
    }

    /// The same axis's test in the cooling ramp, by the last of these that was run there.
    #[must_use]
    pub fn cooling(&self) -> Option<&TestResult> {
        let axis = self.tests.first().map(|test| test.axis)?;
        [Mode::Hybrid, Mode::Trim].into_iter().find_map(|mode| self.test(axis, mode, Phase::Cooling))
    }

    /// What an axis did in the heating ramp of the full-temperature test, counts peak to peak; NaN for one that is not
    /// there.
    #[must_use]
    pub fn drift_pp_counts(&self, axis: Axis) -> f64 {
        self.axes.get(axis.name()).map_or(f64::NAN, |axis| axis.drift_pp_counts)
    }
}

impl AxisSummary {
    /// The temperatures over which the drift's peak to peak is told, counts.
    #[must_use]
    pub fn drift_temperature_counts(&self) -> [f64; 2] {
        self.heating_temperature_counts.unwrap_or(self.temperature_counts)
    }

    /// Where the ramp covers too little of what was asked for, a sentence about the axis of this name.
    #[must_use]
    pub fn warning(&self, axis: &str) -> Option<String> {
        let cut_short = self.share_of_asked_range.filter(|share| *share < MOST_OF_THE_RAMP);
        cut_short.map(|share| {
            format!(
                "axis {}: the ramp measured {:.0} % of the temperatures from chamber.cold_c to chamber.hot_c, by board.counts_per_celsius: outside of it the law holds the drift of the nearer end",
                axis.to_uppercase(),
                100.0 * share
            )
        })
    }
}

impl TestResult {
    /// How many times smaller the residual is than what the axis does in the same direction without compensation.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.uncompensated_pp_counts / self.residual_pp_counts
    }

    /// The ratio in words: `12 times less`; where more is left, `1.3 times more`; `no less` where nothing was gained.
    #[must_use]
    pub fn times(&self) -> String {
        let ratio = self.ratio();
        let (times, what) = if ratio < 1.0 { (ratio.recip(), "more") } else { (ratio, "less") };
        match times {
            ..1.05 => "no less".to_owned(),
            ..9.95 => format!("{times:.1} times {what}"),
            _ => format!("{times:.0} times {what}"),
        }
    }

    /// The ratio in words beside a drift that was told before it. Where the test's own ramp was between other temperatures, and drifts
    /// by other counts, those are named: a ratio is of them.
    #[must_use]
    pub fn times_beside(&self, told_counts: f64) -> String {
        let (own, times) = (self.uncompensated_pp_counts, self.times());
        let is_told = (own / told_counts - 1.0).abs() < SAME;
        let than = if self.ratio() < 1.0 / (1.0 + SAME) || self.ratio() >= 1.0 + SAME { "than" } else { "of" };
        if is_told { times } else { format!("{times} {than} the {own:.0} that its own ramp drifts") }
    }

    /// How many times smaller the residual is than what a plain quadratic would have left; nothing of the potentiometer alone,
    /// whose taps are coarser than any curve.
    #[must_use]
    pub fn ratio_to_quadratic(&self) -> Option<f64> {
        self.quadratic_pp_counts
            .filter(|_| self.mode != Mode::Trim)
            .map(|quadratic| quadratic / self.residual_pp_counts)
    }

    /// Where the compensation has made the axis worse, and where the test left the temperatures that were fitted, a sentence
    /// each.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let Self { mode, axis, direction, residual_pp_counts: left, uncompensated_pp_counts: before, .. } = self;
        let test = format!("{} {}, {}", axis.name().to_uppercase(), mode.name(), direction.name());
        let worse = (left > before).then(|| {
            format!(
                "{test}: {left:.1} counts peak to peak are left, and without compensation they are {before:.1}: {}",
                self.times()
            )
        });
        let outside = self.outside.filter(|outside| *outside > FEW_OUTSIDE).map(|outside| {
            format!(
                "{test}: {:.0} % of the groups lie half a kelvin or more outside of the temperatures that the full-temperature test measured: there the law holds the drift of the nearer end",
                100.0 * outside
            )
        });
        worse.into_iter().chain(outside).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_is_written_by_the_names_that_recordings_have_and_reads_back() {
        let text = r#"{"mode":"hybrid","axis":"x","control":"y","direction":"cooling","residual_pp_counts":7.1,
            "residual_rms_counts":1.0,"uncompensated_pp_counts":420.0,"quadratic_pp_counts":14.2,"control_pp_counts":400.0,"wiper_writes":13,"mean_counts":8200.1,
            "largest_step_counts":0.5}"#;
        let result: TestResult = serde_json::from_str(text).unwrap();
        assert_eq!((result.mode, result.control, result.direction), (Mode::Hybrid, Axis::Y, Phase::Cooling));
        assert_eq!(result.ratio_to_quadratic(), Some(2.0));
        assert_eq!(TestResult { mode: Mode::Trim, ..result.clone() }.ratio_to_quadratic(), None);
        let again = serde_json::to_value(&result).unwrap();
        assert_eq!((&again["mode"], &again["direction"]), (&"hybrid".into(), &"cooling".into()));
        let wrong = serde_json::from_str::<TestResult>(&text.replace("hybrid", "mixed")).unwrap_err().to_string();
        assert!(wrong.contains("'mixed' is no mode: there are off, trim, digital, hybrid"), "{wrong}");
    }

    #[test]
    fn a_ratio_beside_the_drift_of_other_temperatures_names_its_own() {
        let text = r#"{"mode":"trim","axis":"x","control":"y","direction":"heating","residual_pp_counts":32.0,
            "residual_rms_counts":1.0,"uncompensated_pp_counts":384.0,"control_pp_counts":400.0,"wiper_writes":13,
            "mean_counts":8200.1,"largest_step_counts":0.5}"#;
        let test: TestResult = serde_json::from_str(text).unwrap();
        // 384 / 32 are 12, and 240 are another ramp's.
        assert_eq!(test.times_beside(384.0), "12 times less");
        assert_eq!(test.times_beside(380.0), "12 times less");
        assert_eq!(test.times_beside(240.0), "12 times less than the 384 that its own ramp drifts");
        let none = TestResult { residual_pp_counts: 384.0, ..test };
        assert_eq!(none.times_beside(240.0), "no less of the 384 that its own ramp drifts");
    }

    #[test]
    fn what_is_left_is_told_as_less_or_more_and_a_warning_says_that_it_is_more() {
        for (left, times) in [(34.9, "1.3 times more"), (27.0, "no less"), (26.4, "no less"), (4.4, "6.0 times less")] {
            let text = format!(
                r#"{{"mode":"trim","axis":"x","control":"y","direction":"heating","residual_pp_counts":{left},
                "residual_rms_counts":1.0,"uncompensated_pp_counts":26.4,"control_pp_counts":400.0,"wiper_writes":13,
                "mean_counts":8200.1,"largest_step_counts":0.5}}"#
            );
            let test: TestResult = serde_json::from_str(&text).unwrap();
            assert_eq!(test.times(), times);
            let told = test.warnings();
            assert_eq!(told.len(), usize::from(left > 26.4), "{told:?}");
            assert!(told.iter().all(|told| told.starts_with("X trim, heating: ") && told.ends_with(times)));
            let beyond = |outside| TestResult { outside: Some(outside), ..test.clone() }.warnings();
            assert_eq!(beyond(0.04), told);
            assert!(beyond(0.33).last().unwrap().contains("33 % of the groups lie half a kelvin or more outside"));
        }
    }

    #[test]
    fn what_is_no_summary_is_named_with_what_it_lacks() {
        let refused =
            |text: &str| Summary::read(&Source::bytes("summary.json", text.as_bytes())).unwrap_err().to_string();
        let told = refused("{\"schema\": 1, \"serial\": \"ZR-1\"}");
        assert!(told.starts_with("summary.json: ") && told.contains("missing field 'verdict'"), "{told}");
    }
}
