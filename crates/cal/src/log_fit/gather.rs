//! From logs to the groups of every sensor wanted.

use std::time::SystemTime;
use zerorate_fit::filled::Filled;
use zerorate_fit::fingerprint::Fingerprint;
use zerorate_fit::spacing::Spacing;
use zerorate_fit::still::{Still, Stillness};

use super::overlap::LogRows;
use super::part::LogPart;
use super::repeated;
use super::{FitOptions, LogFitError};
use crate::condition::{GROUP_S, Group, Grouping, Length, MIN_GROUPS, Tally};
use crate::log::{LogFile, Rows, Sensor, SensorKind, Sink, Stream};
use crate::quality::{Reason, ReasonKind};
use crate::source::Source;

/// Between two logs of one unit, so that their times follow one another.
const BETWEEN_LOGS_S: f64 = 60.0;

/// One sensor's groups, of one log or of several.
#[derive(Debug)]
pub(super) struct Gathered {
    pub stream: Stream,
    pub groups: Vec<Group>,
    pub tallies: Vec<Tally>,
    /// The logs that it was joined of, in order.
    pub parts: Vec<LogPart>,
    /// All rows.
    pub rows: u64,
    /// The least change from one row's temperature to another.
    pub temperature_step: f64,
    /// For each axis the least change from one row's rate to another.
    pub rate_steps: Vec<f64>,
    /// For each axis, where it read one number for so long that it measured nothing.
    pub still: Vec<Option<Still>>,
}

/// What was gathered of all logs.
#[derive(Debug, Default)]
pub(super) struct Logs {
    pub sensors: Vec<Gathered>,
    pub notes: Vec<String>,
    pub reasons: Vec<Reason>,
    /// When each log's first row was taken, where it says so.
    pub started: Vec<Option<SystemTime>>,
    /// The autopilot that wrote the logs, if one did.
    pub autopilot: Option<imu_logs::Format>,
    /// The sensors that the logs have, wanted or not.
    pub seen: Vec<Sensor>,
    /// What the rows of each log are known by.
    pub rows: Vec<LogRows>,
    /// The logs without a row.
    empty: Vec<String>,
    /// Uninterrupted logs so far.
    logs: u32,
    end_s: f64,
}

/// Reads logs of one unit, one after the other.
pub(super) fn gather(sources: &[Source], options: &FitOptions) -> Result<Logs, LogFitError> {
    let mut logs = Logs::default();
    for source in sources {
        logs.read(source, sources, options)?;
    }
    // A log alone that is empty is rejected as any log without rows is.
    if sources.len() > 1 {
        let text = |name: String| format!("{name} has no rows of what is fitted and was passed over");
        logs.reasons.extend(logs.empty.drain(..).map(|name| Reason::new(ReasonKind::MissingValues, text(name))));
    }
    Ok(logs)
}

impl Logs {
    fn read(&mut self, source: &Source, sources: &[Source], options: &FitOptions) -> Result<(), LogFitError> {
        let file = LogFile::open(source, &options.columns)?;
        let length = match file.extent() {
            Some((rows, step_s)) => Length::of_extent(rows, step_s, options.group_s),
            None => Length::Seconds(options.group_s.unwrap_or(GROUP_S)),
        };
        let mut taken = Taking::new(options, vec![length], self.logs);
        let mut ending = file.read(&mut taken)?;
        let (shorter, filled) = (taken.shorter(options), taken.filled());
        if shorter.is_some() || filled.iter().flatten().any(Option::is_some) {
            taken = Taking::new(options, shorter.unwrap_or(taken.lengths), self.logs);
            taken.empties = filled.iter().map(|axes| axes.iter().map(Option::is_some).collect()).collect();
            ending = file.read(&mut taken)?;
        }
        let autopilot = file.autopilot();
        let rows = LogRows(taken.sensors.iter_mut().map(|taken| std::mem::take(&mut taken.fingerprint)).collect());
        let (seen, sensors) = taken.finish();
        self.refuse_overlap(source, sources, &rows)?;
        self.reasons.extend(of_filled(source.short_name(), &sensors, &filled));
        let of_sensors = sensors.iter().map(|sensor| (&sensor.stream, &sensor.groups[..]));
        self.reasons.extend(repeated::reasons(source.short_name(), &rows, of_sensors));
        self.rows.push(rows);
        self.started.push(ending.started);
        for note in ending.notes {
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
        if options.sensor.is_some() && sensors.iter().any(|sensor| sensor.stream.sensor.is_none()) {
            self.notes.push(format!(
                "the columns of {} are of no sensor with a number: `sensor` leaves none of them out",
                source.short_name()
            ));
        }
        self.reasons.extend(ending.reasons);
        let name = (sources.len() > 1).then(|| source.short_name().to_owned());
        self.add(source, autopilot, seen, sensors, name)
    }

    /// Refuses a log that shares rows with one before it.
    fn refuse_overlap(&self, source: &Source, sources: &[Source], own: &LogRows) -> Result<(), LogFitError> {
        for (before, theirs) in sources.iter().zip(&self.rows) {
            let names = || (before.name().to_owned(), source.name().to_owned());
            if let Some(part) = own.part_in(theirs) {
                let part = if part < 0.99 { format!("about {:.0} %", (100.0 * part).max(1.0)) } else { "all".into() };
                let (first, second) = names();
                return Err(LogFitError::Overlapping { first, second, part });
            }
            if own.are_copied_from(theirs) {
                let (first, second) = names();
                return Err(LogFitError::Copied { first, second });
            }
        }
        Ok(())
    }

    /// Joins what was gathered of one more log to what was gathered before.
    fn add(
        &mut self,
        source: &Source,
        autopilot: Option<imu_logs::Format>,
        seen: Vec<Sensor>,
        mut sensors: Vec<Gathered>,
        name: Option<String>,
    ) -> Result<(), LogFitError> {
        let first = self.sensors.is_empty() && self.logs == 0;
        for sensor in seen {
            if !self.seen.contains(&sensor) {
                self.seen.push(sensor);
            }
        }
        sensors.retain(|gathered| gathered.rows > 0);
        if sensors.is_empty() {
            self.empty.push(source.short_name().to_owned());
            self.autopilot = if first { autopilot } else { self.autopilot };
            return Ok(());
        }
        let starts_s = self.end_s + if first { 0.0 } else { BETWEEN_LOGS_S };
        for gathered in &mut sensors {
            gathered.parts = vec![LogPart { name: name.clone(), first_row: 0, starts_s }];
        }
        for group in sensors.iter_mut().flat_map(|gathered| &mut gathered.groups) {
            group.time_s += starts_s;
            group.times_s = (group.times_s.0 + starts_s, group.times_s.1 + starts_s);
        }
        let groups = || sensors.iter().flat_map(|gathered| &gathered.groups);
        self.logs = groups().map(|group| group.log + 1).max().unwrap_or(self.logs);
        self.end_s = groups().map(|group| group.times_s.1).fold(self.end_s, f64::max);
        self.autopilot = if first { autopilot } else { self.autopilot.filter(|before| Some(*before) == autopilot) };
        if first {
            self.sensors = sensors;
            return Ok(());
        }
        let others: Vec<Stream> = sensors.iter().map(|gathered| gathered.stream.clone()).collect();
        let mut missing = Vec::new();
        for own in &mut self.sensors {
            match sensors.iter().position(|other| is_same(&own.stream, &other.stream)) {
                Some(place) => own.append(sensors.swap_remove(place), starts_s),
                None => missing.push(describe(&own.stream)),
            }
        }
        // One sensor fewer in one log is told; a log of which nothing fits is another unit's.
        if missing.len() == self.sensors.len() {
            let found = others.iter().map(describe).collect::<Vec<_>>().join(", ");
            return Err(LogFitError::AnotherUnit {
                name: source.name().to_owned(),
                expected: missing.join(", "),
                found,
            });
        }
        let name = source.short_name();
        for sensor in missing {
            self.notes.push(format!("{name} has no rows of {sensor}: it is fitted by the other logs alone"));
        }
        for gathered in sensors {
            self.notes.push(format!(
                "{} of {name} is not in the logs before it and was passed over",
                describe(&gathered.stream)
            ));
        }
        Ok(())
    }
}

/// Whether two logs' sensors are one: by the part's number where both have it, else by kind and place; of tables by the
/// columns' names.
fn is_same(a: &Stream, b: &Stream) -> bool {
    let units = a.unit == b.unit && a.temperature_unit == b.temperature_unit && a.names.len() == b.names.len();
    units
        && match (&a.sensor, &b.sensor) {
            (Some(a), Some(b)) => match (a.device_id, b.device_id) {
                (Some(own), Some(other)) => a.kind == b.kind && own == other,
                _ => (a.kind, a.instance) == (b.kind, b.instance),
            },
            _ => a.names == b.names,
        }
}

fn describe(stream: &Stream) -> String {
    match &stream.sensor {
        Some(Sensor { device_id: Some(id), .. }) => {
            format!("{} (id {id})", stream.sensor.map_or(String::new(), |s| s.to_string()))
        }
        Some(sensor) => sensor.to_string(),
        None => format!("the columns {} in {}", stream.names.join(", "), stream.unit),
    }
}

impl Gathered {
    /// The log that a row belongs to.
    pub(super) fn part(&self, row: u64) -> LogPart {
        self.parts.iter().rfind(|part| part.first_row <= row).cloned().unwrap_or_default()
    }

    /// Appends another log, whose rows are counted and timed from its own start.
    fn append(&mut self, mut next: Self, starts_s: f64) {
        for group in &mut next.groups {
            group.first_row += self.rows;
            group.end_row += self.rows;
        }
        next.parts.iter_mut().for_each(|part| part.first_row += self.rows);
        self.parts.append(&mut next.parts);
        next.still.iter_mut().flatten().for_each(|still| still.come_after(self.rows, starts_s));
        self.groups.append(&mut next.groups);
        self.rows += next.rows;
        self.temperature_step = self.temperature_step.min(next.temperature_step);
        self.rate_steps.iter_mut().zip(next.rate_steps).for_each(|(own, other)| *own = own.min(other));
        for (own, other) in self.still.iter_mut().zip(next.still) {
            *own = own.take().or(other);
        }
        for (own, other) in self.tallies.iter_mut().zip(&next.tallies) {
            other.rejected().iter().for_each(|rejected| own.add(rejected.reason, rejected.count));
        }
    }
}

/// The sensors of one log while it goes by.
struct Taking<'a> {
    options: &'a FitOptions,
    /// One for all, or one a sensor wanted.
    lengths: Vec<Length>,
    log: u32,
    /// For each sensor met, its place among those wanted.
    places: Vec<Option<usize>>,
    sensors: Vec<Taken>,
    seen: Vec<Sensor>,
    /// For each sensor wanted the axes whose zeros are empty cells, where that is known.
    empties: Vec<Vec<bool>>,
}

struct Taken {
    stream: Stream,
    grouping: Grouping,
    fingerprint: Fingerprint,
    stillness: Vec<Stillness>,
    filled: Vec<Filled>,
    rows: u64,
    first_s: f64,
    last_s: f64,
    spacing: Spacing,
}

impl<'a> Taking<'a> {
    fn new(options: &'a FitOptions, lengths: Vec<Length>, log: u32) -> Self {
        let (places, sensors, seen, empties) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { options, lengths, log, places, sensors, seen, empties }
    }

    /// For each axis of the sensors wanted how many zeros were filled into empty cells.
    fn filled(&self) -> Vec<Vec<Option<u64>>> {
        self.sensors.iter().map(|taken| taken.filled.iter().map(Filled::found).collect()).collect()
    }

    /// The sensors that the log has, and the groups of those wanted.
    fn finish(self) -> (Vec<Sensor>, Vec<Gathered>) {
        (self.seen, self.sensors.into_iter().map(Taken::finish).collect())
    }

    /// The lengths of groups by which a log that turned out to be short is to be read again, if any.
    fn shorter(&self, options: &FitOptions) -> Option<Vec<Length>> {
        let is_short = |taken: &Taken| (taken.grouping.len() as u64) < MIN_GROUPS && taken.rows > 1;
        let seconds = self.lengths.iter().any(|length| matches!(length, Length::Seconds(_)));
        (seconds && options.group_s.is_none() && self.sensors.iter().any(is_short)).then(|| {
            let step_s = |taken: &Taken| {
                let (gaps, gaps_s) = taken.spacing.gaps(GROUP_S);
                (taken.last_s - taken.first_s - gaps_s) / (taken.rows.max(2 + gaps) - 1 - gaps) as f64
            };
            let length = |taken: &Taken| Length::of_extent(taken.rows, step_s(taken), None);
            self.sensors.iter().map(length).collect()
        })
    }
}

impl Sink for Taking<'_> {
    fn stream(&mut self, stream: &Stream) -> bool {
        self.seen.extend(stream.sensor);
        let wanted = match (&stream.sensor, self.options.sensor) {
            (Some(sensor), Some(choice)) => choice.takes(sensor),
            _ => true,
        };
        self.places.push(wanted.then_some(self.sensors.len()));
        if wanted {
            let length = self.lengths.get(self.sensors.len()).unwrap_or(&self.lengths[0]);
            let grouping = Grouping::new(stream.names.len(), *length, stream.temperature_unit, self.log);
            let (stillness, filled) =
                (vec![Stillness::default(); stream.names.len()], vec![Filled::default(); stream.names.len()]);
            let (fingerprint, first_s, last_s) = (Fingerprint::default(), f64::NAN, f64::NAN);
            self.sensors.push(Taken {
                stream: stream.clone(),
                grouping,
                fingerprint,
                stillness,
                filled,
                rows: 0,
                first_s,
                last_s,
                spacing: Spacing::default(),
            });
        }
        wanted
    }

    fn rows(&mut self, rows: &Rows<'_>) {
        let Some(place) = self.places[rows.sensor] else { return };
        let Some(taken) = self.sensors.get_mut(place) else { return };
        let emptied = self.empties.get(place).filter(|axes| axes.contains(&true)).map(|axes| emptied(rows, axes));
        let rows = &Rows { values: emptied.as_deref().unwrap_or(rows.values), ..*rows };
        taken.rows += rows.temperature.len() as u64;
        taken.first_s = if taken.first_s.is_nan() { rows.time_s[0] } else { taken.first_s };
        taken.last_s = rows.time_s[rows.time_s.len() - 1];
        rows.time_s.iter().for_each(|time| taken.spacing.push(*time));
        taken.grouping.push_rows(rows);
        taken.fingerprint.push_rows(rows.temperature, rows.values);
        taken.look_for_stillness(rows);
        for (filled, rates) in taken.filled.iter_mut().zip(rows.values) {
            rates.iter().for_each(|rate| filled.push(*rate));
        }
    }
}

/// The rows' values, without the zeros of axes on which they are empty cells.
fn emptied(rows: &Rows<'_>, axes: &[bool]) -> Vec<Vec<f64>> {
    let empty = |value: &f64| if value.abs() <= 0.0 { f64::NAN } else { *value };
    let column = |(values, is_filled): (&Vec<f64>, &bool)| match is_filled {
        true => values.iter().map(empty).collect(),
        false => values.clone(),
    };
    rows.values.iter().zip(axes).map(column).collect()
}

/// What is said of zeros that were taken for empty cells.
fn of_filled<'a>(
    log: &'a str,
    sensors: &'a [Gathered],
    filled: &'a [Vec<Option<u64>>],
) -> impl Iterator<Item = Reason> + 'a {
    let axes = sensors.iter().zip(filled).flat_map(|(sensor, zeros)| sensor.stream.names.iter().zip(zeros));
    axes.filter_map(move |(name, zeros)| {
        let text = format!(
            "{log}: {name} is exactly 0 in {} rows between others that are not, more often than any reading comes again: these were taken \
             for cells that were filled, and left out",
            (*zeros)?
        );
        Some(Reason::new(ReasonKind::MissingValues, text))
    })
}

impl Taken {
    fn look_for_stillness(&mut self, rows: &Rows<'_>) {
        for (stillness, rates) in self.stillness.iter_mut().zip(rows.values) {
            let whole = |(_, (rate, temperature)): &(usize, (&f64, &f64))| rate.is_finite() && temperature.is_finite();
            for (place, (rate, temperature)) in rates.iter().zip(rows.temperature).enumerate().filter(whole) {
                let time_s = rows.time_s.get(place).copied().unwrap_or(f64::NAN);
                stillness.push(rows.first_row + place as u64, *rate, *temperature, time_s);
            }
        }
    }

    fn finish(self) -> Gathered {
        let temperature_step = self.grouping.temperature_step();
        let rate_steps = self.grouping.rate_steps();
        let (groups, tallies) = self.grouping.finish();
        let still = self.stillness.iter().map(Stillness::found).collect();
        Gathered {
            stream: self.stream,
            groups,
            tallies,
            parts: Vec::new(),
            rows: self.rows,
            temperature_step,
            rate_steps,
            still,
        }
    }
}

/// Whether a sensor is an accelerometer: its constant is not known at rest.
pub(super) fn is_accelerometer(stream: &Stream) -> bool {
    stream.sensor.is_some_and(|sensor| sensor.kind == SensorKind::Accelerometer)
}
