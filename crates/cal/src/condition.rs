//! Conditioning: from the rows of a log to groups of which only drift is left.
//!
//! Rows without numbers, start-up rows and spikes are dropped within a group; groups in which the unit was
//! moved, or the temperature stood still, are left out, and steps of the rate are found and taken out, on the groups
//! ([`level()`]). Everything found is counted and can be shown. What is kept in memory is groups.

mod gap;
mod group;
mod left_out;
mod level;
mod motion;
mod settle;
mod step;
mod stopped;
mod temperature;

use serde::Serialize;

pub use group::{
    AxisGroup, GROUP_S, Group, Grouping, Length, MAX_GROUP_ROWS, MIN_GROUP_ROWS, MIN_GROUPS, TEMPERATURE_SPIKE,
    least_step, weigh,
};
pub(crate) use group::{all_of, mean, typical_scatter};
pub use level::{Levels, leave_out_times, level};
pub use stopped::{End, Stopped, leave_out_stopped};
pub(crate) use temperature::dropout_margin;
pub use temperature::{dequantise, extend_to_the_start, leave_out_untrue_temperatures};

/// Why rows were left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DropReason {
    /// The temperature is no number.
    MissingTemperature,
    /// The rate is no number.
    MissingRate,
    /// Far from their neighbours at the very start of the log.
    StartUp,
    /// A temperature far from its neighbours, or in an interval to which it jumped away.
    TemperatureSpike,
    /// A rate far from its neighbours.
    Spike,
    /// In an interval in which the unit was moved.
    Rotation,
    /// In the group in which the rate stepped.
    Step,
    /// In a group within which nothing was logged for long.
    Gap,
    /// In an interval in which the temperature stood still, and then jumped; or in which a noisy one stood still.
    FrozenTemperature,
    /// In an interval in which the rate was one number although it has noise.
    StoppedRate,
}

impl DropReason {
    /// In words, as they stand behind a count of rows.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::MissingTemperature => "no number for the temperature",
            Self::MissingRate => "no number for the rate",
            Self::StartUp => "start-up, before the readings settle",
            Self::TemperatureSpike => "temperature far from its neighbours",
            Self::Spike => "rate far from its neighbours",
            Self::Rotation => "the unit was moved",
            Self::Step => "the rate stepped",
            Self::Gap => "nothing was logged for a while",
            Self::FrozenTemperature => "the temperature stood still",
            Self::StoppedRate => "the rate was one number, without its noise",
        }
    }
}

/// A count of rows left out for one reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Rejected {
    /// The reason.
    pub reason: DropReason,
    /// Rows.
    pub count: u64,
}

/// Counts of rows left out of one axis.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally(Vec<Rejected>);

impl Tally {
    /// Counts rows; none are not listed.
    pub fn add(&mut self, reason: DropReason, count: u64) {
        if count == 0 {
            return;
        }
        match self.0.iter_mut().find(|rejected| rejected.reason == reason) {
            Some(rejected) => rejected.count += count,
            None => self.0.push(Rejected { reason, count }),
        }
    }

    /// The rows left out for one reason.
    #[must_use]
    pub fn count(&self, reason: DropReason) -> u64 {
        self.0.iter().find(|rejected| rejected.reason == reason).map_or(0, |rejected| rejected.count)
    }

    /// All counts, in the order of the reasons.
    #[must_use]
    pub fn rejected(&self) -> Vec<Rejected> {
        let mut rejected = self.0.clone();
        rejected.sort_by_key(|rejected| rejected.reason);
        rejected
    }
}

/// A contiguous interval of rows that was left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Excluded {
    /// Why.
    pub reason: DropReason,
    /// The first row and the row after the last, from 0, of the first sensor that shows it; of a gap twice the row after it.
    pub rows: (u64, u64),
    /// The time of its first and last row, seconds from the log's first row; NaN without a time column.
    pub time_s: (f64, f64),
    /// The least and greatest temperature of its rows, in the column's unit; of a gap, of the groups beside it.
    pub temperature: (f64, f64),
}

impl Excluded {
    /// Takes in what another sensor shows of the same. Its rows are not this one's: they may be counted otherwise.
    pub(crate) fn widen(&mut self, other: &Self) {
        let both = |own: (f64, f64), other: (f64, f64)| (own.0.min(other.0), own.1.max(other.1));
        self.time_s = both(self.time_s, other.time_s);
        self.temperature = both(self.temperature, other.temperature);
    }
}

/// A jump of one axis's rate that stayed.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// The axis, by its place among the rate columns.
    pub axis: usize,
    /// The first row of the first group after it.
    pub row: u64,
    /// Where it lies: the first row and the row after the last of those between the averages that show it.
    pub rows: (u64, u64),
    /// The times of those, seconds from the log's first row; NaN without a time column.
    pub time_s: (f64, f64),
    /// The temperatures of those, in the column's unit.
    pub temperature: (f64, f64),
    /// After less before, rate units.
    pub size: f64,
    /// The standard error of that, by the noise of the averages around it.
    pub error: f64,
}

impl Step {
    /// Whether a group lies in it, and is of both sides.
    fn holds(&self, group: &Group) -> bool {
        self.rows.0 <= group.first_row && group.end_row <= self.rows.1
    }
}

#[cfg(test)]
pub(crate) mod tests;
