//! Which axis of a log is which axis of a calibration: by the part's number, by the name, else by what it measures and
//! along which direction. So `gyro0.x` of an autopilot's log is `x_rad_s` of a table of the same unit.

use imu_logs::{Sensor, SensorKind};
use thiserror::Error;

use crate::calibration::Calibration;
use crate::log::SensorChoice;
use crate::table::words;
use crate::units::RateUnit;

/// An axis as a log or a calibration tells of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known<'a> {
    /// Its name.
    pub name: &'a str,
    /// The sensor; `None` for a table's columns.
    pub sensor: Option<Sensor>,
    /// The rate's unit.
    pub unit: RateUnit,
}

/// Axes that could be one another, and nothing says which.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "{calibrated} of the calibration could be {logged} of the log, and nothing says which: say which sensor it is (`sensor`), or which columns (`rate`)"
)]
pub struct Ambiguous {
    /// The calibration's axes, more than one or of more than one of the log's.
    pub calibrated: String,
    /// The log's.
    pub logged: String,
}

/// Why a calibration is not for a log.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Unmatched {
    /// No axis in common.
    #[error("it has {found}, and the calibration is for {expected}")]
    NoAxis {
        /// The log's axes.
        found: String,
        /// The calibration's.
        expected: String,
    },
    /// Axes that could be one another.
    #[error(transparent)]
    Ambiguous(#[from] Ambiguous),
}

/// A calibration's axes that are wanted. The choice is of sensors: a column is no sensor's, and is always wanted.
#[must_use]
pub fn calibrated(calibration: &Calibration, choice: Option<SensorChoice>) -> Vec<Known<'_>> {
    let known = calibration.axes.iter().map(|(name, axis)| Known { name, sensor: axis.sensor, unit: axis.rate_unit });
    known.filter(|axis| choice.zip(axis.sensor).is_none_or(|(choice, sensor)| choice.takes(&sensor))).collect()
}

/// For each axis of a calibration its place among a log's, which has one of them at least.
///
/// # Errors
/// [`Unmatched`].
pub fn places(calibrated: &[Known<'_>], logged: &[Known<'_>]) -> Result<Vec<Option<usize>>, Unmatched> {
    let places = matched(calibrated, logged)?;
    if places.iter().all(Option::is_none) {
        let names = |axes: &[Known<'_>]| axes.iter().map(|axis| axis.name).collect::<Vec<_>>().join(", ");
        return Err(Unmatched::NoAxis { found: names(logged), expected: names(calibrated) });
    }
    Ok(places)
}

/// That an axis of a log is taken for one of the calibration of another name; nothing where the names are one.
#[must_use]
pub fn renamed(logged: &str, calibrated: &str) -> Option<String> {
    (logged != calibrated).then(|| format!("'{logged}' of the log is taken for {calibrated} of the calibration"))
}

/// For each axis of a calibration its place among a log's, if it is there.
///
/// # Errors
/// [`Ambiguous`], where only the role is left to tell, and more than one axis has it.
fn matched(calibrated: &[Known<'_>], logged: &[Known<'_>]) -> Result<Vec<Option<usize>>, Ambiguous> {
    let mut places: Vec<Option<usize>> = vec![None; calibrated.len()];
    for is_same in [is_same_part, has_same_name] {
        for (own, axis) in calibrated.iter().enumerate().filter(|(own, _)| places[*own].is_none()).collect::<Vec<_>>() {
            let free = |(place, other): &(usize, &Known<'_>)| !places.contains(&Some(*place)) && is_same(axis, other);
            let found = logged.iter().enumerate().find(free).map(|(place, _)| place);
            places[own] = found;
        }
    }
    let by_name = places.clone();
    for (own, axis) in calibrated.iter().enumerate().filter(|(own, _)| by_name[*own].is_none()) {
        let Some(role) = Role::of(axis) else { continue };
        let has_role = |other: &Known<'_>| Role::of(other) == Some(role);
        let others: Vec<usize> =
            (0..logged.len()).filter(|place| !by_name.contains(&Some(*place)) && has_role(&logged[*place])).collect();
        let rivals: Vec<usize> =
            (0..calibrated.len()).filter(|own| by_name[*own].is_none() && has_role(&calibrated[*own])).collect();
        match (&others[..], rivals.len()) {
            ([], _) => {}
            ([only], 1) => places[own] = Some(*only),
            _ => {
                let names = |axes: &[Known<'_>], places: &[usize]| {
                    places.iter().map(|place| axes[*place].name).collect::<Vec<_>>().join(" or ")
                };
                return Err(Ambiguous { calibrated: names(calibrated, &rivals), logged: names(logged, &others) });
            }
        }
    }
    Ok(places)
}

/// The same direction of the same part, where both logs know its number.
fn is_same_part(own: &Known<'_>, other: &Known<'_>) -> bool {
    let part = |axis: &Known<'_>| axis.sensor.and_then(|sensor| sensor.device_id);
    part(own).is_some() && part(own) == part(other) && Role::of(own).is_some() && Role::of(own) == Role::of(other)
}

fn has_same_name(own: &Known<'_>, other: &Known<'_>) -> bool {
    own.name == other.name
}

/// What an axis measures, and along which direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Role {
    kind: SensorKind,
    direction: usize,
}

impl Role {
    /// The role that an axis's name and unit tell; `None` where the name tells of no direction.
    fn of(axis: &Known<'_>) -> Option<Self> {
        let of_unit = || if axis.unit.is_of_acceleration() { SensorKind::Accelerometer } else { SensorKind::Gyro };
        let kind = axis.sensor.map_or_else(of_unit, |sensor| sensor.kind);
        Some(Self { kind, direction: direction(axis.name)? })
    }
}

/// The direction that an axis's name tells, 0 to 2 for X, Y and Z: by a letter (`x_rad_s`, `gx`, `GyrX`, `gyrox`), else by
/// a number (`gyro[0]`); `None` where it tells of none, or of several.
#[must_use]
pub fn direction(name: &str) -> Option<usize> {
    let words = words(name);
    let lettered = words.iter().filter_map(|word| {
        let place = ['x', 'y', 'z'].iter().position(|letter| word.ends_with(*letter))?;
        let before = &word[..word.len() - 1];
        (["", "g"].contains(&before) || before.starts_with("gyr")).then_some(place)
    });
    let numbered = words.iter().filter_map(|word| ["0", "1", "2"].iter().position(|number| word == number));
    only(lettered).or_else(|| only(numbered))
}

fn only(mut directions: impl Iterator<Item = usize>) -> Option<usize> {
    let first = directions.next()?;
    directions.all(|other| other == first).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns<'a>(names: &[&'a str]) -> Vec<Known<'a>> {
        names.iter().map(|name| Known { name, sensor: None, unit: RateUnit::RadPerS }).collect()
    }

    fn gyro<'a>(instance: u8, device_id: Option<u32>, names: &[&'a str]) -> Vec<Known<'a>> {
        let sensor = Some(Sensor { kind: SensorKind::Gyro, instance, device_id });
        columns(names).into_iter().map(|axis| Known { sensor, ..axis }).collect()
    }

    #[test]
    fn directions_are_read_from_names_as_people_write_them() {
        for name in ["x", "gx", "x_rad_s", "imu.gyro.x", "GyrX", "gyrox", "gyro0.x", "gyro_rad[0]", "x [°/s]"] {
            assert_eq!(direction(name), Some(0), "{name}");
        }
        assert_eq!((direction("gyro[2]"), direction("gyro2.y")), (Some(2), Some(1)));
        for name in ["roll", "gyro_p", "max", "xy", "x_minus_y", "rate"] {
            assert_eq!(direction(name), None, "{name}");
        }
    }

    #[test]
    fn a_tables_columns_are_a_sensors_axes_by_role_and_names_come_first() {
        let own = gyro(0, None, &["gyro0.x", "gyro0.y", "gyro0.z"]);
        assert_eq!(matched(&own, &columns(&["z_dps", "x_dps", "w"])), Ok(vec![Some(1), None, Some(0)]));
        assert_eq!(matched(&columns(&["a", "x"]), &columns(&["gx", "a"])), Ok(vec![Some(1), Some(0)]));
        // An accelerometer is no gyro, whatever its name.
        let unit = RateUnit::MetresPerS2;
        let sensor = Some(Sensor { kind: SensorKind::Accelerometer, instance: 0, device_id: None });
        assert_eq!(matched(&columns(&["x"]), &[Known { name: "accel0.x", sensor, unit }]), Ok(vec![None]));
    }

    #[test]
    fn a_part_is_known_by_its_number_before_its_place() {
        let own = gyro(0, Some(7), &["gyro0.x"]);
        let logged = [gyro(0, Some(9), &["gyro0.x"]), gyro(1, Some(7), &["gyro1.x"])].concat();
        assert_eq!(matched(&own, &logged), Ok(vec![Some(1)]));
    }

    #[test]
    fn what_could_be_two_is_not_guessed_and_both_are_named() {
        let two = [gyro(0, None, &["gyro0.x"]), gyro(1, None, &["gyro1.x"])].concat();
        let one = columns(&["x_rad_s"]);
        let refused = matched(&one, &two).unwrap_err().to_string();
        assert!(refused.starts_with("x_rad_s of the calibration could be gyro0.x or gyro1.x of the log"), "{refused}");
        let refused = matched(&two, &one).unwrap_err().to_string();
        assert!(refused.starts_with("gyro0.x or gyro1.x of the calibration could be x_rad_s of the log"), "{refused}");
    }
}
