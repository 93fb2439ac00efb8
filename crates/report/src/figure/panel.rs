//! One drawing: an x axis, a y axis, and marks.

use std::convert::Infallible;
use std::fmt::Write as _;

use plotters::chart::ChartBuilder;
use plotters::drawing::{DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, IntoFont, TextStyle};

use super::ink::Ink;
use super::scale::Scale;
use super::svg::{ClassedSvg, DENSE, FINE, SPARSE, STEM, escaped};
use super::thin::{MOST, runs, sample, thin};
use crate::number::{raised, significant_text};

/// Width of a panel: two of them side by side fill a desktop page, one fills a phone at two thirds of its size.
const WIDTH: i32 = 560;

/// Height of the type, which the style sheet sets to the same: on a phone 14 of 560 units are 9 pixels.
const TYPE: i32 = 14;

/// Room for the labels of the y axis: eight digits of a wide font.
const LEFT: u32 = 70;

/// Room for half a label at the right end of the x axis.
const RIGHT: i32 = 24;

/// Room for the labels of the x axis and its name.
const BELOW: u32 = 48;

/// Room for the name of the y axis, above the drawing where it needs no turning of the head.
const ABOVE: i32 = 30;

/// The least width of a band, as a part of the x axis.
const NARROWEST: f64 = 0.006;

/// Ticks on an x axis, about: more, and labels of five digits would touch on a phone.
const ACROSS: f64 = 7.0;

/// The part of the x axis that a limit's label takes, about.
const ROOM: f64 = 0.35;

/// The part of the y axis that it takes, on a phone.
const LOW: f64 = 0.1;

/// Something drawn in a panel, in the units of its axes. Points that are no numbers part a line and are left out.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A line through points.
    Line(Ink, Vec<(f64, f64)>),
    /// A marker at each point.
    Dots(Ink, Vec<(f64, f64)>),
    /// A line from zero to each point, and a marker there.
    Stems(Ink, Vec<(f64, f64)>),
    /// A line across at this height.
    Level(Ink, f64),
    /// A shaded stretch of the x axis, over the whole height.
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
    fn points(&self) -> &[(f64, f64)] {
        match self {
            Self::Line(_, points) | Self::Dots(_, points) | Self::Stems(_, points) => points,
            Self::Level(..) | Self::Band(..) | Self::Limit(..) => &[],
        }
    }
}

/// A drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// What it shows, for those who cannot see it.
    pub title: String,
    /// The x axis: quantity and unit.
    pub x_name: String,
    /// The y axis: quantity and unit.
    pub y_name: String,
    /// Height in units of which the panel is 560 wide.
    pub height: i32,
    /// The x range, where panels above each other must agree; else what the marks need.
    pub x_range: Option<(f64, f64)>,
    /// The y range, where panels beside each other must agree; else what the marks need.
    pub y_range: Option<(f64, f64)>,
    /// The y axis counts things: from none, by whole numbers.
    pub counts: bool,
    /// Both axes are logarithms to base ten, and so are the marks.
    pub logarithms: bool,
    /// What is drawn, the lowest first.
    pub marks: Vec<Mark>,
}

impl Panel {
    /// The usual height.
    pub const TALL: i32 = 340;
    /// The height of a panel of residuals below another.
    pub const SHORT: i32 = 210;

    /// An empty panel.
    pub fn new(title: impl Into<String>, x_name: impl Into<String>, y_name: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            x_name: x_name.into(),
            y_name: y_name.into(),
            height: Self::TALL,
            x_range: None,
            y_range: None,
            counts: false,
            logarithms: false,
            marks: Vec::new(),
        }
    }

    /// The same with another height.
    pub fn with_height(mut self, height: i32) -> Self {
        self.height = height;
        self
    }

    /// The same with one more mark on top.
    pub fn with(mut self, mark: Mark) -> Self {
        self.marks.push(mark);
        self
    }

    /// The same over a given x range.
    pub fn with_x_range(mut self, range: Option<(f64, f64)>) -> Self {
        self.x_range = range;
        self
    }

    /// The same over a given y range.
    pub fn with_y_range(mut self, range: Option<(f64, f64)>) -> Self {
        self.y_range = range;
        self
    }

    /// The same with a y axis that counts things.
    pub fn with_counts(mut self) -> Self {
        self.counts = true;
        self
    }

    /// The same over logarithms: marks are logarithms to base ten on both axes.
    pub fn with_logarithms(mut self) -> Self {
        self.logarithms = true;
        self
    }

    fn scales(&self) -> (Scale, Scale) {
        let points = || self.marks.iter().flat_map(Mark::points);
        if self.logarithms {
            return (Scale::decades(points().map(|point| point.0)), Scale::decades(points().map(|point| point.1)));
        }
        let x = self.x_range.map_or_else(
            || {
                let bands = self.marks.iter().filter_map(|mark| match mark {
                    Mark::Band(_, from, to) => Some([*from, *to]),
                    _ => None,
                });
                Scale::holding(points().map(|point| point.0).chain(bands.flatten()), ACROSS)
            },
            |range| Scale::over(range, ACROSS),
        );
        let levels = self.marks.iter().filter_map(|mark| match mark {
            Mark::Level(_, at) | Mark::Limit(Side::Bottom | Side::Top, at, _) => Some(*at),
            Mark::Stems(..) => Some(0.0),
            _ => None,
        });
        let up = if self.height > Self::SHORT + 40 { 8.0 } else { 4.5 };
        let heights = points().map(|point| point.1).chain(levels);
        let y = match self.y_range {
            Some(range) => Scale::over(range, up),
            None if self.counts => Scale::counting(heights, up),
            None => Scale::holding(heights, up),
        };
        (x, y)
    }

    /// The panel as an `svg` element; `id` must be the only one of its kind in the page.
    pub fn svg(&self, id: &str) -> String {
        let (x, y) = self.scales();
        let (width, height) = (WIDTH * FINE, self.height * FINE);
        let mut out = format!(
            "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-labelledby=\"{id}-t {id}-d\">\n\
             <title id=\"{id}-t\">{}</title>\n<desc id=\"{id}-d\">{}</desc>\n",
            escaped(&self.title),
            escaped(&self.description(&x, &y)),
        );
        // The backend cannot fail: it writes to memory.
        let _ = self.draw(&x, &y, ClassedSvg::new(&mut out, (width.unsigned_abs(), height.unsigned_abs())));
        let _ = writeln!(out, "</svg>");
        out
    }

    fn description(&self, x: &Scale, y: &Scale) -> String {
        let ends = |name: &str, scale: &Scale| {
            let written = |value: f64| significant_text(if self.logarithms { 10_f64.powf(value) } else { value }, 4);
            format!("{name}, from {} to {}", written(scale.range.0), written(scale.range.1))
        };
        format!("Across: {}. Up: {}.", ends(&self.x_name, x), ends(&self.y_name, y))
    }

    fn draw(&self, x: &Scale, y: &Scale, svg: ClassedSvg<'_>) -> Result<(), DrawingAreaErrorKind<Infallible>> {
        let root = svg.into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .margin_top(ABOVE * FINE)
            .margin_right(RIGHT * FINE)
            .x_label_area_size(BELOW * FINE.unsigned_abs())
            .y_label_area_size(LEFT * FINE.unsigned_abs())
            .build_cartesian_2d(x.clone(), y.clone())?;
        let (top, bottom) = (y.range.1, y.range.0);
        for mark in &self.marks {
            if let Mark::Band(ink, from, to) = mark {
                // A stretch of one group must still be seen.
                let room = (NARROWEST * (x.range.1 - x.range.0) - (to - from)).max(0.0) / 2.0;
                let (from, to) = ((from - room).max(x.range.0), (to + room).min(x.range.1));
                chart.draw_series([Rectangle::new([(from, top), (to, bottom)], ink.style())])?;
            }
        }
        chart
            .configure_mesh()
            .axis_style(Ink::Frame.style())
            .bold_line_style(Ink::Grid.style())
            .disable_x_mesh()
            .label_style(words(Ink::Word))
            .set_all_tick_mark_size(5 * FINE)
            .draw()?;
        let name = words(Ink::Word);
        let (right, low) = (WIDTH - RIGHT, self.height - 5);
        let at_end = name.pos(Pos::new(HPos::Right, VPos::Bottom));
        root.draw_text(&named(&self.x_name, x), &at_end, (right * FINE, low * FINE))?;
        let at_start = name.pos(Pos::new(HPos::Left, VPos::Top));
        root.draw_text(&named(&self.y_name, y), &at_start, (0, 2 * FINE))?;

        for mark in &self.marks {
            match mark {
                // Beneath everything, and above it.
                Mark::Band(..) | Mark::Limit(..) => {}
                Mark::Line(ink, points) => {
                    let of = points.len().max(1);
                    for run in runs(points) {
                        // Each run has its share of the points drawn.
                        let run = thin(&run, (MOST * run.len() / of).max(2));
                        chart.draw_series([PathElement::new(run, ink.style())])?;
                    }
                }
                Mark::Dots(ink, points) => {
                    let points = sample(&runs(points).concat(), MOST);
                    let radius = radius(points.len());
                    chart.draw_series(points.into_iter().map(|point| Circle::new(point, radius, ink.style())))?;
                }
                Mark::Stems(ink, points) => {
                    let stem_style = ink.style().stroke_width(STEM);
                    let stem = |&(x, y): &(f64, f64)| PathElement::new([(x, 0.0), (x, y)], stem_style);
                    chart.draw_series(points.iter().map(stem))?;
                    chart.draw_series(points.iter().map(|point| Circle::new(*point, SPARSE, ink.style())))?;
                }
                Mark::Level(ink, at) => {
                    chart.draw_series([PathElement::new([(x.range.0, *at), (x.range.1, *at)], ink.style())])?;
                }
            }
        }
        for mark in &self.marks {
            if let Mark::Limit(side, at, label) = mark {
                let end = if matches!(side, Side::Left | Side::Right) { (*at, top) } else { (x.range.1, *at) };
                let start = if matches!(side, Side::Left | Side::Right) { (*at, bottom) } else { (x.range.0, *at) };
                chart.draw_series([PathElement::new([start, end], Ink::Limit.style())])?;
                let (label_at, anchor) = side.label(chart.backend_coord(&end), x.share(*at), y.share(*at));
                root.draw_text(label, &words(Ink::Limit).pos(anchor), label_at)?;
            }
        }
        root.present()
    }
}

impl Side {
    /// Where the label of a limit's line stands that ends at `end`, the line being at this share of the axis: outside the
    /// limit where there is room. The least's is a row below the greatest's, so that the two never touch.
    fn label(self, (right, high): (i32, i32), across: f64, up: f64) -> ((i32, i32), Pos) {
        let gap = 4 * FINE;
        match self {
            Self::Left | Self::Right => {
                let row = if self == Self::Left { high + gap + TYPE * FINE * 3 / 2 } else { high + gap };
                let before = if self == Self::Left { across > ROOM } else { across > 1.0 - ROOM };
                let (place, to) = if before { (right - gap, HPos::Right) } else { (right + gap, HPos::Left) };
                ((place, row), Pos::new(to, VPos::Top))
            }
            Self::Bottom | Self::Top => {
                let above = if self == Self::Top { up < 1.0 - LOW } else { up < LOW };
                let (place, to) = if above { (high - gap, VPos::Bottom) } else { (high + gap, VPos::Top) };
                ((right, place), Pos::new(HPos::Right, to))
            }
        }
    }
}

/// The range that holds all values that are numbers, with a little room: for panels that must agree.
pub fn holding(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let finite: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    (!finite.is_empty()).then(|| Scale::holding(finite.into_iter(), ACROSS).range)
}

/// The radius of so many markers: few can be large.
fn radius(points: usize) -> i32 {
    if points < 80 { SPARSE } else { DENSE }
}

/// Type of an ink.
fn words(ink: Ink) -> TextStyle<'static> {
    let mut style = TextStyle::from(("sans-serif", TYPE * FINE).into_font());
    style.color = ink.color().to_backend_color();
    style
}

/// The name of an axis, with the power of ten that its labels leave out.
fn named(name: &str, scale: &Scale) -> String {
    match scale.exponent {
        0 => name.to_owned(),
        exponent => match name.rsplit_once(", ") {
            Some((quantity, unit)) => format!("{quantity}, 10{} {unit}", raised(exponent)),
            None => format!("{name}, 10{}", raised(exponent)),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel() -> Panel {
        let drift = (0..2400).map(|i| (f64::from(i), (f64::from(i) / 300.0).sin())).collect();
        Panel::new("A < B", "time, s", "rate, rad/s").with(Mark::Dots(Ink::X, drift)).with(Mark::Level(Ink::Aim, 0.0))
    }

    #[test]
    fn a_panel_is_an_image_with_a_title_and_a_description() {
        let svg = panel().svg("f1");
        assert!(svg.contains(r#"role="img" aria-labelledby="f1-t f1-d""#));
        assert!(svg.contains(r#"<title id="f1-t">A &lt; B</title>"#));
        assert!(svg.contains("Across: time, s, from "), "{svg}");
    }

    #[test]
    fn thousands_of_points_are_a_few_kilobytes() {
        assert!(panel().svg("f1").len() < 10_000, "{}", panel().svg("f1").len());
    }

    #[test]
    fn colours_are_left_to_the_style_sheet() {
        let svg = panel().svg("f1");
        assert!(!svg.contains('#') && svg.contains(r#"class="d x""#) && svg.contains(r#"class="l aim""#));
    }

    #[test]
    fn an_empty_panel_and_one_with_nothing_but_holes_are_drawn() {
        let svg = Panel::new("", "", "").with(Mark::Line(Ink::X, vec![(f64::NAN, 1.0)])).svg("f");
        assert!(svg.ends_with("</svg>\n"));
    }

    #[test]
    fn small_rates_name_their_power_of_ten() {
        let small =
            Panel::new("", "temperature, °C", "rate, rad/s").with(Mark::Dots(Ink::X, vec![(0.0, 1e-3), (1.0, 4e-3)]));
        assert!(small.svg("f").contains("rate, 10⁻³ rad/s"));
    }
}
