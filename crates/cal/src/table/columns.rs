//! Which column is which, and in what unit: as asked for, or by the names where they make it plain.

use super::{Table, TableError, TableFault};
use crate::units::{RateUnit, TemperatureUnit, TimeUnit};

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
    /// The rate columns' unit.
    pub rate_unit: Option<RateUnit>,
}

/// Which column is which.
#[derive(Debug, Clone, PartialEq)]
pub struct Resolved {
    /// The place of the time column; a log may have none.
    pub time: Option<usize>,
    /// The place of the temperature column.
    pub temperature: usize,
    /// The places of the rate columns, at least one.
    pub rates: Vec<usize>,
    /// The rate columns' names.
    pub rate_names: Vec<String>,
    /// The time's unit where it was given or the name says it; otherwise [`TimeUnit::by_duration`] decides.
    pub time_unit: Option<TimeUnit>,
    /// The rates' unit.
    pub rate_unit: RateUnit,
    /// The temperature's unit: counts where the name says so, else degrees C.
    pub temperature_unit: TemperatureUnit,
    /// A sentence for everything that was guessed and not plain from a name.
    pub notes: Vec<String>,
}

impl Columns {
    /// Finds the columns of a table.
    ///
    /// # Errors
    /// When a column asked for is not there, or the names do not make it plain: the error lists the columns and the
    /// option that says which.
    pub fn resolve(&self, table: &Table) -> Result<Resolved, TableError> {
        let words: Vec<Vec<String>> = table.names().iter().map(|name| words(name)).collect();
        let places = |is: fn(&[String]) -> bool| -> Vec<usize> {
            (0..words.len()).filter(|&column| is(&words[column])).collect()
        };
        let temperature = match &self.temperature {
            Some(name) => table.column(name)?,
            None => match places(is_temperature)[..] {
                [only] => only,
                ref several => return Err(unclear(table, "temperature", several)),
            },
        };
        let rates = if self.rates.is_empty() {
            match guess_rates(&words) {
                Ok(rates) => rates,
                Err(several) => return Err(unclear(table, "rate", &several)),
            }
        } else {
            self.rates.iter().map(|name| table.column(name)).collect::<Result<_, _>>()?
        };
        let time = match &self.time {
            Some(name) => Some(table.column(name)?),
            // Of `timestamp` and `timestamp_sample` the one with fewer words; a log may also have none.
            None => places(is_time).into_iter().min_by_key(|&column| words[column].len()),
        };
        refuse_other_units(table, &words, temperature, &rates, self.rate_unit)?;
        let mut notes = Vec::new();
        let rate_unit = self.rate_unit.or_else(|| rate_unit(&words[rates[0]])).unwrap_or_else(|| {
            let name = &table.names()[rates[0]];
            notes.push(format!("'{name}' names no unit: taken as rad/s (`rate_unit` says otherwise)"));
            RateUnit::RadPerS
        });
        Ok(Resolved {
            time,
            temperature,
            rate_names: rates.iter().map(|&rate| table.names()[rate].clone()).collect(),
            rates,
            time_unit: self.time_unit.or_else(|| time.and_then(|time| time_unit(&words[time]))),
            rate_unit,
            temperature_unit: if has(&words[temperature], &COUNTS_WORDS) {
                TemperatureUnit::Counts
            } else {
                TemperatureUnit::C
            },
            notes,
        })
    }
}

fn unclear(table: &Table, what: &'static str, found: &[usize]) -> TableError {
    let found = if found.is_empty() { "no column" } else { "more than one column" };
    table.source().faulty(TableFault::Unclear { what, found, columns: table.names().join(", ") })
}

/// Units of temperature by the words that say them, and none of them is degrees C.
const OTHER_TEMPERATURES: [(&str, &[&str]); 2] =
    [("degrees Fahrenheit", &["f", "degf", "fahrenheit"]), ("kelvin", &["k", "kelvin"])];

/// Units of rates by the words that say them, all of which must be there.
const OTHER_RATES: [(&str, &[&str]); 7] = [
    ("mdps", &["mdps"]),
    ("mdps", &["mdeg"]),
    ("mrad/s", &["mrad"]),
    ("deg/h", &["dph"]),
    ("deg/h", &["deg", "h"]),
    ("deg/h", &["deg", "hr"]),
    ("deg/h", &["deg", "hour"]),
];

/// Refuses names that say a unit which would be taken for another. A unit of the rates that was given is believed.
fn refuse_other_units(
    table: &Table,
    words: &[Vec<String>],
    temperature: usize,
    rates: &[usize],
    given: Option<RateUnit>,
) -> Result<(), TableError> {
    let refused = |column: usize, unit, instead| {
        Err(table.source().faulty(TableFault::OtherUnit { column: table.names()[column].clone(), unit, instead }))
    };
    if let Some((unit, _)) = OTHER_TEMPERATURES.iter().find(|(_, said)| has(&words[temperature], said)) {
        return refused(temperature, unit, "degrees C");
    }
    for &rate in rates.iter().filter(|_| given.is_none()) {
        if let Some(unit) = other_rate_unit(&words[rate]) {
            return refused(rate, unit, "dps or rad/s, or say its unit (`rate_unit`)");
        }
    }
    Ok(())
}

/// The unit of a rate that a name says and that is not read.
fn other_rate_unit(words: &[String]) -> Option<&'static str> {
    let says = |said: &[&str]| said.iter().all(|word| has(words, &[word]));
    OTHER_RATES.iter().find(|(_, said)| says(said)).map(|(unit, _)| *unit)
}

const COUNTS_WORDS: [&str; 5] = ["count", "counts", "lsb", "adc", "raw"];

/// A name's words in lower case: `imu.gyro.x`, `x_rad_s`, `GyrX`, `gyro_rad[0]`; the sign of degrees is the word `deg`.
pub(crate) fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    for letter in name.replace('°', " deg ").chars() {
        if !letter.is_alphanumeric() || (was_lower && letter.is_uppercase()) {
            words.push(String::new());
        }
        if letter.is_alphanumeric() {
            words.last_mut().expect("never empty").extend(letter.to_lowercase());
        }
        was_lower = letter.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}

fn has(words: &[String], any: &[&str]) -> bool {
    words.iter().any(|word| any.contains(&word.as_str()))
}

fn is_time(words: &[String]) -> bool {
    words.first().is_some_and(|word| ["t", "time", "timestamp", "seconds"].contains(&word.as_str()))
        && !is_temperature(words)
}

fn is_temperature(words: &[String]) -> bool {
    words.iter().any(|word| word.starts_with("temp")) || words == ["t", "c"]
}

/// Names a rate by the sensor's name or by its unit, and no other sensor.
fn is_rate(words: &[String]) -> bool {
    let sensor = words.iter().any(|word| word.starts_with("gyr"))
        || has(words, &["rate", "omega", "zro", "angular", "gx", "gy", "gz"]);
    let unit = has(words, &["dps", "rad"])
        || (has(words, &["deg"]) && has(words, &["s", "sec"]))
        || other_rate_unit(words).is_some();
    let other = words.iter().any(|word| word.starts_with("acc") || word.starts_with("mag"));
    (sensor || unit) && !other && !is_temperature(words) && !is_time(words)
}

fn names_axis(words: &[String]) -> bool {
    has(words, &["x", "y", "z", "gx", "gy", "gz", "0", "1", "2"])
}

/// One to three rate columns, or what was found instead.
fn guess_rates(words: &[Vec<String>]) -> Result<Vec<usize>, Vec<usize>> {
    let all: Vec<usize> = (0..words.len()).filter(|&column| is_rate(&words[column])).collect();
    // `gyro_status` is beside `gyro_x`, not of its kind.
    let with_axis: Vec<usize> = all.iter().copied().filter(|&column| names_axis(&words[column])).collect();
    // PX4's own topics name them x, y, z and nothing else.
    let bare: Vec<usize> = (0..words.len())
        .filter(|&column| words[column].len() == 1 && ["x", "y", "z"].contains(&words[column][0].as_str()))
        .collect();
    let found = [with_axis, all, bare].into_iter().find(|columns| !columns.is_empty()).unwrap_or_default();
    if (1..=3).contains(&found.len()) { Ok(found) } else { Err(found) }
}

fn rate_unit(words: &[String]) -> Option<RateUnit> {
    if has(words, &["rad"]) {
        Some(RateUnit::RadPerS)
    } else if has(words, &["dps", "deg"]) {
        Some(RateUnit::Dps)
    } else if has(words, &COUNTS_WORDS) {
        Some(RateUnit::Counts)
    } else {
        None
    }
}

fn time_unit(words: &[String]) -> Option<TimeUnit> {
    words.iter().rev().find_map(|word| match word.as_str() {
        "s" | "sec" | "seconds" => Some(TimeUnit::S),
        "ms" | "msec" => Some(TimeUnit::Ms),
        "us" | "usec" => Some(TimeUnit::Us),
        "ns" | "nsec" => Some(TimeUnit::Ns),
        _ => None,
    })
}
