//! The temperatures of axes, as a screen and a page tell them.

use zerorate_cal::log_fit::AxisFit;
use zerorate_cal::units::from_to;
use zerorate_core::drift::ValidRange;

/// What the axes were fitted to, each degree called `unit`; where they differ, each range with the axes that have it.
#[must_use]
pub fn measured_temperatures(axes: &[&AxisFit], unit: &str) -> String {
    told(axes, unit, |axis| axis.calibration.fit.measured)
}

/// The same of how far their curves are believed.
#[must_use]
pub fn believed_temperatures(axes: &[&AxisFit], unit: &str) -> String {
    told(axes, unit, |axis| axis.calibration.drift().valid)
}

fn told(axes: &[&AxisFit], unit: &str, of: impl Fn(&AxisFit) -> ValidRange) -> String {
    let mut found: Vec<(String, Vec<&str>)> = Vec::new();
    for axis in axes {
        let range = format!("{} {unit}", from_to(of(axis).min(), of(axis).max()));
        match found.iter_mut().find(|(known, _)| *known == range) {
            Some((_, names)) => names.push(&axis.name),
            None => found.push((range, vec![&axis.name])),
        }
    }
    let alone = found.len() == 1;
    let each = |(range, names): &(String, Vec<&str>)| {
        if alone { range.clone() } else { format!("{range} ({})", names.join(", ")) }
    };
    found.iter().map(each).collect::<Vec<_>>().join(" and ")
}
