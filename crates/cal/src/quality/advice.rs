//! What to do about a log, for each thing that a verdict can rest on.

use super::{Judgement, ReasonKind};

impl ReasonKind {
    /// How to get a better log, in a sentence or two.
    #[must_use]
    pub fn advice(self) -> &'static str {
        match self {
            Self::NarrowSpan => {
                "Log over a wider span of temperature: cool the unit in a freezer, then log from power-on, at rest, until it is \
                 as warm as it gets. Ten degrees are the least; forty make a good curve."
            }
            Self::NotCelsius => {
                "Convert the temperature to degrees C, or name the column that has the gyro’s own temperature with \
                 `temperature`; counts are known by a name with counts, lsb, adc or raw in it."
            }
            Self::StuckTemperature => {
                "Check that the temperature column is the gyro’s own sensor and that it is being updated; name another with \
                 `temperature`."
            }
            Self::TooFewGroups => "Log for longer: half an hour of slow warming is a good log.",
            Self::NoFiniteRows => "Check that the columns named hold numbers in the same rows.",
            Self::CutRun => "Look why the run ended before its ramp did, and record it again whole.",
            Self::LostGroups => "Take another copy of the recording, or record it again.",
            Self::StuckReading => "Check the gyro’s supply and its line, and that the column is the gyro’s.",
            Self::Outliers => "Look for a loose connection or a disturbed bench, and record again.",
            Self::WiperMoved => {
                "Fit the recording of the full-temperature test: there the wiper stays at the middle tap."
            }
            Self::WrongSerial | Self::DuplicateSerial => "Find out which unit was recorded, and record it again.",
            Self::Saturated => "Adjust the circuit’s centre or gain so that the reading stays inside the converter.",
            Self::MissingValues => {
                "Look for lost messages: a slower card or link drops rows when the log rate is too high."
            }
            Self::Spikes => "Look for a loose connection or a disturbed bench, and log again with the unit on foam.",
            Self::Rotation => "Leave the unit untouched while it logs: turn off motors, close the box, walk away.",
            Self::StartUp => "Let the unit run for a minute before the log begins, or log on: the start is left out.",
            Self::Gap => "Look for why nothing was logged for a while: a full or slow card, a link that was lost.",
            Self::FrozenTemperature => {
                "Look for why the temperature stood still: a sensor that is read too seldom, or a bus that hangs."
            }
            Self::TemperatureJump => {
                "Look for what changed when the temperature jumped: a sensor, a connector, a scale; a curve needs one that is true \
                 throughout."
            }
            Self::CoarseRate => {
                "Take the gyro’s rate at its full resolution: a smaller full scale, or more digits in the log."
            }
            Self::CoarseTemperature => {
                "A temperature in coarse steps makes the curve less exact: take the gyro’s own sensor at its full resolution, \
                 or warm slowly."
            }
            Self::Unmeasured => "Log once more through the temperatures that are missing, and fit all logs together.",
            Self::Repeated => "Look at how the file was made: a run joined to itself, or one column saved as two.",
            Self::Truncated => "Stop the log before the power goes, and copy the whole file.",
            Self::OneDirection => {
                "Log on until the unit has cooled again, or log a second run that cools and fit both: only a temperature that \
                 was passed both ways shows hysteresis."
            }
            Self::WorseThanUncorrected => {
                "Fit several logs of the unit that go over the whole range both ways: a curve of one direction is wrong by the \
                 hysteresis, and a drift in time bends the curve of a single log."
            }
            Self::OutsideRange => "Calibrate over all temperatures that the unit will meet.",
            Self::NoSensor => {
                "Switch on the logging of the raw gyro and accelerometer with their temperatures, and log again."
            }
            Self::GuessedUnit => {
                "Say the unit with `rate_unit` or `temperature_unit`, or in the columns’ names: gyro_x_dps, gyro_x_rad_s, temp_c."
            }
            Self::AssumedUnit => {
                "Say the units that the columns do not name with `temperature_unit` and `time_unit`, if they are others."
            }
            Self::Step => {
                "Look for what changed when the rate stepped: a supply, a restart, a connector. The curve holds for the \
                 level before it."
            }
            Self::Jump => {
                "Log a second run and fit both: a part that jumps by itself does so again, and what changed only once does not."
            }
        }
    }
}

impl Judgement {
    /// How to get a better log: the advice on each reason, each said once.
    #[must_use]
    pub fn advice(&self) -> Vec<&'static str> {
        let mut advice: Vec<&str> = Vec::new();
        for sentence in self.reasons.iter().map(|reason| reason.kind.advice()) {
            if !advice.contains(&sentence) {
                advice.push(sentence);
            }
        }
        advice
    }
}
