//! Rows averaged to groups, without those that are no drift.

use super::{DropReason, Tally};
use crate::log::Rows;
use crate::units::TemperatureUnit;
use zerorate_fit::crowding::weights;
use zerorate_fit::robust::median;
use zerorate_fit::spikes::{MIN_SEARCHED, outliers_beyond_steps, outliers_off_the_way};

/// The time a group should take: long against noise, short against a thermal time constant.
pub const GROUP_S: f64 = 10.0;

/// Rows in a group, at least, where the log is long enough: below it a median absolute deviation means little.
pub const MIN_GROUP_ROWS: u64 = 21;

/// Groups in a log, at least: a short log has shorter groups instead.
pub const MIN_GROUPS: u64 = 64;

/// Groups in a log, at most, so that memory stays bounded: a long log has longer groups instead.
const MAX_GROUPS: u64 = 20_000;

/// The same where a length was asked for: of ten seconds, three weeks.
const MAX_ASKED_GROUPS: u64 = 200_000;

/// Rows in a group, at most, whatever their times, so that memory stays bounded.
pub const MAX_GROUP_ROWS: u64 = 1 << 16;

/// A time between rows of as many groups, or of as many [`GROUP_S`], is a gap, and ends a group.
const GAP: f64 = 1.5;

/// Where rows come more often or more rarely than on average a group is shorter or longer by this at most: what looks at
/// groups as neighbours wants them of about one length.
const UNEVEN: f64 = 1.5;

/// A temperature spike is also further than this share of the least span from the median: 1 C.
pub const TEMPERATURE_SPIKE: f64 = 0.1;

/// And further than so many steps of a coarse sensor: by the side of a step what is less is rounding.
const STAIR: f64 = 1.5;

/// One axis's part of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisGroup {
    /// Mean rate of the rows kept; NaN without any.
    pub rate: f64,
    /// Standard deviation of the rows kept; NaN for fewer than two.
    pub scatter: f64,
    /// Rows kept; 0 where the group was left out, though its rate is still there to be drawn.
    pub rows: u32,
    /// How much the group counts in a fit, so that each degree of the temperature range counts alike: 1 on average over
    /// the groups kept, 0 for one that was left out.
    pub weight: f64,
}

/// Some successive rows, averaged. Its time and temperature hold even where no rate was kept, for a history of
/// temperature runs through what was left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Which uninterrupted log it belongs to, counted from 0: history begins anew with each.
    pub log: u32,
    /// The first row, from 0.
    pub first_row: u64,
    /// The row after the last.
    pub end_row: u64,
    /// Mean time, seconds from the first log's first row; NaN without a time column.
    pub time_s: f64,
    /// Its first and last row's time.
    pub times_s: (f64, f64),
    /// The longest time from one row to the next; 0 of a single row, and without times.
    pub widest_s: f64,
    /// Mean temperature of the rows kept, in the column's unit; NaN without any. Of those that have a rate, if any does: a
    /// rate is not of a temperature that was read when it was not. So is the mean time.
    pub temperature: f64,
    /// By how much that was moved to interpolate coarse steps; 0 else.
    pub interpolated: f64,
    /// The least and greatest temperature of the same rows; NaN without any.
    pub temperatures: (f64, f64),
    /// The largest fall (below 0) and rise of the temperature from one row kept to the next, from the group before to this
    /// one among them; across a time that a part may heat in, and across a log's start, there is none.
    pub leap: (f64, f64),
    /// One part a rate column.
    pub axes: Vec<AxisGroup>,
}

/// When a group is full.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Length {
    /// After so many rows, or before a gap.
    Rows {
        /// So many.
        rows: u64,
        /// The time from one to the next on average, seconds; NaN if not known.
        step_s: f64,
    },
    /// After so many seconds, and not before as many rows as tell a spike.
    Seconds(f64),
}

impl Length {
    /// Groups of a log whose extent is known: so many rows, `step_s` seconds apart on average (NaN if not known).
    /// `asked_s` is the time that was asked for a group, if any; without times nobody can keep to it.
    #[must_use]
    // A count of rows far below 2^53, and above zero.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn of_extent(rows: u64, step_s: f64, asked_s: Option<f64>) -> Self {
        let by_time = |seconds: f64| if step_s > 0.0 { (seconds / step_s).ceil() as u64 } else { 0 };
        let (wanted, most) = match asked_s {
            Some(seconds) if step_s > 0.0 => (by_time(seconds), MAX_ASKED_GROUPS),
            _ => (by_time(GROUP_S).max(MIN_GROUP_ROWS).min(rows / MIN_GROUPS), MAX_GROUPS),
        };
        Self::Rows { rows: wanted.max(rows.div_ceil(most)).max(1), step_s }
    }

    /// Whether a group is less than half as long.
    fn is_short(self, group: &Group) -> bool {
        match self {
            Self::Rows { rows, step_s } => {
                let is_long = 2.0 * (group.times_s.1 - group.times_s.0) >= rows as f64 * step_s;
                2 * (group.end_row - group.first_row) < rows && !is_long
            }
            Self::Seconds(seconds) => 2.0 * (group.times_s.1 - group.times_s.0) < seconds,
        }
    }

    /// A time between rows of so many seconds is a gap.
    fn gap_s(self) -> f64 {
        let seconds = match self {
            Self::Rows { rows, step_s } => rows as f64 * step_s,
            Self::Seconds(seconds) => seconds,
        };
        GAP * seconds.max(GROUP_S)
    }
}

/// Gathers rows into groups.
#[derive(Debug, Clone)]
pub struct Grouping {
    length: Length,
    /// A temperature further than this from its neighbours may be a spike, where the sensor's steps are smaller.
    temperature_margin: f64,
    log: u32,
    part: u32,
    first_row: u64,
    times: Vec<f64>,
    temperatures: Vec<f64>,
    rates: Vec<Vec<f64>>,
    groups: Vec<Group>,
    tallies: Vec<Tally>,
    /// The least change from one temperature to another.
    temperature_step: f64,
    last_temperature: f64,
    /// For each axis the least change from one rate to another, and the last rate.
    rate_steps: Vec<(f64, f64)>,
    /// The time and temperature of the last row kept of this part.
    last_kept: Option<(f64, f64)>,
}

impl Grouping {
    /// An empty grouping of `axes` rates. `log` is the number of the first log in it ([`Group::log`]).
    #[must_use]
    pub fn new(axes: usize, length: Length, unit: TemperatureUnit, log: u32) -> Self {
        Self {
            length,
            temperature_margin: TEMPERATURE_SPIKE * unit.min_span(),
            log,
            part: 0,
            first_row: 0,
            times: Vec::new(),
            temperatures: Vec::new(),
            rates: vec![Vec::new(); axes],
            groups: Vec::new(),
            tallies: vec![Tally::default(); axes],
            temperature_step: f64::INFINITY,
            last_temperature: f64::NAN,
            rate_steps: vec![(f64::INFINITY, f64::NAN); axes],
            last_kept: None,
        }
    }

    /// The least change from one row's temperature to another: the height of a stair of a coarse sensor. Infinite where
    /// none changed.
    #[must_use]
    pub fn temperature_step(&self) -> f64 {
        self.temperature_step
    }

    /// The same of each axis's rate: a step of its converter, where that is coarser than its noise.
    #[must_use]
    pub fn rate_steps(&self) -> Vec<f64> {
        self.rate_steps.iter().map(|(step, _)| *step).collect()
    }

    /// Takes in some rows, in order.
    pub fn push_rows(&mut self, rows: &Rows<'_>) {
        if rows.part != self.part {
            self.close();
            self.part = rows.part;
            self.last_kept = None;
        }
        least_step(rows.temperature, &mut self.temperature_step, &mut self.last_temperature);
        for ((step, last), rates) in self.rate_steps.iter_mut().zip(rows.values) {
            least_step(rates, step, last);
        }
        let mut start = 0;
        while start < rows.temperature.len() {
            let end = start + self.room(&rows.time_s[start..]);
            if end == start {
                self.close();
                continue;
            }
            self.times.extend(&rows.time_s[start..end]);
            self.temperatures.extend(&rows.temperature[start..end]);
            for (column, values) in self.rates.iter_mut().zip(rows.values) {
                column.extend(&values[start..end]);
            }
            start = end;
        }
    }

    /// How many of the next rows belong to the open group; never none of an empty one.
    fn room(&self, times: &[f64]) -> usize {
        let open = self.temperatures.len();
        let place = |rows: u64| usize::try_from(rows).unwrap_or(usize::MAX).saturating_sub(open).min(times.len());
        // So many rows at most; and as soon as it has so many rows and lasts so long, or if it lasts longer still.
        let (most, least, seconds, longest_s) = match self.length {
            Length::Rows { rows, step_s } if step_s > 0.0 => {
                let seconds = rows as f64 * step_s;
                (place(MAX_GROUP_ROWS.max(rows)), place(rows), seconds / UNEVEN, UNEVEN * seconds.max(GROUP_S))
            }
            Length::Rows { rows, .. } => (place(rows), place(rows), 0.0, f64::INFINITY),
            Length::Seconds(seconds) => (place(MAX_GROUP_ROWS), place(MIN_GROUP_ROWS), seconds, f64::INFINITY),
        };
        let first = self.times.first().copied().unwrap_or(times[0]);
        let mut last = self.times.last().copied().unwrap_or(times[0]);
        let mut room = 0;
        for time in &times[..most] {
            // Across a gap a group is not filled up.
            let lasts = time - first;
            // Without a time the rows alone tell.
            let is_full = (room >= least && (lasts >= seconds || lasts.is_nan())) || lasts >= longest_s;
            if time - last >= self.length.gap_s() || is_full {
                break;
            }
            last = *time;
            room += 1;
        }
        room
    }

    /// The groups so far, the open one among them.
    #[must_use]
    pub fn len(&self) -> usize {
        self.groups.len() + usize::from(!self.temperatures.is_empty())
    }

    /// Whether there is no row yet.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The groups, and for each axis the count of rows left out.
    #[must_use]
    pub fn finish(mut self) -> (Vec<Group>, Vec<Tally>) {
        self.close();
        (self.groups, self.tallies)
    }

    fn close(&mut self) {
        let rows = self.temperatures.len();
        if rows == 0 {
            return;
        }
        let missing = self.temperatures.iter().filter(|t| !t.is_finite()).count();
        let are_outliers = outliers_off_the_way(&self.temperatures, self.spike_margin());
        let outlier_count = are_outliers.iter().filter(|is_outlier| **is_outlier).count();
        let usable: Vec<bool> = (0..rows).map(|row| self.temperatures[row].is_finite() && !are_outliers[row]).collect();
        let mut axes = Vec::with_capacity(self.rates.len());
        for ((column, tally), (step, _)) in self.rates.iter_mut().zip(&mut self.tallies).zip(&self.rate_steps) {
            tally.add(DropReason::MissingTemperature, missing as u64);
            tally.add(DropReason::TemperatureSpike, outlier_count as u64);
            if missing + outlier_count > 0 {
                column.iter_mut().zip(&usable).filter(|(_, usable)| !**usable).for_each(|(rate, _)| *rate = f64::NAN);
            }
            let missing_rates = column.iter().zip(&usable).filter(|(rate, usable)| **usable && !rate.is_finite());
            tally.add(DropReason::MissingRate, missing_rates.count() as u64);
            let spikes = outliers_beyond_steps(column, *step);
            let found = spikes.iter().filter(|spike| **spike).count();
            let leading = if self.first_row == 0 { spikes.iter().take_while(|spike| **spike).count() } else { 0 };
            tally.add(DropReason::StartUp, leading as u64);
            tally.add(DropReason::Spike, (found - leading) as u64);
            let kept = column.iter().zip(&spikes).filter(|(rate, spike)| rate.is_finite() && !**spike);
            axes.push(average(kept.map(|(rate, _)| *rate)));
        }
        let leap = self.leap(&usable);
        let has_rate: Vec<bool> =
            (0..rows).map(|row| usable[row] && self.rates.iter().any(|column| column[row].is_finite())).collect();
        let any_has = has_rate.contains(&true);
        let counts = |row: &usize| if any_has { has_rate[*row] } else { usable[*row] };
        let kept = || (0..rows).filter(counts).map(|row| self.temperatures[row]);
        let timed = || (0..rows).filter(|row| !any_has || has_rate[*row]).map(|row| self.times[row]);
        let group = Group {
            log: self.log + self.part,
            first_row: self.first_row,
            end_row: self.first_row + rows as u64,
            time_s: mean(timed().filter(|time| time.is_finite())),
            times_s: (self.times[0], self.times[rows - 1]),
            widest_s: self.times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max),
            temperature: mean(kept()),
            interpolated: 0.0,
            temperatures: kept().fold((f64::NAN, f64::NAN), |(a, b), t| (a.min(t), b.max(t))),
            leap,
            axes,
        };
        let gap_s = self.length.gap_s();
        match self.groups.last_mut() {
            // A few rows are no average like the others: those at the end of a log, or before a gap, belong to the
            // group before.
            Some(before) if self.length.is_short(&group) && group.follows(before, gap_s) => before.join(&group),
            _ => self.groups.push(group),
        }
        self.first_row += rows as u64;
        self.times.clear();
        self.temperatures.clear();
        self.rates.iter_mut().for_each(Vec::clear);
        if self.groups.len() as u64 > 2 * MAX_GROUPS {
            self.halve();
        }
    }

    /// A temperature further than this from its neighbours may be a spike: of a coarse sensor a reading a step away is none.
    fn spike_margin(&self) -> f64 {
        let steps = if self.temperature_step.is_finite() { STAIR * self.temperature_step } else { 0.0 };
        self.temperature_margin.max(steps)
    }

    /// The largest changes of the temperature between rows of the open group ([`Group::leap`]). Without times only a group of
    /// many rows tells that they are close.
    fn leap(&mut self, usable: &[bool]) -> (f64, f64) {
        let mut leap = (0.0_f64, 0.0_f64);
        for row in (0..usable.len()).filter(|row| usable[*row]) {
            let (time, temperature) = (self.times[row], self.temperatures[row]);
            let close = |(before, _): &(f64, f64)| match time - before {
                apart if apart.is_nan() => usable.len() >= MIN_SEARCHED,
                apart => apart < GROUP_S,
            };
            if let Some((_, before)) = self.last_kept.filter(close) {
                leap = (leap.0.min(temperature - before), leap.1.max(temperature - before));
            }
            self.last_kept = Some((time, temperature));
        }
        leap
    }

    /// Joins each two neighbours, and makes the groups to come twice as long.
    fn halve(&mut self) {
        let groups = std::mem::take(&mut self.groups);
        let mut pairs = groups.into_iter().peekable();
        while let Some(mut group) = pairs.next() {
            if let Some(next) = pairs.next_if(|next| next.log == group.log) {
                group.join(&next);
            }
            self.groups.push(group);
        }
        self.length = match self.length {
            Length::Rows { rows, step_s } => Length::Rows { rows: 2 * rows, step_s },
            Length::Seconds(seconds) => Length::Seconds(2.0 * seconds),
        };
    }
}

impl Group {
    /// The temperature that the sensor showed.
    #[must_use]
    pub fn shown(&self) -> f64 {
        self.temperature - self.interpolated
    }

    /// Whether it goes on where another ended, without a gap between them.
    fn follows(&self, before: &Self, gap_s: f64) -> bool {
        let is_gap = self.times_s.0 - before.times_s.1 >= gap_s;
        self.log == before.log && !is_gap
    }

    /// Takes in the group that follows.
    fn join(&mut self, next: &Self) {
        let rows = |group: &Self| (group.end_row - group.first_row) as f64;
        let share = rows(next) / (rows(self) + rows(next));
        let between = |own: f64, other: f64, share: f64| match (own.is_finite(), other.is_finite()) {
            (true, true) => own + share * (other - own),
            (true, false) => own,
            _ => other,
        };
        self.time_s = between(self.time_s, next.time_s, share);
        self.widest_s = self.widest_s.max(next.widest_s).max(next.times_s.0 - self.times_s.1);
        self.times_s.1 = next.times_s.1;
        self.temperature = between(self.temperature, next.temperature, share);
        self.temperatures = all_of(self.temperatures, next.temperatures);
        self.leap = all_of(self.leap, next.leap);
        self.end_row = next.end_row;
        for (own, other) in self.axes.iter_mut().zip(&next.axes) {
            let share = f64::from(other.rows) / f64::from((own.rows + other.rows).max(1));
            own.rate = between(own.rate, other.rate, share);
            own.scatter = between(own.scatter.powi(2), other.scatter.powi(2), share).sqrt();
            own.rows += other.rows;
        }
    }
}

/// Weighs an axis's groups by how crowded their temperatures are ([`weights`]); 1 on average over those kept.
pub fn weigh(groups: &mut [Group], axis: usize) {
    let kept = |group: &&mut Group| group.axes[axis].rows > 0 && group.temperature.is_finite();
    let mut kept: Vec<&mut Group> = groups.iter_mut().filter(kept).collect();
    let found = weights(&kept.iter().map(|group| group.temperature).collect::<Vec<_>>()).unwrap_or_default();
    kept.iter_mut().zip(found).for_each(|(group, weight)| group.axes[axis].weight = weight);
}

/// The least and greatest of two ranges; one that is NaN is none.
pub(crate) fn all_of(one: (f64, f64), other: (f64, f64)) -> (f64, f64) {
    (one.0.min(other.0), one.1.max(other.1))
}

/// Takes in the changes from each value to the next: the least that is one, and the last value.
pub fn least_step(values: &[f64], least: &mut f64, last: &mut f64) {
    for value in values.iter().filter(|value| value.is_finite()) {
        let step = (value - *last).abs();
        if step > 0.0 && step < *least {
            *least = step;
        }
        *last = *value;
    }
}

/// The mean; NaN of nothing.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count)
}

fn average(rates: impl Iterator<Item = f64> + Clone) -> AxisGroup {
    let rate = mean(rates.clone());
    let (squares, rows) = rates.fold((0.0, 0_u32), |(sum, rows), value| (sum + (value - rate).powi(2), rows + 1));
    let weight = f64::from(u8::from(rows > 0));
    AxisGroup { rate, scatter: (squares / (f64::from(rows) - 1.0)).sqrt(), rows, weight }
}

/// The typical scatter of an axis over all groups; NaN where groups are too small to have one.
pub(crate) fn typical_scatter(groups: &[Group], axis: usize) -> f64 {
    let mut scatters: Vec<f64> = groups
        .iter()
        .map(|group| group.axes[axis])
        .filter(|part| part.rows as usize >= MIN_SEARCHED)
        .map(|part| part.scatter)
        .collect();
    median(&mut scatters)
}
