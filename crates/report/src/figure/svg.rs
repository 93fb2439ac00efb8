//! A backend of plotters that writes SVG with classes instead of colours.
//!
//! plotters' own SVG backend writes colours into every element, and one element a point: it could not follow a dark
//! scheme, and a report would be five times as long. Here marks of one ink that follow each other become one path.

use std::convert::Infallible;
use std::fmt::Write as _;

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind};

use super::ink::{Ink, Marker};

/// Units of the drawing in one unit of the panel: plotters' coordinates are whole numbers, and a tenth is fine enough.
pub(super) const FINE: i32 = 10;

/// The radius of a marker where many crowd, drawing units. Larger ones are for points that stand alone.
pub(super) const DENSE: i32 = 19;

/// The radius of a marker that stands alone, drawing units.
pub(super) const SPARSE: i32 = 34;

/// The stroke width by which plotters is told to draw a line solid in every ink.
pub(super) const STEM: u32 = 2;

/// How a path is painted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Paint {
    Line,
    /// A line that is solid in every ink.
    Stem,
    /// Dots of this radius, drawing units.
    Dots(i32),
    Marks,
    Area,
}

impl Paint {
    fn class(self) -> &'static str {
        match self {
            Self::Line => "l",
            Self::Stem => "s",
            Self::Dots(radius) if radius > DENSE => "d big",
            Self::Dots(_) => "d",
            Self::Marks => "m",
            Self::Area => "a",
        }
    }
}

/// Writes the inside of an `svg` element.
pub(super) struct ClassedSvg<'a> {
    out: &'a mut String,
    size: (u32, u32),
    run: Option<(Paint, Ink)>,
    path: String,
    at: BackendCoord,
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl<'a> ClassedSvg<'a> {
    /// Draws into `out`; the size is in drawing units.
    pub(super) fn new(out: &'a mut String, size: (u32, u32)) -> Self {
        Self { out, size, run: None, path: String::new(), at: (0, 0) }
    }

    /// Begins a path, or goes on with one of the same ink and paint.
    fn begin(&mut self, paint: Paint, color: BackendColor) {
        let run = Some((paint, Ink::of(color.rgb)));
        if self.run != run {
            self.end();
            self.run = run;
        }
    }

    /// Writes the path begun, if any.
    fn end(&mut self) {
        if let Some((paint, ink)) = self.run.take() {
            // Writing to a string cannot fail.
            let _ = writeln!(self.out, r#"<path class="{} {}" d="{}"/>"#, paint.class(), ink.class(), self.path);
        }
        self.path.clear();
        self.at = (0, 0);
    }

    /// A command with a pair of numbers, relative to the last point, as short as SVG allows.
    fn step(&mut self, command: char, to: BackendCoord) {
        let (dx, dy) = (to.0 - self.at.0, to.1 - self.at.1);
        let comma = if dy < 0 { "" } else { " " };
        let _ = write!(self.path, "{command}{dx}{comma}{dy}");
        self.at = to;
    }

    fn marker(&mut self, centre: BackendCoord, marker: Marker, radius: i32) {
        self.step('m', centre);
        let _ = match marker {
            // A line of no length with round caps.
            Marker::Dot => write!(self.path, "h0"),
            Marker::Ring => {
                let (r, d) = (radius, radius * 2);
                write!(self.path, "m-{r} 0a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0-{d} 0zm{r} 0")
            }
            // Its weight is where the point is: two thirds from the tip.
            Marker::Triangle => {
                let (up, down) = (radius * 4 / 3, radius * 2 / 3);
                write!(self.path, "m0-{up}l{radius} {w}h-{d}zm0 {up}", w = up + down, d = radius * 2)
            }
        };
    }
}

impl DrawingBackend for ClassedSvg<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        self.end();
        Ok(())
    }

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> Drawn {
        self.begin(Paint::Dots(DENSE), color);
        self.marker(point, Marker::Dot, DENSE);
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        bottom_right: BackendCoord,
        style: &S,
        _fill: bool,
    ) -> Drawn {
        let ((left, top), (right, bottom)) = (upper_left, bottom_right);
        self.fill_polygon([(left, top), (right, top), (right, bottom), (left, bottom)], style)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Drawn {
        if style.color().alpha <= 0.0 {
            return Ok(());
        }
        self.begin(if style.stroke_width() == STEM { Paint::Stem } else { Paint::Line }, style.color());
        let mut command = 'm';
        for point in path {
            if command == 'm' || point != self.at {
                self.step(command, point);
            }
            command = 'l';
        }
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(&mut self, center: BackendCoord, radius: u32, style: &S, _fill: bool) -> Drawn {
        let marker = Ink::of(style.color().rgb).marker();
        let radius = radius.cast_signed();
        self.begin(if marker == Marker::Dot { Paint::Dots(radius) } else { Paint::Marks }, style.color());
        self.marker(center, marker, radius);
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, vert: I, style: &S) -> Drawn {
        self.begin(Paint::Area, style.color());
        let mut first = None;
        for point in vert {
            self.step(if first.is_none() { 'm' } else { 'l' }, point);
            first = first.or(Some(point));
        }
        self.path.push('z');
        self.at = first.unwrap_or(self.at);
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Drawn {
        self.end();
        let anchor = match style.anchor().h_pos {
            HPos::Left => "",
            HPos::Center => r#" text-anchor="middle""#,
            HPos::Right => r#" text-anchor="end""#,
        };
        // Digits are 0.72 em high in most fonts.
        let drop = match style.anchor().v_pos {
            VPos::Top => r#" dy=".72em""#,
            VPos::Center => r#" dy=".36em""#,
            VPos::Bottom => "",
        };
        let class = Ink::of(style.color().rgb).class();
        let _ = writeln!(self.out, r#"<text class="{class}" x="{x}" y="{y}"{anchor}{drop}>{}</text>"#, escaped(text));
        Ok(())
    }
}

/// Text as it may stand in SVG.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn color(ink: Ink) -> BackendColor {
        let color = ink.color();
        BackendColor { alpha: color.3, rgb: (color.0, color.1, color.2) }
    }

    #[test]
    fn marks_of_one_ink_become_one_path_with_its_class() {
        let mut out = String::new();
        let mut svg = ClassedSvg::new(&mut out, (100, 100));
        svg.draw_circle((5, 5), 19, &color(Ink::X), true).unwrap();
        svg.draw_circle((7, 2), 19, &color(Ink::X), true).unwrap();
        svg.draw_line((0, 0), (10, 5), &color(Ink::Grid)).unwrap();
        svg.present().unwrap();
        assert_eq!(out, "<path class=\"d x\" d=\"m5 5h0m2-3h0\"/>\n<path class=\"l grid\" d=\"m0 0l10 5\"/>\n");
    }

    #[test]
    fn after_a_marker_the_pen_is_at_its_centre_again() {
        let mut out = String::new();
        let mut svg = ClassedSvg::new(&mut out, (100, 100));
        svg.draw_circle((50, 50), 30, &color(Ink::Y), true).unwrap();
        svg.draw_circle((60, 50), 30, &color(Ink::Y), true).unwrap();
        svg.present().unwrap();
        // Up 40, then back down by as much; the next starts from the first one's centre.
        assert!(out.contains("m50 50m0-40") && out.contains("zm0 40m10 0m0-40"), "{out}");
    }

    #[test]
    fn text_is_escaped() {
        assert_eq!(escaped("a<b & \"c\""), "a&lt;b &amp; &quot;c&quot;");
    }
}
