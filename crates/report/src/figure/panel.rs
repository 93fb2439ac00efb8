//! One drawing: what stands on its axes, and what is drawn between them.

use maud::{Markup, html};

use super::frame::Frame;
use super::mark::{Mark, Side};
use super::scale::{Scale, holding};
use super::second::Second;
use crate::number::significant_text;

/// Ticks on an x axis, about: more, and labels of five digits would touch on a phone.
const ACROSS: f64 = 7.0;

/// A drawing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Panel {
    /// What it shows, for those who cannot see it.
    pub title: String,
    /// The x axis: quantity and unit.
    pub x_name: String,
    /// The y axis: quantity and unit.
    pub y_name: String,
    /// Height, drawing units.
    pub height: i32,
    /// The x range, where panels above each other must agree; else what the marks need.
    pub x_range: Option<(f64, f64)>,
    /// The y range, where panels beside each other must agree; else what the marks need.
    pub y_range: Option<(f64, f64)>,
    /// Another unit of the x axis, along the top.
    pub second: Option<Second>,
    /// The y axis counts things: from none, by whole numbers.
    pub counts: bool,
    /// Both axes are logarithms to base ten, and so are the marks.
    pub logarithms: bool,
    /// What is drawn, the lowest first; bands are beneath everything, and limits above it.
    pub marks: Vec<Mark>,
}

impl Panel {
    /// The usual height.
    pub const TALL: i32 = 3400;
    /// The height of a panel of residuals below another.
    pub const SHORT: i32 = 2100;

    /// A panel of the usual height with these marks.
    pub fn new(
        title: impl Into<String>,
        x_name: impl Into<String>,
        y_name: impl Into<String>,
        marks: impl Into<Vec<Mark>>,
    ) -> Self {
        let (title, x_name, y_name, marks) = (title.into(), x_name.into(), y_name.into(), marks.into());
        Self { title, x_name, y_name, marks, height: Self::TALL, ..Self::default() }
    }

    fn scales(&self) -> (Scale, Scale) {
        let points = || self.marks.iter().flat_map(Mark::points);
        let (across, heights) = (points().map(|point| point.0), points().map(|point| point.1));
        if self.logarithms {
            return (Scale::decades(across), Scale::decades(heights));
        }
        let bands = self.marks.iter().filter_map(|mark| match mark {
            Mark::Band(_, from, to) => Some([*from, *to]),
            _ => None,
        });
        let x = Scale::over(self.x_range.or_else(|| holding(across.chain(bands.flatten()))), ACROSS);
        let levels = self.marks.iter().filter_map(|mark| match mark {
            Mark::Level(_, at) | Mark::Limit(Side::Bottom | Side::Top, at, _) => Some(*at),
            Mark::Stems(..) => Some(0.0),
            _ => None,
        });
        let up = if self.height > Self::SHORT + 400 { 8.0 } else { 4.5 };
        let heights = heights.chain(levels);
        let y = match self.y_range {
            None if self.counts => Scale::counting(heights, up),
            range => Scale::over(range.or_else(|| holding(heights)), up),
        };
        (x, y)
    }

    /// The panel as an `svg` element; `id` must be the only one of its kind in the page.
    pub(super) fn markup(&self, id: &str) -> Markup {
        let (x, y) = self.scales();
        let (title, description) = (format!("{id}-t"), format!("{id}-d"));
        let told = self.description(&x, &y);
        let frame = Frame::new(x, y, self.second.as_ref(), self.height);
        html! {
            svg viewBox=(frame.view_box()) role="img" aria-labelledby={ (title) " " (description) } {
                title id=(title) { (self.title) }
                desc id=(description) { (told) }
                @for mark in &self.marks { @if let Mark::Band(ink, from, to) = mark { (frame.band(*ink, *from, *to)) } }
                (frame.axes(&self.x_name, &self.y_name))
                @for mark in &self.marks { (frame.mark(mark)) }
                @for mark in &self.marks {
                    @if let Mark::Limit(side, at, label) = mark { (frame.limit(*side, *at, label)) }
                }
            }
        }
    }

    fn description(&self, x: &Scale, y: &Scale) -> String {
        let ends = |name: &str, (from, to): (f64, f64)| {
            let written =
                |value: f64| significant_text(if self.logarithms { libm::pow(10.0, value) } else { value }, 4);
            format!("{name}, from {} to {}", written(from), written(to))
        };
        format!("Across: {}. Up: {}.", ends(&self.x_name, x.range), ends(&self.y_name, y.range))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Ink;

    fn svg() -> String {
        let drift = (0..2400).map(|i| (f64::from(i), (f64::from(i) / 300.0).sin())).collect();
        let marks = [Mark::Dots(Ink::X, drift), Mark::Level(Ink::Aim, 0.0)];
        Panel::new("A < B", "time, s", "rate, rad/s", marks).markup("f1").into_string()
    }

    #[test]
    fn a_panel_is_an_image_with_a_title_and_a_description() {
        let svg = svg();
        assert!(svg.contains(r#"role="img" aria-labelledby="f1-t f1-d""#));
        assert!(svg.contains(r#"<title id="f1-t">A &lt; B</title>"#));
        assert!(svg.contains("Across: time, s, from "), "{svg}");
    }

    #[test]
    fn thousands_of_points_are_a_few_kilobytes() {
        assert!(svg().len() < 10_000, "{}", svg().len());
    }

    #[test]
    fn colours_are_left_to_the_style_sheet() {
        let svg = svg();
        assert!(!svg.contains('#') && svg.contains(r#"class="d x""#) && svg.contains(r#"class="l aim""#));
    }

    #[test]
    fn an_empty_panel_and_one_with_nothing_but_holes_are_drawn() {
        for marks in [vec![], vec![Mark::Line(Ink::X, vec![(f64::NAN, 1.0)])]] {
            assert!(Panel::new("", "", "", marks).markup("f").into_string().ends_with("</svg>"));
        }
    }

    #[test]
    fn small_rates_name_their_power_of_ten() {
        let marks = [Mark::Dots(Ink::X, vec![(0.0, 1e-3), (1.0, 4e-3)])];
        let small = Panel::new("", "temperature, °C", "rate, rad/s", marks).markup("f").into_string();
        assert!(small.contains("rate, 10⁻³ rad/s"));
    }
}
