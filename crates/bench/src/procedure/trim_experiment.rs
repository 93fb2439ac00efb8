//! The trim experiment (paper, S8): how the potentiometer moves the reading.
//!
//! The gyros are off; one fine supply feeds both inputs, so both axes are measured at once. At each of 21 voltages about
//! the room reading: the reading at the middle tap, then the tap that brings it nearest to the centre, and the reading
//! there. After that every tap of the working range once, at the room voltage: the part's own unevenness.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};
use zerorate_core::trim::MAX_TAP_OFFSETS;
use zerorate_core::units::{Axis, Celsius, Counts, Taps, Volts};
use zerorate_core::wire::SampleWindow;
use zerorate_fit::trim::{SupplyPoint, TapReading};

use crate::error::BenchError;
use crate::run::{Phase, Recorder, Session};
use crate::setup::ROOM_SOAK;

/// Taps of the first try, to learn what a tap does.
const FIRST_STEP: u16 = 8;
/// A wiper that moves the reading by less than this for the first step is dead, counts.
const LEAST_CHANGE: f64 = 20.0;
/// Tries of the search before it is given up. Each lands within a tap or two where the part is even.
const MOST_TRIES: usize = 12;

/// What the experiment came to.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct TrimMeasurements {
    /// The 21 voltages, X and Y.
    pub points: [Vec<SupplyPoint>; 2],
    /// Every tap of the working range, X and Y.
    pub sweep: [Vec<TapReading>; 2],
}

/// Runs the experiment. `extremes` are the lowest and highest reading that the drift of X and Y comes to: the taps
/// that they need are the working range.
///
/// # Errors
/// [`BenchError`], among them [`BenchError::CentreOutOfReach`].
pub fn run(
    session: &mut Session<'_>,
    extremes: [[Counts; 2]; 2],
    recorder: &mut Recorder,
) -> Result<TrimMeasurements, BenchError> {
    session.begin()?;
    session.soak("room temperature", Celsius(session.setup.chamber.room_c), ROOM_SOAK)?;
    let mut output = |axis| session.patiently(Phase::Supply, recorder, |bench| bench.supply.gyro_output(axis));
    let (x, y) = (output(Axis::X)?, output(Axis::Y)?);
    let room = Volts(f64::midpoint(x.0, y.0));
    session.start(SampleWindow::NONE)?;
    session.phase("trim experiment", 0);
    let measured = measure(session, room, extremes, recorder);
    if measured.is_err() {
        session.record_the_rest(Phase::Supply, recorder)?;
        return measured;
    }
    session.patiently(Phase::Supply, recorder, |bench| bench.supply.connect_gyros())?;
    session.stop()?;
    measured
}

fn measure(
    session: &mut Session<'_>,
    room: Volts,
    extremes: [[Counts; 2]; 2],
    recorder: &mut Recorder,
) -> Result<TrimMeasurements, BenchError> {
    let mut measured = TrimMeasurements::default();
    let trim = &session.setup.trim;
    let (points, span) = (trim.points, trim.span_counts);
    let middle = session.setup.middle();
    let mut per_tap = None;
    for index in 0..points {
        let from_centre = span * (2.0 * f64::from(index) / f64::from(points - 1) - 1.0);
        let supply = room + Volts(from_centre * session.setup.board.input_volts_per_count);
        session.patiently(Phase::Supply, recorder, |bench| bench.supply.feed(supply))?;
        let at_middle = read_at(session, [middle; 2], recorder)?;
        refuse_saturation(session, at_middle, supply)?;
        let slopes = match per_tap {
            Some(slopes) => slopes,
            None => *per_tap.insert(counts_per_tap(session, at_middle, recorder)?),
        };
        let found = search(session, at_middle, slopes, supply, recorder)?;
        session.patiently(Phase::Supply, recorder, |bench| bench.supply.hold())?;
        for axis in Axis::BOTH {
            let (tap, trimmed) = found[axis.index()];
            let at_middle = at_middle[axis.index()];
            measured.points[axis.index()].push(SupplyPoint { supply, at_middle, trimmed, tap });
        }
    }
    session.patiently(Phase::Supply, recorder, |bench| bench.supply.feed(room))?;
    let slopes = per_tap.unwrap_or([1.0; 2]);
    let [x, y] = [0, 1].map(|axis: usize| working_range(session, extremes[axis], slopes[axis]));
    let longest = (x.end() - x.start()).max(y.end() - y.start());
    for step in 0..=longest {
        let taps = [&x, &y].map(|range| Taps::new((range.start() + step).min(*range.end())).unwrap_or(middle));
        let readings = read_at(session, taps, recorder)?;
        for (axis, range) in Axis::BOTH.into_iter().zip([&x, &y]) {
            if range.start() + step <= *range.end() {
                let reading = TapReading { tap: taps[axis.index()], reading: readings[axis.index()] };
                measured.sweep[axis.index()].push(reading);
            }
        }
    }
    session.patiently(Phase::Supply, recorder, |bench| bench.supply.hold())?;
    Ok(measured)
}

/// The taps that bring a drift's readings to the centre, the set-up's margin each side, and the middle tap, from which
/// effects are counted.
fn working_range(session: &Session<'_>, extremes: [Counts; 2], per_tap: f64) -> RangeInclusive<u16> {
    let middle = session.setup.middle().get();
    let margin = session.setup.trim.margin_taps;
    let most = u16::try_from(MAX_TAP_OFFSETS - 1).unwrap_or(0);
    let needed = extremes.map(|reading| {
        let shift = (session.setup.centre() - reading).0 / per_tap;
        let tap = (f64::from(middle) + shift.round()).clamp(0.0, f64::from(Taps::LAST.get()));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped to the part's taps
        {
            tap as u16
        }
    });
    // A drift that needs more taps than a model holds is measured as far as it does, the middle tap among them.
    let first = needed[0].min(needed[1]).saturating_sub(margin).min(middle).max(middle.saturating_sub(most));
    let last = (needed[0].max(needed[1]) + margin).max(middle).min(first + most).min(Taps::LAST.get());
    first..=last
}

/// Writes both wipers, lets the low-pass settle for a group, and averages the set-up's number of groups.
fn read_at(session: &mut Session<'_>, taps: [Taps; 2], recorder: &mut Recorder) -> Result<[Counts; 2], BenchError> {
    let from = session.bench.device.set_taps(taps)?;
    let wanted = session.setup.trim.groups_per_point;
    let mut sums = [0.0; 2];
    let mut taken = 0;
    while taken < wanted {
        let group = session.take(Phase::Supply, recorder)?;
        if group.report.group > from {
            taken += 1;
            for axis in Axis::BOTH {
                if group.report.axes[axis.index()].saturated {
                    return Err(BenchError::Saturated {
                        axis,
                        whence: format!("in the trim experiment, at tap {}", taps[axis.index()].get()),
                        remedy: "Make trim.span_counts smaller, or check board.input_volts_per_count and the line to the converter",
                    });
                }
                sums[axis.index()] += group.zro(axis).0;
            }
        }
    }
    Ok(sums.map(|sum| Counts(sum / f64::from(wanted))))
}

fn refuse_saturation(session: &Session<'_>, readings: [Counts; 2], supply: Volts) -> Result<(), BenchError> {
    const NEAR_THE_END: f64 = 8.0;
    let top = session.setup.full_scale().0;
    for axis in Axis::BOTH {
        let reading = readings[axis.index()].0;
        if !(NEAR_THE_END..=top - NEAR_THE_END).contains(&reading) {
            return Err(BenchError::Saturated {
                axis,
                whence: format!("at a supply of {:.4} V", supply.0),
                remedy: "Make trim.span_counts smaller, or check board.input_volts_per_count",
            });
        }
    }
    Ok(())
}

/// What one tap does, from a first step off the middle.
fn counts_per_tap(
    session: &mut Session<'_>,
    at_middle: [Counts; 2],
    recorder: &mut Recorder,
) -> Result<[f64; 2], BenchError> {
    let stepped = Taps::new(session.setup.middle().get() + FIRST_STEP).unwrap_or(Taps::LAST);
    let there = read_at(session, [stepped; 2], recorder)?;
    let mut slopes = [0.0; 2];
    for axis in Axis::BOTH {
        let change = (there[axis.index()] - at_middle[axis.index()]).0;
        if change.abs() < LEAST_CHANGE {
            return Err(BenchError::WiperDead { axis, change_counts: change, taps: FIRST_STEP });
        }
        slopes[axis.index()] = change / f64::from(FIRST_STEP);
    }
    Ok(slopes)
}

/// The tap of each axis that brings its reading nearest to the centre, and the reading there.
fn search(
    session: &mut Session<'_>,
    at_middle: [Counts; 2],
    per_tap: [f64; 2],
    supply: Volts,
    recorder: &mut Recorder,
) -> Result<[(Taps, Counts); 2], BenchError> {
    let centre = session.setup.centre();
    let middle = session.setup.middle();
    let mut searches = [0, 1].map(|axis| Search::new(middle, at_middle[axis], per_tap[axis], centre));
    for _ in 0..MOST_TRIES {
        if searches.iter().all(|search| search.found.is_some()) {
            break;
        }
        let taps = [0, 1].map(|axis: usize| searches[axis].next);
        let readings = read_at(session, taps, recorder)?;
        for (search, reading) in searches.iter_mut().zip(readings) {
            search.learn(reading);
        }
    }
    let mut found = [(middle, centre); 2];
    for axis in Axis::BOTH {
        let search = &searches[axis.index()];
        let near = search.per_tap.abs();
        found[axis.index()] =
            search.found.filter(|(_, reading)| (*reading - centre).0.abs() <= near).ok_or_else(|| {
                let (tap, reading) = search.nearest();
                BenchError::CentreOutOfReach {
                    axis,
                    supply_v: supply.0,
                    centre_counts: centre.0,
                    tap,
                    reading_counts: reading.0,
                }
            })?;
    }
    Ok(found)
}

/// One axis's search: jump by what is known of a tap, then look at the neighbours until the nearest is bracketed.
struct Search {
    centre: Counts,
    per_tap: f64,
    tried: Vec<(Taps, Counts)>,
    next: Taps,
    found: Option<(Taps, Counts)>,
}

impl Search {
    fn new(middle: Taps, at_middle: Counts, per_tap: f64, centre: Counts) -> Self {
        let mut search = Self { centre, per_tap, tried: vec![(middle, at_middle)], next: middle, found: None };
        search.next = search.jump((middle, at_middle));
        search
    }

    fn learn(&mut self, reading: Counts) {
        if self.found.is_some() {
            return;
        }
        self.tried.push((self.next, reading));
        let nearest = self.nearest();
        let jump = self.jump(nearest);
        if !self.was_tried(jump) {
            self.next = jump;
            return;
        }
        // The nearest is where the line leads: it stands if the neighbour beyond the centre is further away.
        let below = (nearest.1 - self.centre).0 * self.per_tap < 0.0;
        match neighbour(nearest.0, below).filter(|&beyond| !self.was_tried(beyond)) {
            Some(beyond) => self.next = beyond,
            None => self.found = Some(nearest),
        }
    }

    fn jump(&self, (tap, reading): (Taps, Counts)) -> Taps {
        let shift = ((self.centre - reading).0 / self.per_tap).round();
        let target = (f64::from(tap.get()) + shift).clamp(0.0, f64::from(Taps::LAST.get()));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped to the part's taps
        Taps::new(target as u16).unwrap_or(tap)
    }

    fn was_tried(&self, tap: Taps) -> bool {
        self.tried.iter().any(|&(tried, _)| tried == tap)
    }

    fn nearest(&self) -> (Taps, Counts) {
        let distance = |&&(_, reading): &&(Taps, Counts)| (reading - self.centre).0.abs();
        let by_distance = |a: &&(Taps, Counts), b: &&(Taps, Counts)| distance(a).total_cmp(&distance(b));
        // The middle was tried before anything else.
        self.tried.iter().min_by(by_distance).copied().unwrap_or((self.next, self.centre))
    }
}

fn neighbour(tap: Taps, above: bool) -> Option<Taps> {
    if above { Taps::new(tap.get() + 1) } else { tap.get().checked_sub(1).and_then(Taps::new) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn searched(at_middle: f64, effect: impl Fn(Taps) -> f64) -> (u16, usize) {
        let mut search = Search::new(Taps::MIDDLE, Counts(at_middle), 30.0, Counts(8200.0));
        let mut tries = 0;
        while search.found.is_none() {
            tries += 1;
            assert!(tries <= MOST_TRIES);
            search.learn(Counts(at_middle + effect(search.next)));
        }
        (search.found.unwrap().0.get(), tries)
    }

    #[test]
    fn the_search_ends_at_the_nearest_tap_of_an_uneven_part() {
        for offset in -40..=40 {
            let at_middle = 8200.0 + 25.0 * f64::from(offset);
            let effect = |tap: Taps| {
                let n = f64::from(tap.get()) - 511.0;
                31.26 * (n + 0.2 * (n * 1.7).sin())
            };
            let (found, _) = searched(at_middle, effect);
            let distance = |tap: u16| (at_middle + effect(Taps::new(tap).unwrap()) - 8200.0).abs();
            let best = (400..=620).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap();
            assert_eq!(found, best, "from {at_middle}");
        }
    }
}
