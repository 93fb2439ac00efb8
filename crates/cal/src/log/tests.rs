use super::*;
use crate::quality::ReasonKind;
use crate::units::TimeUnit;

/// Passes everything over.
struct Nothing;

impl Sink for Nothing {
    fn stream(&mut self, _: &Stream) -> bool {
        false
    }

    fn rows(&mut self, _: &Rows<'_>) {}
}

/// When a table of two rows began, seconds since 1970, by its column of times.
fn started_s(name: &str, times: [&str; 2]) -> Option<u64> {
    let [first, second] = times;
    let text = format!("{name};temp_c;gyro_x_dps\n{first};20.0;0.1\n{second};21.0;0.2\n");
    let log = LogFile::open(&Source::bytes("log.csv", text.into_bytes()), &Columns::default()).unwrap();
    let started = log.read(&mut Nothing).unwrap().started?;
    Some(started.duration_since(SystemTime::UNIX_EPOCH).unwrap().as_secs())
}

#[test]
fn a_table_tells_when_it_began_only_by_times_of_a_known_zone() {
    // `date -u -d 2026-03-01T14:03:00Z +%s`
    let known = Some(1_772_373_780);
    assert_eq!(started_s("time", ["2026-03-01T14:03:00Z", "2026-03-01T14:04:00Z"]), known);
    assert_eq!(started_s("time", ["2026-03-01 16:03:00+02:00", "2026-03-01 16:04:00+02:00"]), known);
    assert_eq!(started_s("time_s", ["1772373780", "1772373840"]), known);
    assert_eq!(started_s("timestamp_us", ["1772373780000000", "1772373840000000"]), known);
    // Of no zone, and from the start of something.
    assert_eq!(started_s("time", ["2026-03-01T14:03:00", "2026-03-01T14:04:00"]), None);
    assert_eq!(started_s("time_s", ["0", "60"]), None);
    assert_eq!(started_s("timestamp_us", ["1772373780", "1832373780"]), None);
    // By an unset clock, and beyond all clocks.
    assert_eq!(started_s("time", ["1980-01-06T00:00:00Z", "1980-01-06T00:01:00Z"]), None);
    assert_eq!(started_s("time_s", ["1e300", "1.1e300"]), None);
}

/// What is told of a table's time, given by name and cells.
fn of_time(name: &str, times: &[&str]) -> Vec<(ReasonKind, String)> {
    let rows: String = times.iter().map(|time| format!("{time},20.0,0.1\n")).collect();
    let text = format!("{name},temp_c,gyro_x_dps\n{rows}");
    let log = LogFile::open(&Source::bytes("log.csv", text.into_bytes()), &Columns::default()).unwrap();
    let ending = log.read(&mut Nothing).unwrap();
    ending.reasons.into_iter().map(|reason| (reason.kind, reason.text)).collect()
}

#[test]
fn a_time_without_a_unit_by_which_a_log_may_last_minutes_or_days_is_a_warning() {
    let [(kind, text)] = &of_time("time", &["0", "54000", "108000"])[..] else { panic!() };
    assert_eq!(*kind, ReasonKind::GuessedUnit);
    assert_eq!(
        text,
        "'time' names no unit: taken as ms, by which the log lasts 108 s (`time_unit` says otherwise); in s it would be 30 h"
    );
    for times in [["0", "1800", "3600"], ["0", "900000", "3600000"], ["0", "60", "120"]] {
        let [(kind, text)] = &of_time("time", &times)[..] else { panic!() };
        assert!(*kind == ReasonKind::AssumedUnit && !text.contains(" h"), "{text}");
    }
    assert!(of_time("time_s", &["0", "54000", "108000"]).is_empty());
}

#[test]
fn rows_without_a_time_are_counted() {
    let [(kind, text)] = &of_time("time_s", &["0", "nan", "600", "", "1200"])[..] else { panic!() };
    assert_eq!(*kind, ReasonKind::MissingValues);
    assert_eq!(text, "'time_s' has no number in 2 of 5 rows: they count where they stand between the others");
    let [(kind, text)] = &of_time("time_s", &["5", "5", "5"])[..] else { panic!() };
    assert!(*kind == ReasonKind::MissingValues && text.contains("does not move"), "{text}");
}

fn opened(text: String, columns: &Columns) -> Result<LogFile, LogError> {
    LogFile::open(&Source::bytes("log.csv", text.into_bytes()), columns)
}

#[test]
fn a_unit_by_which_no_gyro_could_be_read_so_often_is_asked_about() {
    let rows: String = (0..200).map(|row| format!("{},20.0,0.1\n", f64::from(row) * 30.0)).collect();
    let text = |unit: &str| format!("time_{unit},temp_c,gyro_x_dps\n{rows}");
    let told = opened(text("us"), &Columns::default()).unwrap_err().to_string();
    assert!(told.contains("'time_us' says us") && told.contains("(`time_unit` s)"), "{told}");
    assert!(opened(text("s"), &Columns::default()).is_ok());
    // Whoever says so is believed.
    let asked = Columns { time_unit: Some(TimeUnit::Us), ..Columns::default() };
    assert!(opened(text("us"), &asked).is_ok());
}

#[test]
fn the_time_between_rows_is_that_of_rows_and_not_of_gaps() {
    // Two rows a second, with a night and two weekends between them.
    let times = (0..4000).map(|row| 0.5 * f64::from(row) + [0.0, 40_000.0, 300_000.0, 600_000.0][row as usize / 1000]);
    let rows: String = times.map(|time| format!("{time},20.0,0.1\n")).collect();
    let (rows, step_s) =
        opened(format!("time_s,temp_c,gyro_x_dps\n{rows}"), &Columns::default()).unwrap().extent().unwrap();
    assert!(rows == 4000 && (step_s - 0.5).abs() < 1e-9, "{rows} {step_s}");
}

#[test]
fn a_counter_of_32_bits_that_is_full_is_counted_on() {
    struct Times(Vec<f64>);
    impl Sink for Times {
        fn stream(&mut self, _: &Stream) -> bool {
            true
        }

        fn rows(&mut self, rows: &Rows<'_>) {
            self.0.extend(rows.time_s);
        }
    }
    // Of `micros()`, and the same where the number has a sign.
    for [before, after] in [["4294966296", "1999000"], ["2147482648", "-2145484648"]] {
        let text = format!("t_us,temp_c,gyro_x_dps\n4292967296,20.0,0.1\n{before},20.0,0.1\n{after},20.0,0.1\n");
        let text = if after.starts_with('-') { text.replace("4292967296", "2145483648") } else { text };
        let log = LogFile::open(&Source::bytes("log.csv", text.into_bytes()), &Columns::default()).unwrap();
        let mut times = Times(Vec::new());
        let ending = log.read(&mut times).unwrap();
        // 2^32 = 4294967296.
        let wanted = [0.0, 1.999, 3.999];
        assert!(times.0.iter().zip(wanted).all(|(time, wanted)| (time - wanted).abs() < 1e-9), "{:?}", times.0);
        assert_eq!(
            ending.notes,
            ["'t_us' starts anew where a counter of 32 bits is full; it is counted on from there"]
        );
    }
    let joined = "t_us,temp_c,gyro_x_dps\n4000000000,20.0,0.1\n4100000000,20.0,0.1\n0,20.0,0.1\n";
    let error = LogFile::open(&Source::bytes("log.csv", joined.as_bytes()), &Columns::default()).unwrap_err();
    assert!(error.to_string().contains("runs backwards, from 4100000000 to 0"), "{error}");
}
