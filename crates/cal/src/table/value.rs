//! A cell's number: with a point or a comma, or a time of day and date.

use arrow_cast::parse::string_to_timestamp_nanos;

/// How the numbers of a column are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Notation {
    /// With a decimal point.
    Point,
    /// With a decimal comma; a point in one is none of a number's signs.
    Comma,
    /// As ISO 8601 and RFC 3339 write times: `2026-03-01T08:00:00.5Z`, also with a space for the T, or an offset from UTC;
    /// the date with its day first, `01.03.2026`, too.
    Stamp,
    /// The same without an offset: of some zone, which nobody knows.
    LocalStamp,
}

impl Notation {
    /// What a cell should be.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Point => "a number",
            Self::Comma => "a number with a decimal comma",
            Self::Stamp | Self::LocalStamp => "a time like 2026-03-01T08:00:00",
        }
    }

    /// How a cell's time is written, if it is one.
    pub(super) fn of_stamp(cell: &str) -> Option<Self> {
        stamp(cell.trim())?;
        // Ten letters are the date, whose signs are none of an offset's.
        let has_offset = cell.trim().get(10..).is_some_and(|time| time.contains(['Z', 'z', '+', '-']));
        Some(if has_offset { Self::Stamp } else { Self::LocalStamp })
    }

    /// A cell as a table with decimal points has it: `0,5` is `0.5` there, and all else is as it is.
    pub(super) fn pointed(self, cell: String) -> String {
        if self == Self::Comma && self.number(&cell).is_some() { cell.replacen(',', ".", 1) } else { cell }
    }

    /// A cell's number, of a time its seconds since 1970: NaN for one that is empty or says so in words, `None` for other
    /// text.
    pub(super) fn number(self, cell: &str) -> Option<f64> {
        let cell = cell.trim();
        let number = match self {
            Self::Point => cell.parse().ok(),
            Self::Comma if cell.contains('.') => None,
            Self::Comma => cell.replacen(',', ".", 1).parse().ok(),
            Self::Stamp | Self::LocalStamp => stamp(cell),
        };
        number.or_else(|| is_missing(cell).then_some(f64::NAN))
    }
}

fn is_missing(cell: &str) -> bool {
    ["", "nan", "na", "n/a", "null", "none"].iter().any(|missing| cell.eq_ignore_ascii_case(missing))
}

/// Seconds since 1970. A time without an offset is taken as one of UTC: of such only differences are used.
fn stamp(cell: &str) -> Option<f64> {
    // ISO 8601 knows the comma too.
    let cell = day_first(cell).unwrap_or_else(|| cell.to_owned()).replacen(',', ".", 1);
    let nanoseconds = string_to_timestamp_nanos(&cell).ok()?;
    Some(nanoseconds as f64 * 1e-9)
}

/// A date with points begins with its day, wherever it is written so: `01.03.2026 08:00:00`. With slashes nobody knows.
fn day_first(cell: &str) -> Option<String> {
    let (date, time) = cell.split_at_checked(10)?;
    let [day, month, year] = date.split('.').collect::<Vec<_>>()[..] else { return None };
    (day.len() == 2 && month.len() == 2).then(|| format!("{year}-{month}-{day}{time}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_says_its_offset_or_not() {
        for cell in ["2026-03-01T08:00:00Z", " 2026-03-01 08:00:00+02:00", "2026-03-01T08:00:00.250-05:00"] {
            assert_eq!(Notation::of_stamp(cell), Some(Notation::Stamp), "{cell}");
        }
        for cell in ["2026-03-01T08:00:00", "2026-03-01 08:00:00,5", "2026-03-01", "01.03.2026 08:00:00"] {
            assert_eq!(Notation::of_stamp(cell), Some(Notation::LocalStamp), "{cell}");
        }
        assert_eq!(Notation::of_stamp("1772352000"), None);
    }

    #[test]
    fn numbers_are_read_as_they_are_written_and_not_otherwise() {
        for (notation, cell, number) in [
            (Notation::Point, " -1.5e-3 ", Some(-1.5e-3)),
            (Notation::Point, "1,5", None),
            (Notation::Comma, "1,5", Some(1.5)),
            (Notation::Comma, "-2,5e-3", Some(-2.5e-3)),
            (Notation::Comma, "7", Some(7.0)),
            // A thousand and a half, and not one and a bit.
            (Notation::Comma, "1.000,5", None),
            (Notation::Comma, "1.000", None),
            // By `date -u -d ... +%s`.
            (Notation::Stamp, "2026-03-01T08:00:00Z", Some(1_772_352_000.0)),
            (Notation::Stamp, "2026-03-01T08:00:00.250+02:00", Some(1_772_344_800.25)),
            (Notation::Stamp, "2026-03-01 08:00:00,5", Some(1_772_352_000.5)),
            (Notation::Stamp, "01.03.2026 08:00:00,5", Some(1_772_352_000.5)),
            (Notation::Stamp, "13.13.2026 08:00:00", None),
            (Notation::Stamp, "03/01/2026 08:00:00", None),
            (Notation::Stamp, "1772352000", None),
        ] {
            let read = notation.number(cell);
            assert_eq!(read.is_some(), number.is_some(), "{cell}: {read:?}");
            assert!(read.zip(number).is_none_or(|(a, b)| (a - b).abs() < 1e-6), "{cell}: {read:?}");
        }
        assert!(Notation::Comma.number("n/a").is_some_and(f64::is_nan));
    }
}
