//! What a column's name says: what it holds, of which sensor and axis, in what unit.

use std::fmt;

use crate::units::{RateUnit, TimeUnit, WrittenRate, WrittenTemperature};

const COUNTS: [&str; 5] = ["count", "counts", "lsb", "adc", "raw"];
const DEGREES: [&str; 4] = ["deg", "degs", "degree", "degrees"];
const SECONDS: [&str; 5] = ["s", "sec", "secs", "second", "seconds"];
const MINUTES: [&str; 4] = ["min", "mins", "minute", "minutes"];
const HOURS: [&str; 5] = ["h", "hr", "hrs", "hour", "hours"];
/// Parts of a second, in which no rate is read.
const PARTS_OF_A_SECOND: [&str; 5] = ["ms", "msec", "us", "usec", "µs"];

/// A name's words in lower case: `imu.gyro.x`, `x_rad_s`, `GyrX`, `gyro_rad[0]`; the sign of degrees is the word `deg`.
pub(crate) fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    let spelled = name.replace(['°', 'º'], " deg ").replace('℃', " deg c ").replace('℉', " deg f ");
    for letter in spelled.chars() {
        if !letter.is_alphanumeric() || (was_lower && letter.is_uppercase()) {
            words.push(String::new());
        }
        if letter.is_alphanumeric() {
            words.last_mut().expect("never empty").extend(letter.to_lowercase());
        }
        was_lower = letter.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    // `mDPS` and `m°/s` are thousandths, and no metre beside a degree.
    while let Some(place) = words.windows(2).position(|pair| pair[0] == "m" && is_angle(&pair[1])) {
        let angle = words.remove(place + 1);
        words[place].push_str(&angle);
    }
    words
}

fn is_angle(word: &str) -> bool {
    ["dps", "deg", "rad"].contains(&word)
}

fn has(words: &[String], any: &[&str]) -> bool {
    words.iter().any(|word| any.contains(&word.as_str()))
}

pub(super) fn is_time(words: &[String]) -> bool {
    words
        .first()
        .is_some_and(|word| ["t", "time", "timestamp", "seconds", "date", "datetime", "datum"].contains(&word.as_str()))
        && !is_temperature(words)
}

/// By its word, or as a T of some degrees: `T_C`, `T [°C]`, `T_gyro [K]`.
pub(super) fn is_temperature(words: &[String]) -> bool {
    let is_of_degrees = || temperature_unit(words).is_some_and(|unit| unit != WrittenTemperature::Counts);
    words.iter().any(|word| word.starts_with("temp"))
        || (words.first().is_some_and(|word| word == "t") && is_of_degrees() && time_unit(words).is_none())
}

/// Names a rate by the sensor's name or by its unit, and no other sensor.
pub(super) fn is_rate(words: &[String]) -> bool {
    let sensor = words.iter().any(|word| word.starts_with("gyr"))
        || has(words, &["rate", "omega", "zro", "angular", "gx", "gy", "gz"]);
    let unit = match rate_unit(words) {
        // Degrees alone are an angle, and counts anybody's.
        Some(Said::Known(unit)) => unit != WrittenRate::Counts && (unit != WrittenRate::Dps || is_per_second(words)),
        Some(Said::Other(_)) => true,
        None => false,
    };
    let other = is_acceleration(words) || words.iter().any(|word| word.starts_with("acc") || word.starts_with("mag"));
    (sensor || unit) && !other && !is_temperature(words) && !is_time(words)
}

/// By its unit, metres a second squared.
fn is_acceleration(words: &[String]) -> bool {
    let squared = words.windows(2).any(|pair| pair[0] == "m" && ["s2", "s²"].contains(&pair[1].as_str()));
    squared || words.windows(3).any(|three| three == ["m", "s", "2"])
}

fn is_per_second(words: &[String]) -> bool {
    has(words, &["dps"]) || has(words, &SECONDS)
}

/// The axis that a name says, x, y and z as 0, 1 and 2.
pub(super) fn axis(words: &[String]) -> Option<usize> {
    let place = |word: &String| match word.as_str() {
        "x" | "gx" => Some(0),
        "y" | "gy" => Some(1),
        "z" | "gz" => Some(2),
        _ => None,
    };
    words.iter().find_map(place)
}

/// Whether a name is an axis and no more, or an axis in counts, which say no sensor: `x`, `y_raw`, `z [LSB]`.
pub(super) fn is_bare_axis(words: &[String]) -> bool {
    words.split_first().is_some_and(|(axis, unit)| {
        ["x", "y", "z"].contains(&axis.as_str()) && unit.iter().all(|word| COUNTS.contains(&word.as_str()))
    })
}

/// Whether a name says an axis, by a letter or a place.
pub(super) fn names_axis(words: &[String]) -> bool {
    axis(words).is_some() || has(words, &["0", "1", "2"])
}

/// The numbers in a name: at the end of a word, `gyro1`, or one by itself.
pub(super) fn numbers(words: &[String]) -> Vec<u8> {
    let number = |word: &String| word.trim_start_matches(|c: char| !c.is_ascii_digit()).parse().ok();
    words.iter().filter_map(number).collect()
}

/// A unit of rates that a name says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Said {
    /// One that can be read.
    Known(WrittenRate),
    /// Another, and it must not be taken for one of those.
    Other(&'static str),
}

impl fmt::Display for Said {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Known(unit) => unit.fmt(f),
            Self::Other(unit) => f.write_str(unit),
        }
    }
}

/// The unit of rates that a name says, if it says one.
pub(super) fn rate_unit(words: &[String]) -> Option<Said> {
    use WrittenRate::{Counts, DegPerHour, Dps, MilliDps, MilliRadPerS, RadPerS};
    let degrees = has(words, &DEGREES);
    let radians = has(words, &["rad", "rads", "radps"]);
    let per_hour = has(words, &HOURS);
    let per_minute = has(words, &MINUTES);
    let faster = has(words, &PARTS_OF_A_SECOND);
    Some(match () {
        () if is_acceleration(words) => Said::Other("metres a second squared, which is no rate"),
        () if has(words, &["rpm"]) => Said::Other("turns a minute"),
        () if has(words, &["rps", "rev", "revs", "turns"]) => Said::Other("turns"),
        () if has(words, &["kdps", "kdeg"]) => Said::Other("thousands of deg/s"),
        () if has(words, &["krad"]) => Said::Other("thousands of rad/s"),
        () if has(words, &["urad", "µrad"]) => Said::Other("millionths of a radian"),
        () if has(words, &["mdps"]) => Said::Known(MilliDps),
        () if has(words, &["mdeg"]) && (per_hour || per_minute) => Said::Other("mdeg/h or mdeg/min"),
        () if degrees && faster => Said::Other("deg for a part of a second"),
        () if (radians || has(words, &["mrad"])) && faster => Said::Other("rad for a part of a second"),
        () if has(words, &["mdeg"]) => Said::Known(MilliDps),
        () if has(words, &["mrad"]) => Said::Known(MilliRadPerS),
        () if has(words, &["dph"]) => Said::Known(DegPerHour),
        () if degrees && per_hour => Said::Known(DegPerHour),
        () if degrees && per_minute => Said::Other("deg/min"),
        () if radians && per_hour => Said::Other("rad/h"),
        () if radians && per_minute => Said::Other("rad/min"),
        () if radians => Said::Known(RadPerS),
        () if degrees || has(words, &["dps"]) => Said::Known(Dps),
        () if has(words, &COUNTS) => Said::Known(Counts),
        () => return None,
    })
}

/// A name for rates that are in `unit` now, which it ends in: without the unit that it said. `x_mdps` of rates in deg/s is `x_dps`.
#[must_use]
pub fn named_in(name: &str, unit: RateUnit) -> String {
    let suffix = unit.name().replace('/', "_").replace('^', "");
    let words = words(name);
    match rate_unit(&words) {
        said if name.ends_with(&format!("_{suffix}")) && said == said_of(unit) => name.to_owned(),
        None => format!("{name}_{suffix}"),
        Some(_) => {
            let is_unit = |word: &[String]| {
                let is_time =
                    [&SECONDS[..], &MINUTES, &HOURS, &PARTS_OF_A_SECOND, &["per"]].iter().any(|any| has(word, any));
                is_time || rate_unit(word).is_some()
            };
            let kept = words.chunks(1).filter(|word| !is_unit(word)).map(|word| word[0].as_str());
            kept.chain([suffix.as_str()]).collect::<Vec<_>>().join("_")
        }
    }
}

fn said_of(unit: RateUnit) -> Option<Said> {
    WrittenRate::of(unit).map_or_else(|| rate_unit(&words(unit.name())), |unit| Some(Said::Known(unit)))
}

/// The unit of temperatures that a name says, if it says one.
pub(super) fn temperature_unit(words: &[String]) -> Option<WrittenTemperature> {
    Some(match () {
        () if has(words, &COUNTS) => WrittenTemperature::Counts,
        () if has(words, &["c", "degc", "celsius", "centigrade"]) => WrittenTemperature::Celsius,
        () if has(words, &["f", "degf", "fahrenheit"]) => WrittenTemperature::Fahrenheit,
        () if has(words, &["k", "degk", "kelvin"]) => WrittenTemperature::Kelvin,
        () => return None,
    })
}

/// A unit of neither times nor rates nor temperatures that are read, as a name says it: what is in it must not be taken for
/// what has no unit.
pub(super) fn other_unit(words: &[String]) -> Option<&'static str> {
    let other = |word: &String| match word.as_str() {
        "v" | "volt" | "volts" | "mv" | "uv" | "µv" => Some("volts"),
        "hz" | "khz" | "mhz" => Some("hertz"),
        "ohm" | "ohms" | "kohm" | "kohms" => Some("ohms"),
        "day" | "days" => Some("days"),
        // Ticks of a clock: `100ns`. That a rate is a mean over 10 s is no unit.
        word if is_time(words) => {
            let unit = word.trim_start_matches(|letter: char| letter.is_ascii_digit());
            (unit.len() < word.len() && time_unit(&[unit.to_owned()]).is_some()).then_some("several of a unit")
        }
        _ => None,
    };
    words.iter().find_map(other)
}

/// The unit of times that a name says, if it says one.
pub(super) fn time_unit(words: &[String]) -> Option<TimeUnit> {
    words.iter().rev().find_map(|word| match word.as_str() {
        "ms" | "msec" => Some(TimeUnit::Ms),
        "us" | "usec" | "µs" | "μs" => Some(TimeUnit::Us),
        "ns" | "nsec" => Some(TimeUnit::Ns),
        word if SECONDS.contains(&word) => Some(TimeUnit::S),
        word if MINUTES.contains(&word) => Some(TimeUnit::Min),
        word if HOURS.contains(&word) => Some(TimeUnit::H),
        _ => None,
    })
}

/// Whether a name ends in a unit of times, and is not of something for each of it: `Zeit_s`, `Elapsed (ms)`, but not `v_m_s`.
pub(super) fn ends_in_time(words: &[String]) -> bool {
    words.split_last().is_some_and(|(last, before)| {
        time_unit(std::slice::from_ref(last)).is_some()
            && !has(before, &["m", "mm", "km", "v", "per"])
            && !is_rate(words)
    })
}

/// Whether a cell below a name says a unit.
pub(super) fn says_a_unit(cell: &str) -> bool {
    let words = words(cell);
    time_unit(&words).is_some() || temperature_unit(&words).is_some() || rate_unit(&words).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is named so says the unit, and no other.
    #[test]
    fn a_name_says_the_unit_that_its_rates_are_in_and_no_other() {
        for (name, unit, wanted) in [
            ("x_mdps", RateUnit::Dps, "x_dps"),
            ("x [mdps]", RateUnit::Dps, "x_dps"),
            ("gyro_x_deg_h", RateUnit::Dps, "gyro_x_dps"),
            ("wx (deg/s)", RateUnit::Dps, "wx_dps"),
            ("x_rad_s", RateUnit::Dps, "x_dps"),
            ("x_rad_s", RateUnit::Counts, "x_counts"),
            ("x_mrad_s", RateUnit::RadPerS, "x_rad_s"),
            ("GyrX", RateUnit::RadPerS, "GyrX_rad_s"),
            ("x_rad_s", RateUnit::RadPerS, "x_rad_s"),
            ("x_dps", RateUnit::Dps, "x_dps"),
            ("accel0.x", RateUnit::MetresPerS2, "accel0.x_m_s2"),
        ] {
            let named = named_in(name, unit);
            assert_eq!(named, wanted, "{name}");
            assert_eq!(rate_unit(&words(&named)), said_of(unit), "{named}");
        }
    }

    #[test]
    fn an_acceleration_is_no_rate_and_its_unit_is_named() {
        for name in ["accel_x_m_s2", "x [m/s^2]", "ax (m/s²)"] {
            assert!(!is_rate(&words(name)), "{name}");
            assert!(matches!(rate_unit(&words(name)), Some(Said::Other(unit)) if unit.contains("squared")), "{name}");
        }
        assert_eq!(rate_unit(&words("gyro2_x_rad_s")), Some(Said::Known(WrittenRate::RadPerS)));
    }
}
