//! Labels that are dates: what can be none is told where it is typed. What was recorded is read as it is.

use std::collections::BTreeMap;

use chrono::{DateTime, NaiveDate, Utc};

/// What a label is called that says when an instrument was calibrated, behind the instrument's own label.
pub const CALIBRATED: &str = "_calibrated";

/// The label that says when a unit was recorded.
pub const RECORDED_AT: &str = "recorded_at";

/// The label that is a date by its name.
const DATE: &str = "date";

/// Hours by which the clocks of the easternmost zone are before UTC: there a day has begun that nowhere else has.
const EASTERNMOST_H: i64 = 14;

/// What is doubtful in labels, a sentence each: a date that is none, or in the future.
#[must_use]
pub fn label_doubts(labels: &BTreeMap<String, String>, now: DateTime<Utc>) -> Vec<String> {
    let doubt = |(name, value): (&String, &String)| {
        let why = doubt(name, value, now)?;
        Some(format!("label {name} = \"{value}\": {why}"))
    };
    labels.iter().filter_map(doubt).collect()
}

fn doubt(name: &str, value: &str, now: DateTime<Utc>) -> Option<&'static str> {
    const FUTURE: &str = "this is in the future";
    let time = DateTime::parse_from_rfc3339(value);
    if name == RECORDED_AT {
        return match time {
            Ok(time) => (time > now).then_some(FUTURE),
            Err(_) => Some(
                "this is no time with its zone, as 2026-01-05T06:00:00Z: a lot cannot tell when the unit was recorded",
            ),
        };
    }
    if name != DATE && !name.ends_with(CALIBRATED) {
        return None;
    }
    let today = (now + chrono::Duration::hours(EASTERNMOST_H)).date_naive();
    match time.map(|time| time.date_naive()).or_else(|_| NaiveDate::parse_from_str(value, "%Y-%m-%d")) {
        Ok(date) => (date > today).then_some(FUTURE),
        Err(_) => Some("this is no date, as 2026-02-01"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_that_are_none_or_have_not_come_are_told_and_other_words_are_not() {
        let now = DateTime::parse_from_rfc3339("2026-03-01T12:00:00Z").unwrap().to_utc();
        let told = |name: &str, value: &str| {
            label_doubts(&[(name.to_owned(), value.to_owned())].into(), now).pop().unwrap_or_default()
        };
        for sound in ["2026-02-28", "2024-02-29", "2026-03-02", "2026-02-28T23:59:59+01:00"] {
            assert_eq!(told("chamber_calibrated", sound), "", "{sound}");
        }
        for none in ["2026-02-29", "2026-13-01", "last spring", "01.02.2026", ""] {
            let expected = format!("label date = \"{none}\": this is no date, as 2026-02-01");
            assert_eq!(told("date", none), expected);
        }
        assert_eq!(
            told("supply_calibrated", "2062-02-01"),
            "label supply_calibrated = \"2062-02-01\": this is in the future"
        );
        assert_eq!(told("recorded_at", "2026-01-05T06:00:00Z"), "");
        assert!(told("recorded_at", "2026-01-05 06:00").contains("no time with its zone"));
        assert!(told("recorded_at", "2026-03-01T14:00:00+01:00").ends_with("in the future"));
        assert_eq!((told("operator", "2062-02-01"), told("next_calibration", "soon")), (String::new(), String::new()));
    }
}
