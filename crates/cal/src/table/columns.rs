//! Which column is which, and in what unit: as asked for, or by the names where they make it plain.

mod gyros;

use std::fmt::Display;

use imu_logs::{Sensor, SensorKind};

use super::words::{
    Said, ends_in_time, is_bare_axis, is_rate, is_temperature, is_time, names_axis, numbers, other_unit, rate_unit,
    temperature_unit, time_unit, words,
};
use super::{Table, TableError, TableFault};
use crate::quality::{Reason, ReasonKind, TAKEN_AS};
use crate::units::{RateUnit, TimeUnit, WrittenRate, WrittenTemperature};
use gyros::Gyro;

/// What was asked for; whatever is left open is guessed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Columns {
    /// The time column's name.
    pub time: Option<String>,
    /// The temperature column's name.
    pub temperature: Option<String>,
    /// The rate columns' names; empty to guess.
    pub rates: Vec<String>,
    /// The time column's unit.
    pub time_unit: Option<TimeUnit>,
    /// The temperature columns' unit.
    pub temperature_unit: Option<WrittenTemperature>,
    /// The rate columns' unit, whatever their names say.
    pub rate_unit: Option<WrittenRate>,
    /// The rate columns' unit where no name says one, and it is known all the same.
    pub else_rate_unit: Option<WrittenRate>,
    /// The unit to guess where nobody knows it, in place of rad/s.
    pub likely_rate_unit: Option<WrittenRate>,
}

/// Which column is which.
#[derive(Debug, Clone, PartialEq)]
pub struct Resolved {
    /// The place of the time column; a log may have none.
    pub time: Option<usize>,
    /// The time's unit where it was given or the table says it; otherwise [`TimeUnit::by_duration`] decides.
    pub time_unit: Option<TimeUnit>,
    /// Whether it was given, and is believed against the column's name.
    pub is_time_unit_asked: bool,
    /// Whether times that count from 1970 are UTC: not where the table writes times of no zone.
    pub is_utc: bool,
    /// The sensors, at least one.
    pub sensors: Vec<ResolvedSensor>,
    /// What to know about how columns were taken, a sentence each.
    pub notes: Vec<String>,
    /// The units that were guessed.
    pub guesses: Vec<Reason>,
}

/// The columns of one sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct ResolvedSensor {
    /// Which gyro it is, where the table has several.
    pub sensor: Option<Sensor>,
    /// The place of the temperature column.
    pub temperature: usize,
    /// The unit in which that is written.
    pub written_temperature: WrittenTemperature,
    /// Whether nothing says that unit.
    pub is_temperature_guessed: bool,
    /// The rate columns, at least one.
    pub rates: Vec<ResolvedRate>,
    /// The unit of all rates once they are read.
    pub rate_unit: RateUnit,
    /// Whether nothing says that unit: then the numbers may speak against it.
    pub is_rate_guessed: bool,
}

/// A rate column.
#[derive(Debug, Clone, PartialEq)]
pub struct ResolvedRate {
    /// Its place.
    pub column: usize,
    /// Its name.
    pub name: String,
    /// One of what is written in it, in the sensor's unit of rates.
    pub factor: f64,
}

impl Columns {
    /// Whether something was asked for that only a table has.
    pub(crate) fn is_of_a_table(&self) -> bool {
        Self { else_rate_unit: None, likely_rate_unit: None, ..self.clone() } != Self::default()
    }

    /// Finds the columns of a table.
    ///
    /// # Errors
    /// When a column asked for is not there, or the names do not make it plain: the error lists the columns and the
    /// option that says which.
    pub fn resolve(&self, table: &Table) -> Result<Resolved, TableError> {
        Names::of(table).resolve(self)
    }
}

/// A table's columns by what their names say.
struct Names<'a> {
    table: &'a Table,
    /// The words of each name.
    words: Vec<Vec<String>>,
    /// The words of the unit that stands below it; none of most.
    units: Vec<Vec<String>>,
    /// Both.
    with_units: Vec<Vec<String>>,
}

impl<'a> Names<'a> {
    fn of(table: &'a Table) -> Self {
        let all: Vec<Vec<String>> = table.names().iter().map(|name| words(name)).collect();
        let units: Vec<Vec<String>> = table.units.iter().map(|unit| words(unit)).collect();
        let with_units = all.iter().zip(&units).map(|(name, unit)| [&name[..], unit].concat()).collect();
        Self { table, words: all, units, with_units }
    }

    fn resolve(&self, asked: &Columns) -> Result<Resolved, TableError> {
        let table = self.table;
        let temperatures = match &asked.temperature {
            Some(name) => vec![table.column(name)?],
            None => self.guess_temperatures(),
        };
        if temperatures.is_empty() {
            return Err(self.unclear("temperature", &[]));
        }
        let gyros = self.gyros(asked)?;
        let time = match &asked.time {
            Some(name) => Some(table.column(name)?),
            None => self.guess_time(&temperatures, &gyros)?,
        };
        let clock = time.and_then(|time| table.clocks[time]);
        let of_column = |time: usize| match asked.time_unit.or(clock.map(|clock| clock.unit)) {
            Some(known) => Ok(Some(known)),
            None => self.said(time, "time_unit", time_unit),
        };
        let mut resolved = Resolved {
            time,
            time_unit: time.map_or(Ok(asked.time_unit), of_column)?,
            is_time_unit_asked: asked.time_unit.is_some(),
            is_utc: clock.is_none_or(|clock| clock.is_utc),
            sensors: Vec::new(),
            notes: Vec::new(),
            guesses: Vec::new(),
        };
        if let Some(time) = time.filter(|&time| asked.time.is_none() && clock.is_none() && !is_time(&self.words[time]))
        {
            let name = &table.names()[time];
            resolved.notes.push(format!("'{name}' is taken for the time, by its unit (`time` says another column)"));
        }
        for gyro in &gyros {
            let temperature = self.temperature_of(gyro, &temperatures)?;
            let sensor = self.sensor(gyro, temperature, asked, &mut resolved)?;
            resolved.sensors.push(sensor);
        }
        Ok(resolved)
    }

    fn places(&self, is: fn(&[String]) -> bool) -> Vec<usize> {
        (0..self.with_units.len()).filter(|&column| is(&self.with_units[column])).collect()
    }

    fn gyros(&self, asked: &Columns) -> Result<Vec<Gyro>, TableError> {
        if asked.rates.is_empty() {
            let found = self.guess_rates();
            // What is made of a column goes by its name.
            found.iter().try_for_each(|&column| self.table.column(&self.table.names()[column]).map(drop))?;
            let gyros = if found.is_empty() { None } else { gyros::split(&found, &self.words) };
            return gyros.ok_or_else(|| self.unclear("rate", &found));
        }
        let columns: Vec<usize> =
            asked.rates.iter().map(|name| self.table.column(name)).collect::<Result<_, TableError>>()?;
        if let Some(place) = (1..columns.len()).find(|&place| columns[..place].contains(&columns[place])) {
            let column = asked.rates[place].clone();
            return Err(self.table.source().faulty(TableFault::AskedTwice { column }));
        }
        Ok(gyros::split(&columns, &self.words).unwrap_or_else(|| vec![Gyro { instance: None, columns }]))
    }

    /// The time column: by its name; else by how its cells are written; else the first column, where its name ends in a unit
    /// of times and it never falls.
    fn guess_time(&self, temperatures: &[usize], gyros: &[Gyro]) -> Result<Option<usize>, TableError> {
        let is_other =
            |column: usize| temperatures.contains(&column) || gyros.iter().any(|gyro| gyro.columns.contains(&column));
        // Of `date` and `time` the time, of `timestamp` and `time_s` the one that says its unit, of `timestamp` and
        // `timestamp_sample` the one with fewer words; a log may also have none.
        let named = self.places(is_time).into_iter().filter(|&column| !is_other(column));
        let is_date = |column: usize| self.words[column].first().is_some_and(|word| word == "date");
        let has_unit =
            |column: usize| self.table.clocks[column].is_some() || time_unit(&self.with_units[column]).is_some();
        let named = named.min_by_key(|&column| (is_date(column), !has_unit(column), self.words[column].len()));
        let clock = || self.table.clocks.iter().position(Option::is_some);
        if let Some(found) = named.or_else(clock) {
            return Ok(Some(found));
        }
        let by_unit = self.with_units.first().is_some_and(|words| ends_in_time(words)) && !is_other(0);
        Ok((by_unit && self.table.never_falls(0)?).then_some(0))
    }

    /// The temperature columns, by their names: where none says it, a capital T, or a small one beside another time.
    fn guess_temperatures(&self) -> Vec<usize> {
        let named = self.places(is_temperature);
        if !named.is_empty() {
            return named;
        }
        let times = self.places(is_time);
        let of_letter = |letter: &str| -> Vec<usize> {
            let is_bare = |column: &usize| self.with_units[*column] == ["t"] && self.table.names()[*column] == letter;
            times.iter().copied().filter(is_bare).collect()
        };
        match of_letter("T") {
            capital if !capital.is_empty() => capital,
            _ if times.len() > 1 => of_letter("t"),
            _ => Vec::new(),
        }
    }

    /// The rate columns, by their names.
    fn guess_rates(&self) -> Vec<usize> {
        let all = self.places(is_rate);
        // `gyro_status` is beside `gyro_x`, not of its kind.
        let with_axis: Vec<usize> = all.iter().copied().filter(|&column| names_axis(&self.words[column])).collect();
        // PX4's own topics name them x, y, z and nothing else.
        let bare = self.places(is_bare_axis);
        [with_axis, all, bare].into_iter().find(|columns| !columns.is_empty()).unwrap_or_default()
    }

    /// The one temperature there is, or the one with the gyro's number.
    fn temperature_of(&self, gyro: &Gyro, temperatures: &[usize]) -> Result<usize, TableError> {
        let own = |column: &usize| gyro.instance.is_some_and(|number| numbers(&self.words[*column]).contains(&number));
        let mut candidates = temperatures.to_vec();
        if candidates.len() > 1 && gyro.instance.is_some() {
            candidates.retain(own);
        }
        match candidates[..] {
            [only] => Ok(only),
            _ => Err(self.unclear("temperature", if candidates.is_empty() { temperatures } else { &candidates })),
        }
    }

    /// A gyro's columns with their units.
    fn sensor(
        &self,
        gyro: &Gyro,
        temperature: usize,
        asked: &Columns,
        resolved: &mut Resolved,
    ) -> Result<ResolvedSensor, TableError> {
        let said = match asked.temperature_unit {
            Some(given) => {
                if let Some(said) = temperature_unit(&self.with_units[temperature]).filter(|said| *said != given) {
                    let name = &self.table.names()[temperature];
                    let text = format!("'{name}' says {said}, and is taken as {given}, as asked (`temperature_unit`)");
                    resolved.notes.push(text);
                }
                Some(given)
            }
            None => self.said(temperature, "temperature_unit", temperature_unit)?,
        };
        let is_temperature_guessed = said.is_none();
        if is_temperature_guessed {
            let name = &self.table.names()[temperature];
            let text = format!("'{name}' {TAKEN_AS} degrees C (`temperature_unit` says otherwise)");
            resolved.guesses.push(Reason::new(ReasonKind::AssumedUnit, text));
        }
        let written_temperature = said.unwrap_or(WrittenTemperature::Celsius);
        let written: Vec<Option<WrittenRate>> =
            gyro.columns.iter().map(|&column| self.written(column, asked, resolved)).collect::<Result<_, _>>()?;
        let by_name = written.iter().flatten().next().copied();
        let likely = asked.likely_rate_unit.unwrap_or(WrittenRate::RadPerS);
        let of_rest = by_name.or(asked.else_rate_unit).unwrap_or(likely);
        let is_rate_guessed = by_name.is_none() && asked.else_rate_unit.is_none();
        if let Some(place) = written.iter().position(Option::is_none)
            && (is_rate_guessed || by_name.is_some())
        {
            let name = &self.table.names()[gyro.columns[place]];
            let why = match (is_rate_guessed, asked.likely_rate_unit) {
                (true, Some(_)) => ", as the calibration has it",
                (true, None) => "",
                (false, _) => ", as the columns beside it",
            };
            let text = format!("'{name}' {TAKEN_AS} {of_rest}{why} (`rate_unit` says otherwise)");
            resolved.guesses.push(Reason::new(ReasonKind::GuessedUnit, text));
        }
        let rate_unit = of_rest.unit();
        let rate = |(&column, written): (&usize, Option<WrittenRate>)| {
            let name = self.table.names()[column].clone();
            let written = written.unwrap_or(of_rest);
            match written.in_unit(rate_unit) {
                Some(factor) => Ok(ResolvedRate { column, name, factor }),
                None => Err(self.other_unit(column, written.to_string(), format!("{of_rest} as the other columns"))),
            }
        };
        let rates = gyro.columns.iter().zip(written).map(rate).collect::<Result<_, _>>()?;
        let sensor = gyro.instance.map(|instance| Sensor { kind: SensorKind::Gyro, instance, device_id: None });
        Ok(ResolvedSensor {
            sensor,
            temperature,
            written_temperature,
            is_temperature_guessed,
            rates,
            rate_unit,
            is_rate_guessed,
        })
    }

    /// The unit in which a rate column is written: one that was given is believed against its name.
    fn written(
        &self,
        column: usize,
        asked: &Columns,
        resolved: &mut Resolved,
    ) -> Result<Option<WrittenRate>, TableError> {
        let name = &self.table.names()[column];
        let said = match asked.rate_unit {
            Some(_) => rate_unit(&self.with_units[column]),
            None => self.said(column, "rate_unit", rate_unit)?,
        };
        match (asked.rate_unit, said) {
            (Some(given), Some(Said::Known(said))) if said != given => {
                resolved.notes.push(format!("'{name}' says {said}, and is taken as {given}, as asked (`rate_unit`)"));
                Ok(Some(given))
            }
            (Some(given), _) => Ok(Some(given)),
            (None, Some(Said::Known(said))) => Ok(Some(said)),
            (None, Some(Said::Other(unit))) => Err(self.unread(column, unit, "rate_unit")),
            (None, None) => Ok(None),
        }
    }

    /// The unit that a column's name and the unit below it say together: nobody knows which is true where they differ.
    fn said<U: PartialEq + Display>(
        &self,
        column: usize,
        what: &'static str,
        unit_of: fn(&[String]) -> Option<U>,
    ) -> Result<Option<U>, TableError> {
        match (unit_of(&self.words[column]), unit_of(&self.units[column])) {
            (Some(name), Some(row)) if name != row => {
                let column = self.table.names()[column].clone();
                let (name, row) = (name.to_string(), row.to_string());
                Err(self.table.source().faulty(TableFault::TwoUnits { column, name, row, what }))
            }
            _ => match other_unit(&self.with_units[column]) {
                Some(other) => Err(self.unread(column, other, what)),
                None => Ok(unit_of(&self.with_units[column])),
            },
        }
    }

    /// A unit that is named and not read, and the parameter that says otherwise.
    fn unread(&self, column: usize, unit: &str, what: &'static str) -> TableError {
        let read = match what {
            "time_unit" => "seconds",
            "temperature_unit" => "degrees C",
            _ => "dps or rad/s",
        };
        self.other_unit(column, unit.to_owned(), format!("{read}, or say its unit (`{what}`)"))
    }

    fn other_unit(&self, column: usize, unit: String, instead: String) -> TableError {
        let column = self.table.names()[column].clone();
        self.table.source().faulty(TableFault::OtherUnit { column, unit, instead })
    }

    fn unclear(&self, what: &'static str, found: &[usize]) -> TableError {
        let found = if found.is_empty() { "no column" } else { "more than one column" };
        let columns = self.table.names().join(", ");
        self.table.source().faulty(TableFault::Unclear { what, found, columns })
    }
}

#[cfg(test)]
mod tests;
