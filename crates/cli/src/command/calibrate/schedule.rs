//! A plan as people read it: how long, and until when by the clock on the wall.

use chrono::{DateTime, Local, SecondsFormat, TimeDelta};
use zerorate_bench::plan::Plan;

/// The whole plan, before it begins: a line for all of it and one for each step.
pub fn of(plan: &Plan) -> Vec<String> {
    let head = head(plan);
    let steps = plan.parts.iter().enumerate();
    let steps = steps.map(|(place, (part, took))| {
        let long = if took.0 > 0.0 { format!("about {}", time(took.0)) } else { "done before".to_owned() };
        format!("{}. {part}: {long}", place + 1)
    });
    std::iter::once(head).chain(steps).collect()
}

/// The whole plan in a line.
pub fn head(plan: &Plan) -> String {
    let whole = plan.time_from(0).0;
    let (all, left) = (plan.parts.len(), plan.left_from(0));
    let steps = if left == all { format!("{all} steps") } else { format!("{left} of {all} steps are left") };
    format!("the plan: {steps}, about {}; without delay it ends {}", time(whole), from_now(whole))
}

/// A step that begins, what is left after it, and when all of it ends.
pub fn step(plan: &Plan, place: usize) -> String {
    let (part, took) = plan.parts[place];
    let left = match plan.left_from(place + 1) {
        0 => "it is the last".to_owned(),
        1 => "1 step is left after it".to_owned(),
        steps => format!("{steps} steps are left after it"),
    };
    let (number, all) = (place + 1, plan.parts.len());
    format!(
        "step {number} of {all}: {part}, about {}; {left}, and the run ends about {}",
        time(took.0),
        end(plan, place)
    )
}

/// When the plan ends, if the step at this place begins now.
pub fn end(plan: &Plan, place: usize) -> String {
    from_now(plan.time_from(place).0)
}

/// The time of day so many seconds from now, with its day.
pub fn from_now(seconds: f64) -> String {
    clock(Local::now(), seconds)
}

/// The same for programs: RFC 3339.
pub fn stamp(seconds: f64) -> String {
    later(Local::now(), seconds).to_rfc3339_opts(SecondsFormat::Secs, false)
}

/// A time as `2 h 40 min`, to five minutes where it has hours.
pub fn time(seconds: f64) -> String {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // days at most
    let minutes = (seconds / 60.0).round() as u64;
    if minutes < 60 {
        return format!("{minutes} min");
    }
    let fives = (minutes + 2) / 5 * 5;
    format!("{} h {:02} min", fives / 60, fives % 60)
}

fn later(now: DateTime<Local>, seconds: f64) -> DateTime<Local> {
    #[allow(clippy::cast_possible_truncation)] // days at most
    let seconds = seconds as i64;
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
        assert_eq!([59.0 * 60.0, 3600.0, 9570.0].map(time), ["59 min", "1 h 00 min", "2 h 40 min"]);
    }

    #[test]
    fn a_days_work_ends_on_the_next_day() {
        use chrono::TimeZone;
        let monday = Local.with_ymd_and_hms(2026, 3, 2, 14, 30, 0).unwrap();
        assert_eq!(clock(monday, 27.5 * 3600.0), "Tue 3 Mar, 18:00");
    }
}
