//! The first pass over a log: how much there is, how warm, whether time runs forwards, and whether the units can be true.

use std::fmt::Write as _;
use std::time::SystemTime;

use imu_logs::wall_clock;

use super::clock::Clock;
use super::plausible::Plausible;
use super::{LogError, LogFault};
use crate::quality::{Reason, ReasonKind, TAKEN_AS};
use crate::table::{Batch, Resolved, Table};
use crate::units::TimeUnit;

/// A log that would be shorter than this by the unit that is guessed may as well be one of some days by the next larger
/// unit: few sensors go through their temperatures in five minutes.
const SHORT_S: f64 = 300.0;

/// No gyro is read more often: the fastest have 32 000 readings a second.
const FASTEST_S: f64 = 1e-5;

/// And no log of its drift is over in less.
const SHORTEST_S: f64 = 1.0;

/// Fewer rows tell nothing of how often they come.
const FEW_ROWS: u64 = 64;

/// What a log has to offer.
#[derive(Debug)]
pub(super) struct Survey {
    /// All rows.
    pub rows: u64,
    /// The times, where there is a column of them.
    pub clock: Clock,
    /// Rows without a time, where there is a column of times.
    timeless_rows: u64,
    /// Whether a time that counts from 1970 is UTC.
    is_utc: bool,
    /// What to know of the time.
    pub notes: Vec<String>,
    /// A unit that was guessed, a file that is cut.
    pub reasons: Vec<Reason>,
}

impl Survey {
    /// Reads the whole log once.
    pub(super) fn of(table: &Table, columns: &Resolved) -> Result<Self, LogError> {
        let mut survey = Self {
            rows: 0,
            clock: Clock::default(),
            timeless_rows: 0,
            is_utc: columns.is_utc,
            notes: Vec::new(),
            reasons: columns.guesses.clone(),
        };
        let mut plausible: Vec<Plausible> = columns.sensors.iter().map(Plausible::new).collect();
        for batch in table.batches(&wanted(columns)).map_err(LogFault::named)? {
            let batch = batch.map_err(LogFault::named)?;
            survey.rows += batch.rows() as u64;
            survey.take_time(&batch, table, columns)?;
            let sensors = columns.sensors.iter().zip(places(columns));
            for (plausible, (sensor, place)) in plausible.iter_mut().zip(sensors) {
                let rates = &batch.columns[place + 1..=place + sensor.rates.len()];
                plausible.take(sensor, &batch.columns[place], rates);
            }
            if let Some(line) = batch.cut_line {
                let text = format!(
                    "the file ends in the middle of line {line}, or without its line feed: that line was left out, for its \
                     last number may be cut short"
                );
                survey.reasons.push(Reason::new(ReasonKind::Truncated, text));
            }
        }
        for (plausible, sensor) in plausible.iter().zip(&columns.sensors) {
            if let Some(fault) = plausible.fault(sensor, table) {
                return Err(table.source().faulty(fault));
            }
            survey.reasons.extend(plausible.doubt(sensor, table));
        }
        survey.settle_unit(table, columns);
        survey.refuse_too_fast(table, columns)?;
        Ok(survey)
    }

    fn take_time(&mut self, batch: &Batch, table: &Table, columns: &Resolved) -> Result<(), LogError> {
        let times = times(batch, columns);
        self.timeless_rows += times.iter().filter(|time| !time.is_finite()).count() as u64;
        for (place, &written) in times.iter().enumerate().filter(|(_, time)| time.is_finite()) {
            self.clock.take(written).map_err(|before| {
                table.source().faulty::<LogFault>(LogFault::TimeBackwards {
                    row: batch.first_row + place as u64 + 1,
                    column: columns.time.map(|column| table.names()[column].clone()).unwrap_or_default(),
                    before,
                    after: written,
                })
            })?;
        }
        Ok(())
    }

    fn settle_unit(&mut self, table: &Table, columns: &Resolved) {
        // That a table has no row is told where it is missed.
        if self.rows == 0 {
            return;
        }
        let Some(time) = columns.time else {
            self.notes.push("no time column was found (`time` says which)".to_owned());
            return;
        };
        let name = &table.names()[time];
        if !self.clock.moves() {
            let how = if self.clock.has_numbers() { "does not move" } else { "has no numbers" };
            let text = format!("'{name}' {how}: taken as no time (`time` names another column)");
            self.reasons.push(Reason::new(ReasonKind::MissingValues, text));
            return;
        }
        if self.timeless_rows > 0 {
            let text = format!(
                "'{name}' has no number in {} of {} rows: they count where they stand between the others",
                self.timeless_rows, self.rows
            );
            self.reasons.push(Reason::new(ReasonKind::MissingValues, text));
        }
        if self.clock.was_full() {
            self.notes
                .push(format!("'{name}' starts anew where a counter of 32 bits is full; it is counted on from there"));
        }
        let guessed = self.clock.settle(columns.time_unit);
        if !self.clock.is_known() {
            self.notes.push(format!("'{name}' names no unit and the log's length fits none (`time_unit` says which)"));
        }
        if let (None, Some(unit)) = (columns.time_unit, guessed) {
            let lasts_s = self.clock.lasts_without_gaps(0.0) * unit.seconds();
            let mut text = format!(
                "'{name}' {TAKEN_AS} {unit}, by which the log lasts {lasts_s:.0} s (`time_unit` says otherwise)"
            );
            let larger = unit.larger().filter(|_| lasts_s < SHORT_S);
            if let Some(larger) = larger {
                let _ = write!(
                    text,
                    "; in {larger} it would be {:.0} h",
                    lasts_s * larger.seconds() / unit.seconds() / 3600.0
                );
            }
            let kind = if larger.is_some() { ReasonKind::GuessedUnit } else { ReasonKind::AssumedUnit };
            self.reasons.push(Reason::new(kind, text));
        }
    }

    /// When the first row was taken, where its time counts from 1970: seconds from a start are too few for that.
    pub(super) fn started(&self) -> Option<SystemTime> {
        // No time is 0, and what is too large is larger still: neither is a time of a clock.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let utc_us = self.clock.first_us() as u64;
        wall_clock(utc_us).filter(|_| self.is_utc)
    }

    /// The mean time between rows but for the gaps, seconds; NaN if not known.
    pub(super) fn step_s(&self) -> f64 {
        self.clock.step_s(self.rows)
    }

    /// Refuses a unit by which rows come faster than from any gyro, or all in less than a second: the column's name is wrong
    /// about it.
    fn refuse_too_fast(&self, table: &Table, columns: &Resolved) -> Result<(), LogError> {
        let (Some(time), Some(unit)) = (columns.time, columns.time_unit) else { return Ok(()) };
        let lasts = self.clock.lasts_without_gaps(0.0);
        let is_too_fast = lasts > 0.0 && (self.step_s() < FASTEST_S || lasts * unit.seconds() < SHORTEST_S);
        if columns.is_time_unit_asked || self.rows < FEW_ROWS || !is_too_fast {
            return Ok(());
        }
        Err(table.source().faulty(LogFault::DoubtfulTime {
            column: table.names()[time].clone(),
            unit,
            lasts_s: lasts * unit.seconds(),
            rows: self.rows,
            rather: TimeUnit::by_duration(lasts),
        }))
    }
}

/// The columns that every pass reads: of each sensor its temperature and its rates, then time where there is one.
pub(super) fn wanted(columns: &Resolved) -> Vec<usize> {
    let of_sensors = columns
        .sensors
        .iter()
        .flat_map(|sensor| std::iter::once(sensor.temperature).chain(sensor.rates.iter().map(|rate| rate.column)));
    of_sensors.chain(columns.time).collect()
}

/// Where each sensor's temperature lies among the wanted columns; its rates follow.
pub(super) fn places(columns: &Resolved) -> impl Iterator<Item = usize> {
    columns.sensors.iter().scan(0, |next, sensor| {
        let place = *next;
        *next += 1 + sensor.rates.len();
        Some(place)
    })
}

/// The times of a batch of the wanted columns; empty without a time column.
pub(super) fn times<'a>(batch: &'a Batch, columns: &Resolved) -> &'a [f64] {
    match columns.time {
        Some(_) => batch.columns.last().map_or(&[], Vec::as_slice),
        None => &[],
    }
}
