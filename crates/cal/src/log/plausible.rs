//! Whether a table's numbers can be in the units that they are taken for.

use super::LogFault;
use crate::quality::{Reason, ReasonKind, is_celsius};
use crate::table::{ResolvedSensor, Table};
use crate::units::{RateUnit, TemperatureUnit, WrittenTemperature};
use zerorate_fit::rest::Spread;

/// More than this share of temperatures beyond what a gyro sees are no damaged rows: the unit is another.
const BEYOND: f64 = 0.02;

/// Above this, degrees C, a temperature whose unit is guessed may be of another: MEMS gyros are rated to 85, few to 105, and
/// Fahrenheit's degrees of a warm room are below it.
const HOTTEST_GUESSED_C: f64 = 90.0;
/// No unit is advised that would make a temperature hotter than this, degrees C: the hottest rating is 125. A column of degrees
/// C that goes on in kelvin would be hotter in Fahrenheit's.
const HOTTEST_ADVISED_C: f64 = 130.0;
/// Degrees of any unit are below this; an A/D's counts go beyond.
const MOST_DEGREES: f64 = 500.0;

/// One sensor's numbers while they go by.
pub(super) struct Plausible {
    temperatures: u64,
    beyond: u64,
    /// Those above [`HOTTEST_GUESSED_C`].
    hot: u64,
    min: f64,
    max: f64,
    /// Of each axis, where the unit of rates was guessed.
    rates: Vec<Spread>,
}

impl Plausible {
    pub(super) fn new(sensor: &ResolvedSensor) -> Self {
        let guessed = if sensor.is_rate_guessed { sensor.rates.len() } else { 0 };
        let rates = (0..guessed).map(|_| Spread::default()).collect();
        Self { temperatures: 0, beyond: 0, hot: 0, min: f64::INFINITY, max: f64::NEG_INFINITY, rates }
    }

    /// Takes in some rows, temperatures as they are written.
    pub(super) fn take(&mut self, sensor: &ResolvedSensor, temperatures: &[f64], rates: &[Vec<f64>]) {
        for &written in temperatures.iter().filter(|temperature| temperature.is_finite()) {
            self.temperatures += 1;
            let read = sensor.written_temperature.read(written);
            self.beyond += u64::from(!is_celsius(read));
            self.hot += u64::from(read > HOTTEST_GUESSED_C);
            (self.min, self.max) = (self.min.min(written), self.max.max(written));
        }
        if let Some(one) = sensor.rate_unit.in_unit(RateUnit::RadPerS) {
            for ((spread, rate), written) in self.rates.iter_mut().zip(&sensor.rates).zip(rates) {
                spread.take(&written.iter().map(|written| rate.factor * one * written).collect::<Vec<_>>());
            }
        }
    }

    /// What speaks against the units.
    pub(super) fn fault(&self, sensor: &ResolvedSensor, table: &Table) -> Option<LogFault> {
        let written = sensor.written_temperature;
        if written.unit() == TemperatureUnit::C && self.beyond as f64 > BEYOND * self.temperatures as f64 {
            return Some(LogFault::NotCelsius {
                column: table.names()[sensor.temperature].clone(),
                min: self.min,
                max: self.max,
                written,
                rather: self.rather(written),
            });
        }
        let place = self.rates.iter().position(Spread::never_rests)?;
        Some(LogFault::DoubtfulRate { column: sensor.rates[place].name.clone(), guessed: sensor.rate_unit })
    }

    /// What makes a unit that was guessed doubtful.
    pub(super) fn doubt(&self, sensor: &ResolvedSensor, table: &Table) -> Option<Reason> {
        let is_hot = self.hot as f64 > BEYOND * self.temperatures as f64;
        let text = || {
            format!(
                "'{}' goes up to {:.0}, and few gyros are rated for more than 85 degrees C: say its unit (`temperature_unit` \
                 fahrenheit, or celsius)",
                table.names()[sensor.temperature],
                self.max
            )
        };
        (sensor.is_temperature_guessed && is_hot).then(|| Reason::new(ReasonKind::GuessedUnit, text()))
    }

    /// The unit in which the temperatures would be those of a gyro; `None` where they are in no one unit.
    fn rather(&self, written: WrittenTemperature) -> Option<WrittenTemperature> {
        use WrittenTemperature::{Celsius, Counts, Fahrenheit, Kelvin};
        let fits = |unit: &WrittenTemperature| {
            *unit != written && is_celsius(unit.read(self.min)) && unit.read(self.max) <= HOTTEST_ADVISED_C
        };
        let of_degrees = [Celsius, Kelvin, Fahrenheit].into_iter().find(fits);
        of_degrees.or_else(|| (self.max > MOST_DEGREES).then_some(Counts))
    }
}
