//! What conditioning found, in words.

use zerorate_fit::auto::BEYOND;
use zerorate_fit::dropouts::{Shown, jumps_that_stay};
use zerorate_fit::frozen::{Frozen, frozen};
use zerorate_fit::intervals::widest_hole;
use zerorate_fit::still::Still;

use super::FitOptions;
use super::gather::Gathered;
use crate::condition::{
    DropReason, End, Excluded, Group, Levels, Step, Stopped, all_of, dropout_margin, typical_scatter,
};
use crate::log::Stream;
use crate::quality::{Judgement, Reason, ReasonKind};
use crate::units::{RateScale, TemperatureUnit, decimal, from_to};

/// A step of the temperature of this fraction of the least span is coarse.
const COARSE: f64 = 0.02;

/// A rate whose steps are so many times the typical scatter of a group is coarse: of finer steps noise makes most groups scatter
/// by a fifth of a step.
const COARSE_RATE: f64 = 6.0;

/// A rate that never goes over so many steps does not tell a coarse converter from a dead gyro.
const LEAST_STEPS: f64 = 3.0;

/// What to think of a jump that stands out and is small beside the drift.
const LEFT_IN: &str = "it was left in, for a part may jump by itself at some temperature; if something else changed then, the \
                       curve is wrong by it";

/// From so long on a time without rows may be a clock that was set: logs are seldom left open for an hour and go on.
const CLOCK_SET_S: f64 = 3600.0;

/// No log is left open so long.
const MOST_OF_A_LOG_S: f64 = 30.0 * DAY_S;

const DAY_S: f64 = 86_400.0;

/// Puts what conditioning found of an axis into its judgement.
pub(super) fn report(judgement: &mut Judgement, sensor: &Gathered, axis: usize, levels: &Levels, options: &FitOptions) {
    let (stream, tally) = (&sensor.stream, &sensor.tallies[axis]);
    let (name, unit) = (&stream.names[axis], stream.temperature_unit.name());
    use DropReason::{MissingRate, MissingTemperature, Spike, TemperatureSpike};
    for reason in [MissingTemperature, MissingRate, TemperatureSpike, Spike] {
        of_dropped(judgement, stream, axis, reason, tally.count(reason), sensor.rows);
    }
    if is_coarse(sensor) {
        let text = format!(
            "the temperature comes in steps of {:.2} {unit}: a fit interpolates them, and a device corrects by the steps as they are",
            sensor.temperature_step
        );
        judgement.add(Reason::new(ReasonKind::CoarseTemperature, text));
    }
    of_coarse_rate(sensor, axis, options).into_iter().for_each(|reason| judgement.add(reason));
    for interval in &levels.excluded {
        let part = sensor.part(interval.rows.0);
        if let Some(reason) = of_excluded(&part.interval(interval), stream.temperature_unit) {
            judgement.add(part.reason(reason));
        }
    }
    for stopped in levels.stopped.iter().filter(|stopped| stopped.axis == axis) {
        judgement.add(of_stopped(stopped, name, sensor));
    }
    let then = match options.keep_steps {
        true => "it stands in what is left",
        false => "the step was taken out, and the curve holds for the level before it",
    };
    let taken = levels.steps.iter().map(|step| (step, ReasonKind::Step, "steps", then));
    let left_in = levels.left_in.iter().map(|step| (step, ReasonKind::Jump, "jumps", LEFT_IN));
    for (step, kind, does, then) in taken.chain(left_in).filter(|(step, ..)| step.axis == axis) {
        let part = sensor.part(step.row);
        let scale = RateScale::of(stream.unit, &[step.size], options.told_in);
        let text = format!(
            "{}: {then}",
            of_step(
                &part.step(step),
                &format!("{}: the {} {does}", part.axis(name), stream.unit.quantity()),
                scale,
                unit
            )
        );
        judgement.add(Reason::new(kind, text));
    }
}

/// Rows that were dropped. What is wrong with a temperature is wrong with all axes of its sensor, and told once.
pub(super) fn of_dropped(
    judgement: &mut Judgement,
    stream: &Stream,
    axis: usize,
    reason: DropReason,
    dropped: u64,
    of: u64,
) {
    let is_of_all = matches!(reason, DropReason::MissingTemperature | DropReason::TemperatureSpike);
    let who = match stream.sensor {
        Some(sensor) if is_of_all => sensor.to_string(),
        None if is_of_all && stream.names.len() > 1 => "every axis".to_owned(),
        _ => stream.names[axis].clone(),
    };
    let (kind, advice) = match reason {
        DropReason::Spike | DropReason::TemperatureSpike => {
            (ReasonKind::Spikes, "; look for a loose connection or a disturbed bench")
        }
        _ => (ReasonKind::MissingValues, ""),
    };
    judgement.dropped(kind, &who, &format!("{}{advice}", reason.words()), dropped, of);
}

/// An axis whose rows have numbers, of which conditioning kept none.
pub(super) fn of_nothing_kept(sensor: &Gathered, axis: usize) -> Option<Reason> {
    let tally = &sensor.tallies[axis];
    let missing = tally.count(DropReason::MissingTemperature) + tally.count(DropReason::MissingRate);
    let whole = sensor.rows.saturating_sub(missing);
    let text = || {
        format!(
            "{}: all {whole} rows with a temperature and a rate were left out: nothing that could be fitted is left",
            sensor.stream.names[axis]
        )
    };
    (whole > 0).then(|| Reason::new(ReasonKind::TooFewGroups, text()))
}

/// The widest hole among the temperatures that were measured, where a curve is drawn over more of it than it is believed
/// past an end, from either side.
pub(super) fn of_hole(temperatures: impl Iterator<Item = f64>, unit: &str) -> Option<Reason> {
    let (hole, span) = widest_hole(temperatures.collect())?;
    let text = || {
        format!(
            "no average lies between {} and {} {unit}: there the curve is a guess; add a log that \
             goes through it",
            decimal(hole.0, 1),
            decimal(hole.1, 1)
        )
    };
    (hole.1 - hole.0 > 2.0 * BEYOND * span).then(|| Reason::new(ReasonKind::Unmeasured, text()))
}

/// What is wrong with a sensor's temperature that no row can be blamed for: a jump that stays, and a stop while the rates go on.
pub(super) fn of_temperature(sensor: &Gathered) -> Vec<Reason> {
    let unit = sensor.stream.temperature_unit;
    let shown = |group: &Group| Shown { mean: group.temperature, range: group.temperatures, leap: group.leap };
    let mut found = Vec::new();
    for log in sensor.groups.chunk_by(|a, b| a.log == b.log) {
        let shown: Vec<Shown> = log.iter().map(shown).collect();
        for place in jumps_that_stay(&shown, dropout_margin(unit, sensor.temperature_step)) {
            let (group, leap) = (&log[place], log[place].leap);
            // What was left out blurs no curve.
            if group.axes.iter().all(|axis| axis.rows == 0) {
                continue;
            }
            let size = if leap.1 > -leap.0 { leap.1 } else { leap.0 };
            // A jump that is not among the group's own rows is from the last one before it.
            let is_within = 2.0 * (group.temperatures.1 - group.temperatures.0) > size.abs();
            let from = if is_within { group } else { &log[place.saturating_sub(1)] };
            let text = format!(
                "the temperature jumps by {size:+.1} {} from one row to the next {} and stays there, which no part does: one side is \
                 not true, and the curve is wrong by it",
                unit.name(),
                of_groups(sensor, from, group)
            );
            found.push(sensor.part(group.first_row).reason(Reason::new(ReasonKind::TemperatureJump, text)));
        }
        let temperatures: Vec<f64> = log.iter().map(|group| group.temperature).collect();
        if temperatures.iter().fold(f64::NAN, |a, b| a.max(*b)) - temperatures.iter().fold(f64::NAN, |a, b| a.min(*b))
            < unit.min_span()
        {
            continue;
        }
        let rate =
            |axis: usize| move |group: &Group| if group.axes[axis].rows > 0 { group.axes[axis].rate } else { f64::NAN };
        let rates: Vec<Vec<f64>> =
            (0..sensor.stream.names.len()).map(|axis| log.iter().map(rate(axis)).collect()).collect();
        for Frozen { groups, axis, share } in frozen(&temperatures, &rates) {
            let text = format!(
                "the temperature stands still {} while {} changes by {:.0} % of its whole range: its sensor, or the line to it, has \
                 stopped, or the rate drifts in time",
                of_groups(sensor, &log[groups.start], &log[groups.end - 1]),
                sensor.stream.names[axis],
                100.0 * share
            );
            let part = sensor.part(log[groups.start].first_row);
            found.push(part.reason(Reason::new(ReasonKind::FrozenTemperature, text)));
        }
    }
    found
}

/// Where some successive groups are, by the rows and times of their own log.
fn of_groups(sensor: &Gathered, first: &Group, last: &Group) -> String {
    let temperature = all_of(first.temperatures, last.temperatures);
    let (rows, time_s) = ((first.first_row, last.end_row), (first.times_s.0, last.times_s.1));
    let own = sensor.part(first.first_row).interval(&Excluded { reason: DropReason::Gap, rows, time_s, temperature });
    place(own.time_s, own.rows, own.temperature, sensor.stream.temperature_unit.name())
}

/// A step of an axis's converter, where its steps are larger than its noise and its rates lie on several: then it may well read
/// one number for long, and is no dead gyro.
pub(super) fn coarse_step(sensor: &Gathered, axis: usize) -> Option<f64> {
    let rates = || sensor.groups.iter().map(|group| group.axes[axis].rate);
    let range = rates().fold(f64::NAN, f64::max) - rates().fold(f64::NAN, f64::min);
    large_step(sensor, axis).filter(|step| range > LEAST_STEPS * step)
}

/// A step of an axis's converter, where it is larger than its noise.
fn large_step(sensor: &Gathered, axis: usize) -> Option<f64> {
    let step = sensor.rate_steps[axis];
    let scatter = typical_scatter(&sensor.groups, axis);
    (step.is_finite() && step > COARSE_RATE * scatter).then_some(step)
}

/// An axis whose converter's steps are larger than its noise, be its drift over several of them or within one.
fn of_coarse_rate(sensor: &Gathered, axis: usize, options: &FitOptions) -> Option<Reason> {
    // One that stands still is dead, whatever it jumped by before.
    let step = large_step(sensor, axis).filter(|_| sensor.still[axis].is_none())?;
    let scale = RateScale::of(sensor.stream.unit, &[step, step / 2.0], options.told_in);
    let text = || {
        format!(
            "{}: the {} comes in steps of {}, larger than its noise: no average is finer than a step, so that the curve may be off by \
             {} whatever the figures say, and what looks like a jump of a step is the converter's",
            sensor.stream.names[axis],
            sensor.stream.unit.quantity(),
            scale.told(step),
            scale.told(step / 2.0)
        )
    };
    Some(Reason::new(ReasonKind::CoarseRate, text()))
}

/// Whether the temperature comes in steps that a curve feels: a fiftieth of the least span, 0.2 C.
pub(super) fn is_coarse(sensor: &Gathered) -> bool {
    let step = sensor.temperature_step;
    step.is_finite() && step >= COARSE * sensor.stream.temperature_unit.min_span()
}

fn of_excluded(interval: &Excluded, unit: TemperatureUnit) -> Option<Reason> {
    let (kind, what) = match interval.reason {
        DropReason::Rotation => (ReasonKind::Rotation, moved(interval.time_s)),
        DropReason::StartUp => (ReasonKind::StartUp, "the readings settled after the start"),
        DropReason::TemperatureSpike => (ReasonKind::Spikes, "the temperature jumped faster than a part can heat"),
        DropReason::FrozenTemperature => (ReasonKind::FrozenTemperature, "the temperature stood still, then jumped,"),
        DropReason::Gap => {
            let ((from, to), (least, most)) = (interval.time_s, interval.temperature);
            // Between groups it has no rows; within one, those of the group.
            let (before, after) = match interval.rows {
                (row, next) if row == next => (row, next + 1),
                (first, end) => (first + 1, end),
            };
            let text = format!(
                "nothing was logged for {}, from {from:.0} s to {to:.0} s, between rows {before} and {after}, at {} {}: {}",
                lasting(to - from),
                from_to(least, most),
                unit.name(),
                of_gap(to - from, most - least, unit)
            );
            return Some(Reason::new(ReasonKind::Gap, text));
        }
        // A step is told by itself.
        _ => return None,
    };
    let place = place(interval.time_s, interval.rows, interval.temperature, unit.name());
    Some(Reason::new(kind, format!("{what} {place}: these rows were left out")))
}

/// What is said of rows that scatter or deviate as if the unit was moved. Nobody moves one for minutes without end: then it may be its
/// noise.
fn moved((from, to): (f64, f64)) -> &'static str {
    const LONG_S: f64 = 120.0;
    if to - from > LONG_S {
        "the unit was moved or shaken, or its noise is several times larger,"
    } else {
        "the unit was moved"
    }
}

/// Where in a log something is. A log without a time column has rows alone.
fn place(time_s: (f64, f64), rows: (u64, u64), (least, most): (f64, f64), unit: &str) -> String {
    let (first, last) = (rows.0 + 1, rows.1);
    let temperatures = from_to(least, most);
    if time_s.0.is_finite() && time_s.1.is_finite() {
        format!("from {:.0} s to {:.0} s (rows {first} to {last}, {temperatures} {unit})", time_s.0, time_s.1)
    } else {
        format!("in rows {first} to {last} ({temperatures} {unit})")
    }
}

/// An axis that is stuck.
pub(super) fn of_still(still: &Still, name: &str, sensor: &Gathered) -> Reason {
    let (part, stream) = (sensor.part(still.rows.0), &sensor.stream);
    let (still, name) = (part.still(still), part.axis(name));
    let place = place(still.time_s, still.rows, still.temperature, stream.temperature_unit.name());
    let text = format!(
        "{name}: the {} is {} {} and nothing else {place}: the sensor is dead or stuck, or the wrong column was read",
        stream.unit.quantity(),
        still.rate,
        stream.unit
    );
    Reason::new(ReasonKind::StuckReading, text)
}

/// An axis that read one number for a while.
fn of_stopped(stopped: &Stopped, name: &str, sensor: &Gathered) -> Reason {
    let (part, stream) = (sensor.part(stopped.interval.rows.0), &sensor.stream);
    let interval = part.interval(&stopped.interval);
    let why = match stopped.end {
        Some(End::Least) => {
            "no average is below it: it is the end of what the sensor or its converter can show, or the sensor had stopped"
        }
        Some(End::Greatest) => {
            "no average is above it: it is the end of what the sensor or its converter can show, or the sensor had stopped"
        }
        None => "the sensor, or the line to it, had stopped",
    };
    let text = format!(
        "{}: the {} is {} {} and nothing else {}, without the noise that it has elsewhere, and was left out there; {why}",
        part.axis(name),
        stream.unit.quantity(),
        stopped.rate,
        stream.unit,
        place(interval.time_s, interval.rows, interval.temperature, stream.temperature_unit.name())
    );
    Reason::new(ReasonKind::StoppedReading, text)
}

/// What to think of a time without rows. A unit that stood for hours without rows seldom has the same temperature again to a
/// tenth of the least span; one whose clock was set in the middle of a log has.
fn of_gap(seconds: f64, change: f64, unit: TemperatureUnit) -> &'static str {
    if seconds > CLOCK_SET_S && change < 0.1 * unit.min_span() {
        "the temperature goes on where it was, as if no time had gone by: the clock was set in the middle of the log, or the \
         unit stood still for as long; a drift in time is wrong by it"
    } else if seconds > MOST_OF_A_LOG_S {
        "the clock was set in the middle of the log, or two logs were joined; a drift in time is wrong by it"
    } else {
        "what happened there is not known"
    }
}

/// A time as people say it.
fn lasting(seconds: f64) -> String {
    match seconds {
        short if short < 120.0 => format!("{short:.0} s"),
        minutes if minutes < 7200.0 => format!("{:.0} min", minutes / 60.0),
        hours if hours < 48.0 * 3600.0 => format!("{:.1} h", hours / 3600.0),
        days if days < 700.0 * DAY_S => format!("{:.1} days", days / DAY_S),
        years => format!("{:.1} years", years / (365.25 * DAY_S)),
    }
}

/// Where something (`what_does`) steps or jumps.
fn of_step(step: &Step, what_does: &str, scale: RateScale, unit: &str) -> String {
    format!(
        "{what_does} by {} somewhere {} and stays, with no temperature change to match",
        scale.with_error(step.size, step.error),
        place(step.time_s, step.rows, step.temperature, unit)
    )
}

/// A log without a sensor that is wanted.
pub(super) fn no_sensor(seen: &[String], of_autopilot: bool) -> String {
    if !of_autopilot && seen.is_empty() {
        "the table has no row of numbers".into()
    } else if seen.is_empty() {
        "the log has no row of a gyro or an accelerometer with a temperature: switch on the logging of raw sensors"
            .into()
    } else {
        format!("the log has no rows of the sensor asked for: it has {}", seen.join(", "))
    }
}
