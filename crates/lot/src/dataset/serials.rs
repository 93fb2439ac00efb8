//! Whether each recording is of the unit that its file is named after, and whether a unit was recorded twice.

use std::collections::HashMap;

use zerorate_cal::quality::{Reason, ReasonKind};
use zerorate_report::few;

use super::Found;

/// Judges the serials of a lot. A recording is named after its unit where a part of its path between separators is the
/// serial; a lot in which at least half of them are is named so throughout, and another name is then a wrong serial.
pub(super) fn judge(found: &mut [Found]) {
    let named: Vec<bool> = found.iter().map(|it| named_after(&it.file, &it.info.unit_serial)).collect();
    let by_name = 2 * named.iter().filter(|named| **named).count() >= found.len();
    let mut of_serial: HashMap<String, Vec<usize>> = HashMap::new();
    for (place, it) in found.iter().enumerate() {
        of_serial.entry(it.info.unit_serial.clone()).or_default().push(place);
    }
    for (serial, places) in &of_serial {
        let others = |own: usize| -> String {
            let files = places.iter().filter(|place| **place != own).map(|place| found[*place].file.as_str());
            few(&files.collect::<Vec<_>>())
        };
        let reasons: Vec<(usize, Option<Reason>)> =
            places.iter().map(|&own| (own, reason(serial, own, places, &named, by_name, &others))).collect();
        for (own, reason) in reasons {
            found[own].serial_reason = reason;
        }
    }
}

fn reason(
    serial: &str,
    own: usize,
    places: &[usize],
    named: &[bool],
    by_name: bool,
    others: &dyn Fn(usize) -> String,
) -> Option<Reason> {
    if serial.is_empty() {
        let text = "the recording names no unit: record it with a serial";
        return Some(Reason::new(ReasonKind::WrongSerial, text));
    }
    if by_name && !named[own] {
        let also = if places.len() > 1 { format!(", which {} has too", others(own)) } else { String::new() };
        let text = format!("the recording's serial is {serial}{also}, and its file is named after another unit");
        return Some(Reason::new(ReasonKind::WrongSerial, text));
    }
    // Of several with one serial, the only one that is named after it is the unit's.
    let rivals = places.iter().filter(|place| named[**place] || !by_name).count();
    (rivals > 1).then(|| {
        let text = format!("serial {serial} is also that of {}: which is the unit's cannot be told", others(own));
        Reason::new(ReasonKind::DuplicateSerial, text)
    })
}

/// Whether a path has the serial between separators: `lot7/ZR-0001/full-temperature.parquet`, `ZR-0001_b.parquet`.
fn named_after(file: &str, serial: &str) -> bool {
    let inside = |letter: Option<char>| letter.is_some_and(char::is_alphanumeric);
    !serial.is_empty()
        && file
            .match_indices(serial)
            .any(|(at, _)| !inside(file[..at].chars().next_back()) && !inside(file[at + serial.len()..].chars().next()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_serial_is_found_between_separators_only() {
        assert!(named_after("ZR-000012.parquet", "ZR-000012"));
        assert!(named_after("a/ZR-1/full-temperature.parquet", "ZR-1"));
        assert!(!named_after("ZR-000012.parquet", "ZR-00001"));
        assert!(!named_after("ZR-12.parquet", ""));
    }

    #[test]
    fn of_two_with_one_serial_the_one_named_after_it_is_the_units() {
        let named = [true, false, true];
        let kind = |own, by_name| reason("A", own, &[0, 1], &named, by_name, &|_| "b".into()).map(|it| it.kind);
        assert_eq!(kind(0, true), None);
        assert_eq!(kind(1, true), Some(ReasonKind::WrongSerial));
        assert_eq!(kind(0, false), Some(ReasonKind::DuplicateSerial));
        assert_eq!(kind(1, false), Some(ReasonKind::DuplicateSerial));
        let twice = reason("A", 0, &[0, 2], &named, true, &|_| "b".into()).map(|it| it.kind);
        assert_eq!(twice, Some(ReasonKind::DuplicateSerial));
    }
}
