//! A plan as people read it: how long, and until when by the clock on the wall.

use zerorate_bench::plan::Plan;

use crate::clock::{self, from_now, time};

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
    let (all, left) = (plan.parts.len(), plan.left_from(0));
    let steps = if left == all {
        format!("{all} steps")
    } else {
        format!("{left} of {all} steps {} left", if left == 1 { "is" } else { "are" })
    };
    clock::plan(&steps, plan.time_from(0).0)
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
