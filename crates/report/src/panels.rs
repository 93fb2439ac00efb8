//! What the figures of a gyro's two axes have in common, on the page of a run that is over and of one that goes on: inks, names, panels.

use zerorate_core::units::Axis;

use super::figure::{Ink, Mark, Panel, Second};

/// Seconds in a minute: figures show time in minutes.
pub(super) const MINUTE_S: f64 = 60.0;

/// Temperature as a quantity with its unit.
pub(super) const TEMPERATURE: &str = "temperature reading, counts";

/// The ink of an axis.
pub(super) fn ink_of(axis: Axis) -> Ink {
    match axis {
        Axis::X => Ink::X,
        Axis::Y => Ink::Y,
    }
}

/// An axis's name as it is written, `X` or `Y`.
pub(super) fn name_of(axis: Axis) -> &'static str {
    match axis {
        Axis::X => "X",
        Axis::Y => "Y",
    }
}

/// Readings over temperature, and the curve that was fitted to them.
pub(super) fn over_temperature(
    axis: Axis,
    readings: Vec<(f64, f64)>,
    curve: Option<Vec<(f64, f64)>>,
    celsius: Option<Second>,
) -> Panel {
    let name = name_of(axis);
    let mut marks = vec![Mark::Dots(ink_of(axis), readings)];
    marks.extend(curve.map(|curve| Mark::Line(Ink::Curve, curve)));
    let title = format!("{name}: zero-rate output against temperature");
    Panel { second: celsius, ..Panel::new(title, TEMPERATURE, format!("{name}: zero-rate output, counts"), marks) }
}

/// What a fit leaves of readings, over temperature; `of_what` is the fit in words.
pub(super) fn residual(axis: Axis, left: Vec<(f64, f64)>, of_what: &str) -> Panel {
    let name = name_of(axis);
    let marks = [Mark::Dots(ink_of(axis), left), Mark::Level(Ink::Aim, 0.0)];
    let (title, up) = (format!("{name}: residual of {of_what}"), format!("{name}: residual, counts"));
    Panel { height: Panel::SHORT, ..Panel::new(title, TEMPERATURE, up, marks) }
}
