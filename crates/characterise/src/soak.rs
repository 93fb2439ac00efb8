//! The noise of a log, sample by sample: of its longest soak, or of what a calibration leaves of all of it.

mod temperatures;

use serde::Serialize;
use thiserror::Error;
use zerorate_fit::allan::{Allan, NoAllan};
use zerorate_fit::predict::{Predictor, Start};
use zerorate_fit::robust::centre_and_sigma;
use zerorate_fit::spacing::Spacing;

use zerorate_cal::calibration::{AxisCalibration, Calibration};
use zerorate_cal::log::{LogError, LogFile, Rows, SensorChoice, Sink, Stream};
use zerorate_cal::matching::{Known, Unmatched, calibrated, places};
use zerorate_cal::source::{Faulty, Source};
use zerorate_cal::table::Columns;
use zerorate_cal::units::{RateUnit, TemperatureUnit};

use crate::spikes::{Row, Waiting};
use temperatures::{crossings, extremes, longest_soak, smoothed};

/// The temperature of a soak stays within this part of the least span of a calibration: 1 C. At the steepest of common
/// drifts, 1e-3 rad/s a degree, that is a ramp of 1e-3 rad/s at most: below the flicker of parts that drift so much.
pub(crate) const SOAK: f64 = 0.1;

/// A soak lasts this long, at least: a ramp of a degree a minute does not.
const LEAST_SOAK_S: f64 = 120.0;

/// And so many times as long as the rest of the log takes for as much of the temperature: a slow ramp does not, nor the place
/// where it turns round, which takes twice.
const REST: f64 = 3.0;

/// Temperatures at an end of a soak that are further from its median than so many standard deviations are not yet settled, or
/// of the ramp: of normal noise one in 16 000 is.
const SETTLED: f64 = 4.0;

/// Samples kept of one sensor, at most; a longer log is averaged by pairs until it fits.
const MOST: usize = 1 << 17;

/// Between rows of a clock that is not even, so many times the mean period is a gap, if it is so many times as long as is usual.
const GAP: f64 = 5.0;
const UNUSUAL: f64 = 2.0;

/// Lost rows up to so many have a place each among those that wait; a longer gap ends a group.
const MOST_LOST: f64 = 16.0;

/// An even clock is followed by so much of each row's own time: it wanders, and jitters a little.
const FOLLOWS: f64 = 0.1;

/// A gap of more samples than this is kept as so many: no average reaches across it anyway.
const LONGEST_GAP: f64 = 10_000.0;

/// What the noise is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseOf {
    /// The longest time at constant temperature, as recorded.
    Soak,
    /// The whole log, less a calibration's bias.
    Residual,
}

/// The noise of one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxisNoise {
    /// The axis's name.
    pub name: String,
    /// The unit of all rates.
    pub rate_unit: RateUnit,
    /// What it is of.
    pub of: NoiseOf,
    /// When, seconds from the log's first row.
    pub time_s: [f64; 2],
    /// The least and the greatest temperature then, over averages of some samples.
    pub temperature: [f64; 2],
    /// Samples of that time that were left out: the rate is far from its neighbours, as a fit sees it. Another stands in for each.
    pub left_out: u64,
    /// The least change from one row's rate to another: a converter's step, where it has one.
    #[serde(skip)]
    pub step: f64,
    /// The Allan deviation, or why there is none.
    #[serde(serialize_with = "super::or_reason")]
    pub noise: Result<Allan, String>,
}

/// Why noise cannot be told of.
#[derive(Debug, Error)]
pub enum NoiseError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The calibration is not for the log.
    #[error(transparent)]
    Unmatched(#[from] Faulty<Unmatched>),
}

/// The noise of every axis of a log's sensors, of soaks; with a calibration, of the residuals of the axes that it has, which are
/// matched as `verify` matches them.
///
/// # Errors
/// [`NoiseError`]. What has no noise to tell says why in [`AxisNoise::noise`].
pub fn noise(
    log: &Source,
    columns: &Columns,
    sensor: Option<SensorChoice>,
    calibration: Option<&Calibration>,
) -> Result<Vec<AxisNoise>, NoiseError> {
    let file = LogFile::open(log, columns)?;
    // How far apart rows are is known of the whole log.
    let mut paces = Paces::default();
    file.read(&mut paces)?;
    let mut taken = Taking { sensor, paces: paces.0, sensors: Vec::new(), places: Vec::new() };
    file.read(&mut taken)?;
    taken.sensors.iter_mut().for_each(Series::flush);
    let Some(calibration) = calibration else {
        return Ok(taken.sensors.iter().flat_map(Series::of_soaks).collect());
    };
    let logged: Vec<Known<'_>> = taken.sensors.iter().flat_map(Series::known).collect();
    let own = calibrated(calibration, sensor);
    let places = places(&own, &logged).map_err(|error| log.faulty::<Unmatched>(error))?;
    let of_axis = |place: usize| {
        let own = own.iter().zip(&places).find(|(_, of)| **of == Some(place));
        own.map(|(own, _)| (&calibration.axes[own.name], calibration.temperature_unit))
    };
    let mut axes = (0..logged.len()).map(of_axis);
    Ok(taken.sensors.iter().flat_map(|series| series.of_residuals(axes.by_ref().take(series.axes()))).collect())
}

/// The calibration of an axis, and the unit of its temperatures.
type Own<'a> = (&'a AxisCalibration, TemperatureUnit);

/// How far apart the rows of each sensor are.
#[derive(Default)]
struct Paces(Vec<Spacing>);

impl Sink for Paces {
    fn stream(&mut self, _: &Stream) -> bool {
        self.0.push(Spacing::default());
        true
    }

    fn rows(&mut self, rows: &Rows<'_>) {
        rows.time_s.iter().for_each(|time| self.0[rows.sensor].push(*time));
    }
}

/// The sensors of a log while it goes by.
struct Taking {
    sensor: Option<SensorChoice>,
    /// Of each sensor met.
    paces: Vec<Spacing>,
    sensors: Vec<Series>,
    places: Vec<Option<usize>>,
}

impl Sink for Taking {
    fn stream(&mut self, stream: &Stream) -> bool {
        let wanted = match (&stream.sensor, self.sensor) {
            (Some(sensor), Some(choice)) => choice.takes(sensor),
            _ => true,
        };
        self.places.push(wanted.then_some(self.sensors.len()));
        if wanted {
            let pace = self.paces.get(self.places.len() - 1).cloned().unwrap_or_default();
            self.sensors.push(Series::new(stream.clone(), &pace));
        }
        wanted
    }

    fn rows(&mut self, rows: &Rows<'_>) {
        if let Some(series) = self.places[rows.sensor].and_then(|place| self.sensors.get_mut(place)) {
            series.push(rows);
        }
    }
}

/// The sum of some successive rows.
#[derive(Debug, Clone, PartialEq)]
struct Bin {
    time_s: f64,
    temperature: f64,
    values: Vec<f64>,
    /// For each axis the rows left out.
    left_out: Vec<u32>,
}

impl From<Row> for Bin {
    fn from(row: Row) -> Self {
        let left_out = row.left_out.iter().map(|left_out| u32::from(*left_out)).collect();
        Self { time_s: row.time_s, temperature: row.temperature, values: row.values, left_out }
    }
}

impl Bin {
    fn empty(axes: usize) -> Self {
        Self { time_s: 0.0, temperature: 0.0, values: vec![0.0; axes], left_out: vec![0; axes] }
    }

    /// A gap: no number in it.
    fn gap(axes: usize) -> Self {
        Self { time_s: f64::NAN, temperature: f64::NAN, values: vec![f64::NAN; axes], left_out: vec![0; axes] }
    }

    fn add(&mut self, other: &Self) {
        self.time_s += other.time_s;
        self.temperature += other.temperature;
        self.values.iter_mut().zip(&other.values).for_each(|(sum, value)| *sum += value);
        self.left_out.iter_mut().zip(&other.left_out).for_each(|(sum, rows)| *sum += rows);
    }
}

/// One sensor's rows, evenly spaced, averaged as far as they must be to fit.
struct Series {
    stream: Stream,
    waiting: Waiting,
    bins: Vec<Bin>,
    open: Bin,
    /// Rows that were lost and have no place, of gaps longer than [`LONGEST_GAP`].
    unplaced: f64,
    /// Rows in the open bin, and in a full one.
    in_open: usize,
    a_bin: usize,
    rows: u64,
    first_s: f64,
    last_s: f64,
    part: u32,
    /// The period of a clock that is even, and where its last row was due.
    even_s: Option<f64>,
    due_s: f64,
    /// How far apart rows are as a rule.
    usual_s: f64,
}

impl Series {
    fn new(stream: Stream, pace: &Spacing) -> Self {
        let open = Bin::empty(stream.names.len());
        let waiting = Waiting::new(stream.names.len(), stream.temperature_unit);
        let (first_s, last_s) = (f64::NAN, f64::NAN);
        let (even_s, due_s, usual_s) = (pace.even_period(), f64::NAN, pace.usual());
        let (unplaced, in_open, a_bin, rows, part) = (0.0, 0, 1, 0, 0);
        Self {
            stream,
            waiting,
            bins: Vec::new(),
            open,
            unplaced,
            in_open,
            a_bin,
            rows,
            first_s,
            last_s,
            part,
            even_s,
            due_s,
            usual_s,
        }
    }

    fn axes(&self) -> usize {
        self.stream.names.len()
    }

    fn push(&mut self, rows: &Rows<'_>) {
        if rows.part != self.part {
            self.part = rows.part;
            self.gap(1.0);
        }
        for row in 0..rows.temperature.len() {
            let time_s = rows.time_s[row];
            self.lose(time_s, rows.temperature[row]);
            self.wait(time_s, rows.temperature[row], rows.values.iter().map(|column| column[row]).collect());
            self.first_s = if self.first_s.is_nan() { time_s } else { self.first_s };
            self.last_s = time_s;
            self.rows += 1;
        }
    }

    /// Gives the rows that were lost before one of this time their places.
    fn lose(&mut self, time_s: f64, temperature: f64) {
        let lost = match self.even_s {
            Some(period_s) => {
                let due_s = if self.due_s.is_finite() { self.due_s + period_s } else { time_s };
                let lost = ((time_s - due_s) / period_s).round().max(0.0);
                let due_s = due_s + lost * period_s;
                self.due_s = due_s + FOLLOWS * (time_s - due_s);
                lost
            }
            None => {
                let (period_s, apart_s) =
                    ((self.last_s - self.first_s) / (self.rows.max(2) - 1) as f64, time_s - self.last_s);
                let is_gap = self.rows > 10 && apart_s > GAP * period_s && apart_s > UNUSUAL * self.usual_s;
                if is_gap { apart_s / period_s - 1.0 } else { 0.0 }
            }
        };
        if lost > MOST_LOST {
            self.gap(lost);
        } else if lost >= 1.0 {
            // At most 16.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            for _ in 0..lost as usize {
                self.wait(time_s, temperature, vec![f64::NAN; self.axes()]);
            }
        }
    }

    fn wait(&mut self, time_s: f64, temperature: f64, values: Vec<f64>) {
        let told = self.waiting.push(time_s, temperature, values);
        told.into_iter().for_each(|row| self.row(&row.into()));
    }

    /// Takes in the rows that wait.
    fn flush(&mut self) {
        let told = self.waiting.finish();
        told.into_iter().for_each(|row| self.row(&row.into()));
    }

    /// Passes over so many rows that are not there.
    // At most 10 000.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn gap(&mut self, rows: f64) {
        self.flush();
        let gap = Bin::gap(self.axes());
        let placed = rows.clamp(1.0, LONGEST_GAP).floor();
        self.unplaced += rows.max(1.0) - placed;
        for _ in 0..placed as usize {
            self.row(&gap);
        }
    }

    fn row(&mut self, row: &Bin) {
        self.open.add(row);
        self.in_open += 1;
        if self.in_open < self.a_bin {
            return;
        }
        let empty = Bin::empty(self.axes());
        let full = std::mem::replace(&mut self.open, empty);
        self.in_open = 0;
        self.bins.push(full);
        if self.bins.len() == MOST {
            for pair in 0..MOST / 2 {
                let mut sum = self.bins[2 * pair].clone();
                sum.add(&self.bins[2 * pair + 1]);
                self.bins[pair] = sum;
            }
            self.bins.truncate(MOST / 2);
            self.a_bin *= 2;
        }
    }

    fn mean(&self, sum: f64) -> f64 {
        sum / self.a_bin as f64
    }

    fn known(&self) -> impl Iterator<Item = Known<'_>> {
        let Stream { sensor, unit, .. } = self.stream;
        self.stream.names.iter().map(move |name| Known { name, sensor, unit })
    }

    fn temperatures(&self) -> Vec<f64> {
        smoothed(&self.bins.iter().map(|bin| self.mean(bin.temperature)).collect::<Vec<_>>())
    }

    fn of_soaks(&self) -> Vec<AxisNoise> {
        let temperatures = self.temperatures();
        (0..self.axes()).map(|axis| self.of_soak(axis, &temperatures)).collect()
    }

    /// Of the axes that have a calibration of their `own`, with the unit of its temperatures.
    fn of_residuals<'a>(&self, own: impl Iterator<Item = Option<Own<'a>>>) -> Vec<AxisNoise> {
        let temperatures = self.temperatures();
        own.enumerate().filter_map(|(axis, own)| Some(self.of_residual(axis, &temperatures, own?))).collect()
    }

    fn values(&self, axis: usize) -> Vec<f64> {
        self.bins.iter().map(|bin| self.mean(bin.values[axis])).collect()
    }

    fn of_soak(&self, axis: usize, temperatures: &[f64]) -> AxisNoise {
        let unit = self.stream.temperature_unit;
        let span = SOAK * unit.min_span();
        let (from, to) = longest_soak(temperatures, span);
        let around = [&temperatures[..from], &temperatures[to..]];
        let crossed: usize = around.iter().map(|part| crossings(part, span)).sum();
        let (soak, rest) = ((to - from) as f64, (temperatures.len() - (to - from)) as f64);
        let is_ramp = crossed > 0 && soak < REST * rest / crossed as f64;
        let (from, to) = if is_ramp { (from, to) } else { self.settled(from, to, temperatures) };
        let mut found = self.describe(axis, NoiseOf::Soak, from, to, temperatures);
        let [start_s, end_s] = found.time_s;
        found.noise = if end_s - start_s >= LEAST_SOAK_S && !is_ramp {
            Allan::of_soak(&self.values(axis)[from..to], &temperatures[from..to], self.period_s())
                .map_err(|error| error.to_string())
        } else {
            let [min, max] = extremes(temperatures);
            let error = if start_s.is_finite() {
                NoAllan::Ramp { min, max, unit: unit.name() }
            } else {
                NoAllan::NoPeriod { period_s: f64::NAN }
            };
            Err(error.to_string())
        };
        found
    }

    fn of_residual(&self, axis: usize, temperatures: &[f64], (own, unit): Own<'_>) -> AxisNoise {
        let mut found = self.describe(axis, NoiseOf::Residual, 0, temperatures.len(), temperatures);
        if unit != self.stream.temperature_unit {
            let (log, own) = (self.stream.temperature_unit.name(), unit.name());
            found.noise = Err(format!(
                "the log's temperatures are in {log}, and the calibration's in {own}: name the column that has them in {own} (`temperature`)"
            ));
            return found;
        }
        let Some(of_own) = own.rate_unit.in_unit(self.stream.unit) else {
            let (log, own) = (self.stream.unit, own.rate_unit);
            found.noise =
                Err(format!("the log is in {log}, and the calibration in {own}: say which it is (`rate_unit`)"));
            return found;
        };
        let mut predictor = Predictor::new(&own.fit.model, Start::Unknown);
        let values = self.values(axis);
        let residuals: Vec<f64> = (0..values.len())
            .map(|place| {
                let time_s = self.mean(self.bins[place].time_s);
                values[place] - of_own * predictor.predict(time_s, temperatures[place]).bias
            })
            .collect();
        found.noise = Allan::of(&residuals, self.period_s()).map_err(|error| error.to_string());
        found
    }

    /// Time from one bin to the next, seconds.
    fn period_s(&self) -> f64 {
        // Gaps are in the series as places without a number, but for what is longer than a gap may be: its places are evenly spaced.
        let places = (self.bins.len() * self.a_bin) as f64 + self.unplaced;
        (self.last_s - self.first_s) / (places - 1.0).max(1.0) * self.a_bin as f64
    }

    /// A soak less the ends at which its temperature still moves: the ramps beside it and the approach, which are within a
    /// degree too. No shorter than a soak lasts.
    fn settled(&self, mut from: usize, mut to: usize, temperatures: &[f64]) -> (usize, usize) {
        loop {
            let finite: Vec<f64> = temperatures[from..to].iter().copied().filter(|t| t.is_finite()).collect();
            let (centre, sigma) = centre_and_sigma(&finite);
            let is_settled = |t: &f64| (t - centre).abs() <= SETTLED * sigma;
            let soak = &temperatures[from..to];
            let (Some(first), Some(last)) = (soak.iter().position(is_settled), soak.iter().rposition(is_settled))
            else {
                return (from, to);
            };
            let shorter = (from + first, from + last + 1);
            let lasts_s = (shorter.1 - shorter.0) as f64 * self.period_s();
            if shorter == (from, to) || lasts_s < LEAST_SOAK_S {
                return (from, to);
            }
            (from, to) = shorter;
        }
    }

    fn describe(&self, axis: usize, of: NoiseOf, from: usize, to: usize, temperatures: &[f64]) -> AxisNoise {
        let times = || self.bins[from..to].iter().map(|bin| self.mean(bin.time_s)).filter(|time| time.is_finite());
        AxisNoise {
            name: self.stream.names[axis].clone(),
            rate_unit: self.stream.unit,
            of,
            time_s: [times().next().unwrap_or(f64::NAN), times().next_back().unwrap_or(f64::NAN)],
            temperature: extremes(&temperatures[from..to]),
            left_out: self.bins[from..to].iter().map(|bin| u64::from(bin.left_out[axis])).sum(),
            step: self.waiting.step(axis),
            noise: Err(String::new()),
        }
    }
}

#[cfg(test)]
mod tests;
