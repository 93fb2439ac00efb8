//! From the fit of a log to its report.

use super::parameters;
use super::{LeftOut, LogAxis, LogPoint, LogReport, RejectedSamples};
use crate::CandidateRow;
use zerorate_cal::characterise::Characteristics;
use zerorate_cal::condition::{DropReason, Excluded};
use zerorate_cal::log_fit::{AxisFit, LogFit};
use zerorate_cal::quality::ReasonKind;
use zerorate_cal::units::TemperatureUnit;
use zerorate_core::drift::Shape;
use zerorate_fit::drift_fit::Candidate;
use zerorate_fit::least_squares::raw_coefficients;
use zerorate_fit::residual::ResidualStatistics;

impl From<&LogFit> for LogReport {
    fn from(fit: &LogFit) -> Self {
        let first = fit.axes.first();
        let mut advice: Vec<String> = Vec::new();
        for reason in &fit.judgement.reasons {
            let sentence = advice_for(reason.kind);
            if !advice.iter().any(|given| given == sentence) {
                advice.push(sentence.to_owned());
            }
        }
        Self {
            source: fit.source(),
            verdict: fit.judgement.verdict,
            reasons: fit.judgement.reasons.clone(),
            notes: fit.notes.clone(),
            temperature_unit: first.map_or("", |axis| unit_of(axis.temperature_unit)).to_owned(),
            axes: fit.axes.iter().map(LogAxis::from).collect(),
            left_out: fit.excluded.iter().map(LeftOut::from).collect(),
            parameters: parameters::of(fit),
            advice,
            next_command: None,
        }
    }
}

fn unit_of(unit: TemperatureUnit) -> &'static str {
    match unit {
        TemperatureUnit::C => "°C",
        TemperatureUnit::Counts => "counts",
    }
}

impl From<&AxisFit> for LogAxis {
    fn from(axis: &AxisFit) -> Self {
        let own = &axis.calibration;
        let (model, statistics) = (&own.fit.model, &own.fit.statistics);
        let row = |candidate: &Candidate| CandidateRow {
            model: candidate.model.clone(),
            in_sample_rms: candidate.in_sample_rms,
            held_out_rms: candidate.held_out_rms.unwrap_or(f64::NAN),
            standard_error: candidate.held_out_excess_standard_error.unwrap_or(f64::NAN),
            chosen: candidate.chosen,
        };
        let rejected = axis
            .samples_rejected
            .iter()
            .map(|rejected| RejectedSamples { reason: words_for(rejected.reason).to_owned(), count: rejected.count });
        let points = axis.trace.iter().map(|point| LogPoint {
            elapsed_s: point.time_s,
            temperature: point.temperature,
            rate: point.rate,
            corrected: point.residual,
        });
        Self {
            name: axis.name.clone(),
            rate_unit: own.rate_unit.to_string(),
            model: own.fit.chosen_model(),
            raw_coefficients: raw_coefficients(&model.drift.shape),
            is_polynomial: matches!(model.drift.shape, Shape::Polynomial(_)),
            temperature: [model.drift.valid.min(), model.drift.valid.max()],
            in_sample: statistics.in_sample,
            held_out: statistics.held_out.unwrap_or(ResidualStatistics::NONE),
            samples_used: statistics.samples_used,
            samples_rejected: rejected.collect(),
            candidates: statistics.candidates.iter().map(row).collect(),
            points: points.collect(),
            characteristics: Some(Characteristics::of(axis)),
            band: own.fit.band.iter().map(|point| (point.temperature, point.half_width)).collect(),
        }
    }
}

impl From<&Excluded> for LeftOut {
    fn from(stretch: &Excluded) -> Self {
        Self {
            reason: words_for(stretch.reason).to_owned(),
            start_s: stretch.time_s.0,
            end_s: stretch.time_s.1,
            temperature: [stretch.temperature.0, stretch.temperature.1],
            rows: stretch.rows.1 - stretch.rows.0,
        }
    }
}

fn words_for(reason: DropReason) -> &'static str {
    match reason {
        DropReason::MissingTemperature => "no number for the temperature",
        DropReason::MissingRate => "no number for the rate",
        DropReason::StartUp => "start-up, before the readings settle",
        DropReason::TemperatureSpike => "temperature far from its neighbours",
        DropReason::Spike => "rate far from its neighbours",
        DropReason::Rotation => "the unit was moved",
        DropReason::Step => "the rate stepped",
        DropReason::Gap => "nothing was logged for a while",
        DropReason::FrozenTemperature => "the temperature stood still",
    }
}

fn advice_for(kind: ReasonKind) -> &'static str {
    match kind {
        ReasonKind::NarrowSpan => {
            "Log over a wider span of temperature: cool the unit in a freezer, then log from power-on, at rest, until it is as \
             warm as it gets. Ten degrees are the least; forty make a good curve."
        }
        ReasonKind::StuckTemperature => {
            "Check that the temperature column is the gyro’s own sensor and that it is being updated; name another with \
             --temperature."
        }
        ReasonKind::TooFewGroups => "Log for longer: half an hour of slow warming is a good log.",
        ReasonKind::NoFiniteRows => "Check that the columns named hold numbers in the same rows.",
        ReasonKind::CutRun => "Look why the run ended before its ramp did, and record it again whole.",
        ReasonKind::LostGroups => "Take another copy of the recording, or record it again.",
        ReasonKind::StuckReading => "Check the gyro's supply and its line to the converter.",
        ReasonKind::Outliers => "Look for a loose connection or a disturbed bench, and record again.",
        ReasonKind::WiperMoved => {
            "Fit the recording of the full-temperature test: there the wiper stays at the middle tap."
        }
        ReasonKind::WrongSerial | ReasonKind::DuplicateSerial => {
            "Find out which unit was recorded, and record it again."
        }
        ReasonKind::Saturated => "Adjust the circuit's centre or gain so that the reading stays inside the converter.",
        ReasonKind::MissingValues => {
            "Look for lost messages: a slower card or link drops rows when the log rate is too high."
        }
        ReasonKind::Spikes => "Look for a loose connection or a disturbed bench, and log again with the unit on foam.",
        ReasonKind::Rotation => "Leave the unit untouched while it logs: turn off motors, close the box, walk away.",
        ReasonKind::StartUp => "Let the unit run for a minute before the log begins, or log on: the start is left out.",
        ReasonKind::Gap => "Look for why nothing was logged for a while: a full or slow card, a link that was lost.",
        ReasonKind::FrozenTemperature => {
            "Look for why the temperature stood still: a sensor that is read too seldom, or a bus that hangs."
        }
        ReasonKind::CoarseTemperature => {
            "A temperature in coarse steps blurs the curve: take the gyro’s own sensor at its full resolution, or warm slowly."
        }
        ReasonKind::Truncated => "Stop the log before the power goes, and copy the whole file.",
        ReasonKind::NoSensor => {
            "Switch on the logging of the raw gyro and accelerometer with their temperatures, and log again."
        }
        ReasonKind::Step => {
            "Look for what changed when the rate stepped: a supply, a restart, a connector. The curve holds for the level \
             before it."
        }
    }
}
