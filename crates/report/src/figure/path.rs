//! The data of an SVG path: all marks of one ink are one path, in whole units and relative steps, so that a page with
//! thousands of points goes by mail.

use std::fmt::Write as _;

use maud::{Markup, html};

use super::ink::{Ink, Marker};

/// A place in a drawing, drawing units.
pub(super) type Place = (i32, i32);

/// The radius of a marker where many crowd. Larger ones are for points that stand alone.
pub(super) const DENSE: i32 = 19;

/// The radius of a marker that stands alone.
pub(super) const SPARSE: i32 = 34;

/// A path on its way.
#[derive(Default)]
pub(super) struct Path {
    data: String,
    at: Place,
}

impl Path {
    /// A command with a pair of numbers, relative to the last point, as short as SVG allows.
    fn step(&mut self, command: char, to: Place) {
        let (dx, dy) = (to.0 - self.at.0, to.1 - self.at.1);
        let comma = if dy < 0 { "" } else { " " };
        // Writing to a string cannot fail.
        let _ = write!(self.data, "{command}{dx}{comma}{dy}");
        self.at = to;
    }

    /// The same with one more line through some points.
    pub(super) fn line(mut self, points: impl IntoIterator<Item = Place>) -> Self {
        let mut command = 'm';
        for point in points {
            if command == 'm' || point != self.at {
                self.step(command, point);
            }
            command = 'l';
        }
        self
    }

    /// The same with one more marker; the pen is at its centre again afterwards.
    pub(super) fn marker(mut self, centre: Place, marker: Marker, radius: i32) -> Self {
        self.step('m', centre);
        let _ = match marker {
            // A line of no length with round caps.
            Marker::Dot => write!(self.data, "h0"),
            Marker::Ring => {
                let (r, d) = (radius, radius * 2);
                write!(self.data, "m-{r} 0a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0-{d} 0zm{r} 0")
            }
            // Its weight is where the point is: two thirds from the tip.
            Marker::Triangle => {
                let (up, down) = (radius * 4 / 3, radius * 2 / 3);
                write!(self.data, "m0-{up}l{radius} {w}h-{d}zm0 {up}", w = up + down, d = radius * 2)
            }
        };
        self
    }

    /// The path as an element of an ink, drawn in one of the ways that the style sheet knows: `l` a line, `s` a line that
    /// is solid in every ink, `a` an area.
    pub(super) fn markup(&self, way: &str, ink: &str) -> Markup {
        html! { @if !self.data.is_empty() { path class={ (way) " " (ink) } d=(self.data) {} } }
    }
}

/// Markers of an ink.
pub(super) fn markers(points: impl IntoIterator<Item = Place>, ink: Ink, radius: i32) -> Markup {
    let marker = ink.marker();
    let way = match marker {
        Marker::Dot if radius > DENSE => "d big",
        Marker::Dot => "d",
        Marker::Ring | Marker::Triangle => "m",
    };
    let path = points.into_iter().fold(Path::default(), |path, point| path.marker(point, marker, radius));
    path.markup(way, ink.class())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_of_one_ink_are_one_path_of_short_steps() {
        let dots = markers([(5, 5), (7, 2)], Ink::X, DENSE).into_string();
        assert_eq!(dots, r#"<path class="d x" d="m5 5h0m2-3h0"></path>"#);
        let lines = Path::default().line([(0, 0), (10, 5), (10, 5)]).line([(0, 9), (1, 9)]);
        assert_eq!(lines.data, "m0 0l10 5m-10 4l1 0");
    }

    #[test]
    fn after_a_marker_the_pen_is_at_its_centre_again() {
        let data = markers([(50, 50), (60, 50)], Ink::Y, 30).into_string();
        // Up 40, then back down by as much; the next starts from the first one's centre.
        assert!(data.contains("m50 50m0-40") && data.contains("zm0 40m10 0m0-40"), "{data}");
    }
}
