//! Times as people read them: how long, and until when by the clock on the wall.

use chrono::{DateTime, Local, SecondsFormat, TimeDelta};

/// The time of day so many seconds from now, with its day.
pub fn from_now(seconds: f64) -> String {
    clock(Local::now(), seconds)
}

/// The same for programs: RFC 3339.
pub fn stamp(seconds: f64) -> String {
    later(Local::now(), seconds).to_rfc3339_opts(SecondsFormat::Secs, false)
}

/// A time as `2 h 40 min`, to five minutes where it has hours; less than a minute in seconds.
pub fn time(seconds: f64) -> String {
    if seconds < 59.5 {
        return format!("{seconds:.0} s");
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // days at most
    let minutes = (seconds / 60.0).round() as u64;
    if minutes < 60 {
        return format!("{minutes} min");
    }
    let fives = (minutes + 2) / 5 * 5;
    format!("{} h {:02} min", fives / 60, fives % 60)
}

/// A whole plan in a line: its steps in words, how long they take, and when the last ends.
pub fn plan(steps: &str, seconds: f64) -> String {
    format!("the plan: {steps}, about {}; without delay it ends {}", time(seconds), from_now(seconds))
}

/// No later than a thousand years: nobody waits for what takes longer.
fn later(now: DateTime<Local>, seconds: f64) -> DateTime<Local> {
    #[allow(clippy::cast_possible_truncation)] // within a thousand years
    let seconds = seconds.clamp(0.0, 1000.0 * 365.25 * 86_400.0) as i64;
    now + TimeDelta::seconds(seconds)
}

fn clock(now: DateTime<Local>, seconds: f64) -> String {
    later(now, seconds).format("%a %e %b, %H:%M").to_string().replace("  ", " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_said_as_people_say_it() {
        let told = ["20 s", "1 min", "59 min", "1 h 00 min", "2 h 40 min"];
        assert_eq!([20.4, 59.6, 59.0 * 60.0, 3600.0, 9570.0].map(time), told);
    }

    #[test]
    fn a_days_work_ends_on_the_next_day() {
        use chrono::TimeZone;
        let monday = Local.with_ymd_and_hms(2026, 3, 2, 14, 30, 0).unwrap();
        assert_eq!(clock(monday, 27.5 * 3600.0), "Tue 3 Mar, 18:00");
    }
}
