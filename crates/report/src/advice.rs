//! What to do about a log, for each thing that a verdict can rest on.

use zerorate_cal::quality::{Judgement, ReasonKind};

/// How to get a better log: the advice on each reason, each said once.
#[must_use]
pub fn advice(judgement: &Judgement) -> Vec<&'static str> {
    let mut all: Vec<&str> = Vec::new();
    for sentence in judgement.reasons.iter().map(|reason| on(reason.kind)) {
        if !all.contains(&sentence) {
            all.push(sentence);
        }
    }
    all
}

/// In a sentence or two.
fn on(kind: ReasonKind) -> &'static str {
    match kind {
        ReasonKind::NarrowSpan => {
            "Log over a wider span of temperature: cool the unit in a freezer, then log from power-on, at rest, until it is \
                 as warm as it gets. Ten degrees are the least; forty make a good curve."
        }
        ReasonKind::NotCelsius => {
            "Convert the temperature to degrees C, or name the column that has the gyro’s own temperature with \
                 `temperature`; counts are known by a name with counts, lsb, adc or raw in it."
        }
        ReasonKind::StuckTemperature => {
            "Check that the temperature column is the gyro’s own sensor and that it is being updated; name another with \
                 `temperature`."
        }
        ReasonKind::TooFewGroups => "Log for longer: half an hour of slow warming is a good log.",
        ReasonKind::NoFiniteRows => "Check that the columns named hold numbers in the same rows.",
        ReasonKind::CutRun => "Look why the run ended before its ramp did, and record it again whole.",
        ReasonKind::LostGroups => "Take another copy of the recording, or record it again.",
        ReasonKind::StuckReading => "Check the gyro’s supply and its line, and that the column is the gyro’s.",
        ReasonKind::Outliers => "Look for a loose connection or a disturbed bench, and record again.",
        ReasonKind::WiperMoved => {
            "Fit the recording of the full-temperature test: there the wiper stays at the middle tap."
        }
        ReasonKind::WrongSerial | ReasonKind::DuplicateSerial => {
            "Find out which unit was recorded, and record it again."
        }
        ReasonKind::Copied => "Take the copy away, and record the unit that it stands for.",
        ReasonKind::Saturated => "Adjust the circuit’s centre or gain so that the reading stays inside the converter.",
        ReasonKind::MissingValues => {
            "Look for lost messages: a slower card or link drops rows when the log rate is too high."
        }
        ReasonKind::Spikes => "Look for a loose connection or a disturbed bench, and log again with the unit on foam.",
        ReasonKind::Rotation => "Leave the unit untouched while it logs: turn off motors, close the box, walk away.",
        ReasonKind::StartUp => {
            "Nothing needs doing: the first readings, which settle, are left out. Where too little is left, log for longer."
        }
        ReasonKind::Gap => "Look for why nothing was logged for a while: a full or slow card, a link that was lost.",
        ReasonKind::FrozenTemperature => {
            "Look for why the temperature stood still: a sensor that is read too seldom, or a bus that hangs."
        }
        ReasonKind::StoppedReading => {
            "Look for why the rate was one number: a full scale or an offset that leaves no room, or a bus that hangs."
        }
        ReasonKind::TemperatureJump => {
            "Look for what changed when the temperature jumped: a sensor, a connector, a scale; a curve needs one that is true \
                 throughout."
        }
        ReasonKind::CoarseRate => {
            "Take the gyro’s rate at its full resolution: a smaller full scale, or more digits in the log."
        }
        ReasonKind::CoarseTemperature => {
            "A temperature in coarse steps makes the curve less exact: take the gyro’s own sensor at its full resolution, \
                 or warm slowly."
        }
        ReasonKind::Unmeasured => "Log once more through the temperatures that are missing, and fit all logs together.",
        ReasonKind::LogsApart => "Log once more over the temperatures of both, and fit all logs together.",
        ReasonKind::Repeated => "Look at how the file was made: a run joined to itself, or one column saved as two.",
        ReasonKind::Truncated => "Stop the log before the power goes, and copy the whole file.",
        ReasonKind::OneDirection => {
            "Log on until the unit has cooled again, or log a second run that cools and fit both: only a temperature that \
                 was passed both ways shows hysteresis."
        }
        ReasonKind::WorseThanUncorrected => {
            "Fit several logs of the unit that go over the whole range both ways: a curve of one direction is wrong by the \
                 hysteresis, and a drift in time bends the curve of a single log."
        }
        ReasonKind::MoreThanTold => {
            "See that it is the same unit, and fit this run with those of the calibration: it has something that they had not, \
                 another way through the temperatures, another speed of heating, or a unit that was moved."
        }
        ReasonKind::OutsideRange => "Calibrate over all temperatures that the unit will meet.",
        ReasonKind::NoSensor => {
            "Switch on the logging of the raw gyro and accelerometer with their temperatures, and log again."
        }
        ReasonKind::GuessedUnit => {
            "Say the unit with `rate_unit` or `temperature_unit`, or in the columns’ names: gyro_x_dps, gyro_x_rad_s, temp_c."
        }
        ReasonKind::AssumedUnit => {
            "Say the units that the columns do not name with `temperature_unit` and `time_unit`, if they are others."
        }
        ReasonKind::Step => {
            "Look for what changed when the rate stepped: a supply, a restart, a connector. The curve holds for the \
                 level before it."
        }
        ReasonKind::Jump => {
            "Log a second run and fit both: a part that jumps by itself does so again, and what changed only once does not."
        }
    }
}
