//! The set-up: one TOML file describes a board and its bench. The paper's is the default.
//!
//! Everything is checked when a set-up is read, so that a run of hours does not end in a contradiction. What stands here
//! over a field stands over it in the file that `zerorate setup` prints, too.

mod contradictions;
pub(crate) mod soaks;

use std::collections::BTreeMap;
use std::path::Path;

use documented::DocumentedFields;
use serde::{Deserialize, Serialize};
use zerorate_cal::calibration::BoardScale;
use zerorate_cal::source::{in_quotes, line_at};
use zerorate_core::board::BoardNumbers;
use zerorate_core::compensate::{LowPass, Mode};
use zerorate_core::units::{Celsius, Counts, Seconds, Taps, TemperatureScale};
use zerorate_fit::model::Model;
pub use zerorate_instruments::controller::ControllerTable;
pub use zerorate_instruments::supply::SupplyTable;

/// The supply of the potentiometer, volts (paper, 2.1): a tap is a 1023rd of it.
const POTENTIOMETER_SUPPLY_V: f64 = 5.0;

/// Chamber time at room temperature before the trim experiment.
pub(crate) const ROOM_SOAK: Seconds = Seconds(1200.0);
/// Groups averaged at the end of each soak of the traditional test: one minute of the paper's.
pub(crate) const GROUPS_A_SOAK: u32 = 40;

/// A board and its bench.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(default, deny_unknown_fields)]
pub struct SetUp {
    /// The board: what stands on its schematic.
    pub board: Board,
    /// How groups are taken. Length times period is a group's time: 1.5 s, or 40 groups a minute.
    pub acquisition: Acquisition,
    /// The chamber's profile.
    pub chamber: ChamberProfile,
    /// The trim experiment, and the law that is made from it.
    pub trim: TrimExperiment,
    /// The drift model.
    pub drift: DriftChoice,
    /// What a unit must pass, over the heating ramp.
    pub limits: Limits,
    /// The fine supply, for remote control; without it a supply of 5 V at most, without a voltmeter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supply: Option<SupplyTable>,
    /// What is to stand in every recording besides, by names of your own: station = "oven 2", operator = "A. N."
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub labels: BTreeMap<String, String>,
}

/// The board: what stands on its schematic.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(default, deny_unknown_fields)]
pub struct Board {
    /// Bits of the A/D converter, 8 to 16.
    pub converter_bits: u32,
    /// The zero-rate reading aimed at, V0, counts.
    pub centre_counts: f64,
    /// The tap N0 at which the drift is measured: the middle of the part's 0 to 1023.
    pub middle_tap: u16,
    /// The trim part. Only "max5494" is supported so far.
    pub trim_part: String,
    /// Counts a degree per second; negative where the reading falls when the rate rises.
    pub counts_per_dps: f64,
    /// Counts a degree C of the temperature reading.
    pub counts_per_celsius: f64,
    /// The temperature reading at 0 C, counts; a part's own is some degrees off.
    pub counts_at_zero_celsius: f64,
    /// Noise of one sample of the temperature reading, counts rms. A sensor that shows less than a quarter of it and does not
    /// move is taken to be stuck, and one that shows 32 times as much in a group to be out of order.
    pub temperature_noise_counts: f64,
    /// Volts at the rate input that move the reading by one count, without sign.
    pub input_volts_per_count: f64,
    /// Cut-off of the circuit's first-order low-pass, Hz.
    pub low_pass_hz: f64,
    /// Time from a set's last sample to the wiper's write, microseconds.
    pub wiper_delay_us: f64,
}

/// How groups are taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(default, deny_unknown_fields)]
pub struct Acquisition {
    /// Samples averaged to a group, 1 to 512.
    pub group_length: u16,
    /// Time from sample to sample, microseconds.
    pub sample_period_us: u32,
    /// Conversions that a sample is the mean of: 1, 2, 4, 8 or 16, 100 microseconds apart at least. The paper's board has one,
    /// and a vibration at its sampling rate is aliased onto the zero. As many as the board's firmware asks its port for.
    pub oversampling: u8,
}

/// The chamber's profile.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(default, deny_unknown_fields)]
pub struct ChamberProfile {
    /// The cold end of the ramp, degrees C.
    pub cold_c: f64,
    /// The hot end of the ramp, degrees C.
    pub hot_c: f64,
    /// Room temperature, at which the trim is measured, degrees C.
    pub room_c: f64,
    /// How long the chamber is held before a ramp once it is at its set point, seconds.
    pub soak_s: f64,
    /// Groups of a ramp that are used, from its beginning: 2400 are its first hour.
    pub ramp_groups: u32,
    /// Whether the full-temperature test records the way back down too: a history shows only in both directions.
    pub cooling_ramp: bool,
    /// Groups taken at the end of a soak, before the ramp begins.
    pub soak_groups: u32,
    /// The least and the greatest temperature that the chamber may be sent to, degrees C.
    pub limits_c: [f64; 2],
    /// The soaks of the traditional test to compare with, degrees C. Those outside of the ramp's ends are left out.
    pub soaks_c: Vec<f64>,
    /// The chamber's controller, for remote control: `zerorate setup --controller watlow-f4t` prints one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controller: Option<ControllerTable>,
}

/// The trim experiment and the law made from it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(default, deny_unknown_fields)]
pub struct TrimExperiment {
    /// Supply voltages, half of them to each side of the room reading.
    pub points: u32,
    /// How far the supply moves the reading to each side, counts.
    pub span_counts: f64,
    /// Groups averaged at each voltage.
    pub groups_per_point: u32,
    /// Taps measured beyond those that the drift needs, on each side.
    pub margin_taps: u16,
    /// Dead band of the law, taps, 0 to 0.5. Every 0.05 costs 1.6 counts of residual each way where the drift turns round;
    /// too little, and noise of the temperature switches a tap to and fro.
    pub dead_band_taps: f64,
    /// Whether a board that holds the calibration goes to work with it as soon as its power comes, host or no host. If false
    /// it stands still in mode off until a host has it start.
    pub works_alone: bool,
}

/// The drift model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(default, deny_unknown_fields)]
pub struct DriftChoice {
    /// poly:1 to poly:5, table:1 to table:32, or auto: as strong as the data say, with a history where
    /// chamber.cooling_ramp records both directions.
    pub model: String,
}

/// What a unit must pass, over the heating ramp.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Residual of mode trim, counts peak to peak. A tap is the least that a potentiometer leaves.
    pub trim_residual_pp_counts: f64,
    /// Residual of mode hybrid, in multiples of the floor (what noise alone makes). A real bench knows no floor:
    /// there it must leave no more than mode trim.
    pub hybrid_residual_floors: f64,
    /// Distance of the compensated mean from the centre, counts.
    pub mean_offset_counts: f64,
    /// Distance of a soak from the ramp's curve, counts: half of what mode trim may leave peak to peak.
    pub soak_difference_counts: f64,
}

impl Default for SetUp {
    fn default() -> Self {
        Self::paper()
    }
}

impl SetUp {
    /// The paper's board and bench, with what docs/paper.md takes where the paper is silent.
    #[must_use]
    pub fn paper() -> Self {
        Self {
            board: Board::default(),
            acquisition: Acquisition::default(),
            chamber: ChamberProfile::default(),
            trim: TrimExperiment::default(),
            drift: DriftChoice::default(),
            limits: Limits::default(),
            supply: None,
            labels: BTreeMap::new(),
        }
    }

    /// The same bench for units whose drift is not known beforehand: the model is `auto`.
    #[must_use]
    pub fn typical() -> Self {
        Self { drift: DriftChoice { model: "auto".into() }, ..Self::paper() }
    }

    /// Reads and checks a set-up file.
    ///
    /// # Errors
    /// [`SetUpError`], naming the file and, where TOML is wrong, line and column.
    pub fn read(path: &Path) -> Result<Self, SetUpError> {
        let shown = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|source| SetUpError::Read { path: shown.clone(), source })?;
        Self::parse(&text, &shown)
    }

    /// Reads and checks a set-up from its text; `name` is what errors call it.
    ///
    /// # Errors
    /// [`SetUpError`].
    pub fn parse(text: &str, name: &str) -> Result<Self, SetUpError> {
        let setup: Self = toml::from_str(text).map_err(|error| {
            let line = line_at(text, error.span().map_or(0, |span| span.start));
            SetUpError::Toml { path: name.into(), line, reason: in_quotes(&error.message().replace('\n', ", ")) }
        })?;
        let contradictions = setup.contradictions();
        if contradictions.is_empty() {
            Ok(setup)
        } else {
            Err(SetUpError::Contradicts { path: name.into(), reasons: contradictions.join("; ") })
        }
    }

    /// The set-up as a TOML file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        toml::to_string_pretty(self).unwrap_or_default()
    }

    /// The converter's highest reading.
    #[must_use]
    pub fn full_scale(&self) -> Counts {
        Counts(f64::from((1_u32 << self.board.converter_bits.min(16)) - 1))
    }

    /// The converter and the temperature sensors as a device is told of them; the paper's where a set-up was never checked.
    #[must_use]
    pub fn numbers(&self) -> BoardNumbers {
        self.board_scale().numbers().unwrap_or(BoardNumbers::PAPER)
    }

    /// What a temperature code stands for on the board, in counts.
    pub(crate) fn temperature_scale(&self) -> TemperatureScale {
        TemperatureScale { zero: 0.0, step: 1.0 / f64::from(self.numbers().codes_per_count) }
    }

    /// The same as a calibration keeps it.
    pub(crate) const fn board_scale(&self) -> BoardScale {
        BoardScale {
            converter_bits: self.board.converter_bits,
            counts_per_kelvin: self.board.counts_per_celsius,
            temperature_noise_counts: self.board.temperature_noise_counts,
        }
    }

    /// The middle tap N0.
    #[must_use]
    pub fn middle(&self) -> Taps {
        Taps::new(self.board.middle_tap).unwrap_or(Taps::MIDDLE)
    }

    /// The centre V0 aimed at.
    #[must_use]
    pub const fn centre(&self) -> Counts {
        Counts(self.board.centre_counts)
    }

    /// How long a group takes.
    #[must_use]
    pub fn group_period(&self) -> Seconds {
        Seconds(f64::from(self.acquisition.group_length) * f64::from(self.acquisition.sample_period_us) * 1e-6)
    }

    /// The circuit's low-pass as the device sees it.
    #[must_use]
    pub fn low_pass(&self) -> LowPass {
        let period = f64::from(self.acquisition.sample_period_us) * 1e-6;
        let delay = self.board.wiper_delay_us * 1e-6;
        LowPass::first_order_of_means(self.board.low_pass_hz, period, delay, self.acquisition.oversampling)
    }

    /// The mode in which a board starts that holds the calibration.
    #[must_use]
    pub const fn start_up_mode(&self) -> Mode {
        if self.trim.works_alone { Mode::Hybrid } else { Mode::Off }
    }

    /// A temperature reading in degrees C by the board's scale.
    #[must_use]
    pub fn celsius(&self, reading: Counts) -> Celsius {
        Celsius((reading.0 - self.board.counts_at_zero_celsius) / self.board.counts_per_celsius)
    }

    /// How far one tap moves the reading as the circuit's drawing has it: the supply's 1023rd through the circuit.
    #[must_use]
    pub fn nominal_counts_per_tap(&self) -> f64 {
        POTENTIOMETER_SUPPLY_V / f64::from(Taps::LAST.get()) / self.board.input_volts_per_count
    }

    /// What a sound set-up asks for that no chamber gives, and no unit whose taps are as the drawing has them, in sentences. Parts
    /// differ a little, so that one may pass; a run may be made all the same.
    #[must_use]
    pub fn unreachable(&self) -> Vec<String> {
        let (limit, tap) = (self.limits.trim_residual_pp_counts, self.nominal_counts_per_tap());
        let sentence = format!(
            "limits.trim_residual_pp_counts {limit} is less than a tap as the circuit's drawing has it, {tap:.1} counts: a potentiometer moves in whole taps, so mode trim leaves less only where a unit's own taps are smaller, or its drift crosses none"
        );
        (limit < tap).then_some(sentence).into_iter().chain(self.ramp_too_fast()).collect()
    }

    /// The drift model asked for; `auto` where a set-up was never checked and its model makes no sense.
    #[must_use]
    pub fn model(&self) -> Model {
        self.drift.model.parse().unwrap_or(Model::Auto)
    }

    /// The cold and the hot end.
    #[must_use]
    pub const fn ends(&self) -> [Celsius; 2] {
        [Celsius(self.chamber.cold_c), Celsius(self.chamber.hot_c)]
    }
}

impl Default for Board {
    fn default() -> Self {
        Self {
            converter_bits: 14,
            centre_counts: 8200.0,
            middle_tap: 511,
            trim_part: "max5494".into(),
            // 6 mV a degree per second (ADXRS620) times the circuit's gain of -1.599, a count being 250 uV.
            counts_per_dps: -38.4,
            // 8500 to 11 900 counts over -40 to +60 C (docs/paper.md, "What the paper leaves open").
            counts_per_celsius: 34.0,
            counts_at_zero_celsius: 9860.0,
            temperature_noise_counts: 3.0,
            // 250 uV a count over the gain of 1.599.
            input_volts_per_count: 250e-6 / 1.599,
            low_pass_hz: 40.0,
            wiper_delay_us: 170.0,
        }
    }
}

impl Default for Acquisition {
    fn default() -> Self {
        Self { group_length: 500, sample_period_us: 3000, oversampling: 1 }
    }
}

impl Default for ChamberProfile {
    fn default() -> Self {
        Self {
            cold_c: -40.0,
            hot_c: 60.0,
            room_c: 25.0,
            soak_s: 3600.0,
            ramp_groups: 2400,
            cooling_ramp: false,
            soak_groups: 20,
            limits_c: [-60.0, 150.0],
            soaks_c: (0..=10).map(|k| -40.0 + 10.0 * f64::from(k)).collect(),
            controller: None,
        }
    }
}

impl Default for TrimExperiment {
    fn default() -> Self {
        Self {
            points: 21,
            span_counts: 1000.0,
            groups_per_point: 4,
            margin_taps: 3,
            dead_band_taps: 0.05,
            works_alone: true,
        }
    }
}

impl Default for DriftChoice {
    fn default() -> Self {
        Self { model: "poly:2".into() }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            trim_residual_pp_counts: 40.0,
            hybrid_residual_floors: 2.0,
            mean_offset_counts: 16.0,
            soak_difference_counts: 20.0,
        }
    }
}

/// Why a set-up cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SetUpError {
    /// The file cannot be read.
    #[error("cannot read the set-up {path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is not TOML, or has a field that no set-up has.
    #[error("the set-up {path}, line {line}: {reason} (`zerorate setup` prints a whole one to start from)")]
    Toml {
        /// The file.
        path: String,
        /// The line, from 1.
        line: usize,
        /// What is wrong there.
        reason: String,
    },
    /// It contradicts itself.
    #[error("the set-up {path} contradicts itself: {reasons}")]
    Contradicts {
        /// The file.
        path: String,
        /// The contradictions, in sentences.
        reasons: String,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_set_up_is_sound_and_survives_its_file() {
        for setup in [SetUp::paper(), SetUp::typical()] {
            assert_eq!(setup.contradictions(), Vec::<String>::new());
            assert_eq!(SetUp::parse(&setup.to_toml(), "x").unwrap(), setup);
        }
        assert!((SetUp::paper().group_period().0 - 1.5).abs() < 1e-12, "40 groups a minute");
    }

    #[test]
    fn the_papers_ends_are_minus_40_and_60_degrees() {
        // docs/paper.md: 8500 to 11 900 counts for -40 to +60 C.
        let [cold, hot] = [8500.0, 11_900.0].map(|reading| SetUp::paper().celsius(Counts(reading)).0);
        assert!((cold + 40.0).abs() < 1e-9 && (hot - 60.0).abs() < 1e-9, "{cold} {hot}");
    }

    #[test]
    fn a_trim_limit_below_a_tap_is_told_and_one_above_is_not() {
        // docs/paper.md: one tap moves the reading by 31.26 counts.
        let with = |limit: f64| SetUp::parse(&format!("[limits]\ntrim_residual_pp_counts = {limit}"), "x").unwrap();
        assert_eq!(with(31.3).unreachable(), Vec::<String>::new());
        let told = with(31.2).unreachable();
        assert!(told.len() == 1 && told[0].contains("31.3 counts"), "{told:?}");
    }

    #[test]
    fn a_set_up_can_ask_for_a_board_that_waits_for_its_host() {
        let silent = SetUp::parse("[trim]\nworks_alone = false\n", "x").unwrap();
        assert_eq!([SetUp::paper().start_up_mode(), silent.start_up_mode()], [Mode::Hybrid, Mode::Off]);
    }

    #[test]
    fn a_part_of_a_file_keeps_the_papers_rest() {
        let setup = SetUp::parse("[chamber]\ncold_c = -20.0\n", "x").unwrap();
        assert!((setup.chamber.cold_c + 20.0).abs() < 1e-12);
        assert_eq!(setup.board, Board::default());
    }

    #[test]
    fn every_contradiction_is_named() {
        let text = "[chamber]\ncold_c = 70.0\nhot_c = 200.0\n[trim]\npoints = 2\n[board]\nmiddle_tap = 2000\n[drift]\nmodel = \"poly:9\"";
        let error = SetUp::parse(text, "bench.toml").unwrap_err().to_string();
        for part in ["bench.toml", "hot_c 200", "trim.points 2", "middle_tap 2000", "drift.model"] {
            assert!(error.contains(part), "{part} is missing from: {error}");
        }
    }

    #[test]
    fn a_middle_tap_at_an_end_and_a_limit_below_noise_are_contradictions() {
        // 1000 counts of 31.26 are 32 taps, and three beside: 35 to 988.
        for (middle, sound) in [(5, false), (34, false), (36, true), (987, true), (1000, false)] {
            let told = SetUp::parse(&format!("[board]\nmiddle_tap = {middle}"), "x");
            assert_eq!(told.is_ok(), sound, "{middle}: {told:?}");
        }
        for (floors, sound) in [(0.99, false), (1.0, true)] {
            let told = SetUp::parse(&format!("[limits]\nhybrid_residual_floors = {floors:?}"), "x");
            assert_eq!(told.is_ok(), sound, "{floors}: {told:?}");
        }
    }

    #[test]
    fn a_misspelt_field_is_named_with_its_line() {
        let error = SetUp::parse("[chamber]\ncold = -40.0\n", "bench.toml").unwrap_err().to_string();
        assert!(error.contains("line 2") && error.contains("cold"), "{error}");
    }
}
