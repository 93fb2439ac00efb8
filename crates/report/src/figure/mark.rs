//! What is drawn in a panel.

use super::ink::Ink;
use super::thin::Point;

/// Something drawn in a panel, in the units of its axes. Points that are no numbers part a line and are left out.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A line through points.
    Line(Ink, Vec<Point>),
    /// A marker at each point.
    Dots(Ink, Vec<Point>),
    /// A line from zero to each point, and a marker there.
    Stems(Ink, Vec<Point>),
    /// A line across at this height.
    Level(Ink, f64),
    /// A shaded interval of the x axis, over the whole height.
    Band(Ink, f64, f64),
    /// A limit of the quantity on an axis: a line across the panel there, with its label.
    Limit(Side, f64, String),
}

/// Where a limit is, and of what.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The least on the x axis.
    Left,
    /// The greatest on the x axis.
    Right,
    /// The least on the y axis.
    Bottom,
    /// The greatest on the y axis.
    Top,
}

impl Mark {
    /// The points of a series; none of anything else.
    pub(super) fn points(&self) -> &[Point] {
        match self {
            Self::Line(_, points) | Self::Dots(_, points) | Self::Stems(_, points) => points,
            Self::Level(..) | Self::Band(..) | Self::Limit(..) => &[],
        }
    }
}
