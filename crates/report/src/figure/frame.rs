//! The rectangle of a panel with its axes, and where things are in it. A drawing unit is a tenth of a pixel on a desktop,
//! so that places can be whole numbers.

use maud::{Markup, html};

use super::ink::Ink;
use super::mark::{Mark, Side};
use super::path::{DENSE, Path, Place, SPARSE, markers};
use super::scale::Scale;
use super::second::Second;
use super::thin::{MOST, Point, runs, sample, thin};
use crate::number::raised;

/// Width of a panel: two of them side by side fill a desktop page, one fills a phone at two thirds of its size.
const WIDTH: i32 = 5600;

/// Height of the type, which the style sheet sets to the same: on a phone it is 9 pixels.
const TYPE: i32 = 140;

/// The y axis, with room for its labels: eight digits of a wide font.
const LEFT: i32 = 700;

/// The end of the x axis, with room for half a label.
const RIGHT: i32 = WIDTH - 240;

/// Room for the name of the y axis, above the drawing where it needs no turning of the head.
const TOP: i32 = 300;

/// Room for the labels of a second scale, along the top.
const SECOND: i32 = 190;

/// Room for the labels of the x axis and its name.
const BELOW: i32 = 480;

/// The length of a tick.
const TICK: i32 = 50;

/// The least width of a band, as a part of the x axis: one of a single group must still be seen.
const NARROWEST: f64 = 0.006;

/// The part of the x axis that a limit's label takes, about.
const ROOM: f64 = 0.35;

/// The part of the y axis that it takes, on a phone.
const LOW: f64 = 0.1;

/// From a text's middle, or its top, down to the line that it stands on: digits are 0.72 em high in most fonts.
const MIDDLE: Option<&str> = Some(".36em");
const HANGING: Option<&str> = Some(".72em");

/// The axes of a panel.
pub(super) struct Frame {
    x: Scale,
    y: Scale,
    /// The ticks along the top and their labels; none without a second scale.
    second: Vec<(f64, String)>,
    height: i32,
    /// Where the y axis ends.
    top: i32,
    /// Where the x axis is.
    bottom: i32,
}

impl Frame {
    /// A second scale adds its room to the height.
    pub(super) fn new(x: Scale, y: Scale, second: Option<&Second>, height: i32) -> Self {
        let room = if second.is_some() { SECOND } else { 0 };
        let (height, second) = (height + room, second.map(|second| second.ticks(x.range)).unwrap_or_default());
        Self { x, y, second, height, top: TOP + room, bottom: height - BELOW }
    }

    pub(super) fn view_box(&self) -> String {
        format!("0 0 {WIDTH} {}", self.height)
    }

    /// Where a point is in the drawing.
    fn at(&self, (x, y): Point) -> Place {
        (place(self.x.share(x), LEFT, RIGHT), place(self.y.share(y), self.bottom, self.top))
    }

    /// Where a value of the x axis is.
    fn across(&self, x: f64) -> i32 {
        self.at((x, self.y.range.0)).0
    }

    /// Where a value of the y axis is.
    fn up(&self, y: f64) -> i32 {
        self.at((self.x.range.0, y)).1
    }

    /// A shaded interval of the x axis.
    pub(super) fn band(&self, ink: Ink, from: f64, to: f64) -> Markup {
        let (first, last) = self.x.range;
        let room = (NARROWEST * (last - first) - (to - from)).max(0.0) / 2.0;
        let (left, right) = (self.across((from - room).max(first)), self.across((to + room).min(last)));
        let corners = [(left, self.top), (right, self.top), (right, self.bottom), (left, self.bottom)];
        Path::default().line(corners).markup("a", ink.class())
    }

    /// The grid, the axes with their ticks and labels, and their names.
    pub(super) fn axes(&self, x_name: &str, y_name: &str) -> Markup {
        let bottom = self.bottom;
        let xs = || self.x.ticks.iter().map(|(at, label)| (self.across(*at), label));
        let ys = || self.y.ticks.iter().map(|(at, label)| (self.up(*at), label));
        let grid = ys().fold(Path::default(), |path, (y, _)| path.line([(LEFT, y), (RIGHT, y)]));
        let frame = Path::default().line([(LEFT, self.top), (LEFT, bottom), (RIGHT, bottom)]);
        let frame = ys().fold(frame, |path, (y, _)| path.line([(LEFT - TICK, y), (LEFT, y)]));
        let frame = xs().fold(frame, |path, (x, _)| path.line([(x, bottom), (x, bottom + TICK)]));
        let top = self.top;
        let along_the_top = || self.second.iter().map(|(at, label)| (self.across(*at), label));
        let frame = along_the_top().fold(frame, |path, (x, _)| path.line([(x, top), (x, top - TICK)]));
        let frame = if self.second.is_empty() { frame } else { frame.line([(LEFT, top), (RIGHT, top)]) };
        html! {
            (grid.markup("l", "grid"))
            (frame.markup("l", "frame"))
            @for (y, label) in ys() { (text("word", (LEFT - 2 * TICK, y), "end", MIDDLE, label)) }
            @for (x, label) in xs() { (text("word", (x, bottom + 2 * TICK), "middle", HANGING, label)) }
            @for (x, label) in along_the_top() { (text("word", (x, top - 2 * TICK), "middle", None, label)) }
            (text("word", (RIGHT, self.height - TICK), "end", None, &named(x_name, &self.x)))
            (text("word", (0, 20), "start", HANGING, &named(y_name, &self.y)))
        }
    }

    /// A mark. Bands are drawn beneath all others and limits above them: [`Self::band`], [`Self::limit`].
    pub(super) fn mark(&self, mark: &Mark) -> Markup {
        let at = |point: Point| self.at(point);
        match mark {
            Mark::Band(..) | Mark::Limit(..) => html! {},
            Mark::Line(ink, points) => {
                // Each run has its share of the points drawn.
                let share = |run: &[Point]| (MOST * run.len() / points.len()).max(2);
                let line = |path: Path, run| path.line(thin(run, share(run)).into_iter().map(at));
                runs(points).fold(Path::default(), line).markup("l", ink.class())
            }
            Mark::Dots(ink, points) => {
                let points = sample(&runs(points).collect::<Vec<_>>().concat(), MOST);
                let radius = if points.len() < 80 { SPARSE } else { DENSE };
                markers(points.into_iter().map(at), *ink, radius)
            }
            Mark::Stems(ink, points) => {
                let stem = |path: Path, point: &Point| path.line([self.at((point.0, 0.0)), self.at(*point)]);
                html! {
                    (points.iter().fold(Path::default(), stem).markup("s", ink.class()))
                    (markers(points.iter().copied().map(at), *ink, SPARSE))
                }
            }
            Mark::Level(ink, height) => {
                let height = self.up(*height);
                Path::default().line([(LEFT, height), (RIGHT, height)]).markup("l", ink.class())
            }
        }
    }

    /// The line of a limit and its label: outside the limit where there is room. The least's is a row below the
    /// greatest's, so that the two never touch.
    pub(super) fn limit(&self, side: Side, value: f64, label: &str) -> Markup {
        const GAP: i32 = 40;
        let upright = matches!(side, Side::Left | Side::Right);
        let share = if upright { self.x.share(value) } else { self.y.share(value) };
        let (x, y) = (self.across(value), self.up(value));
        let (line, at, anchor, drop) = if upright {
            let row = self.top + GAP + if side == Side::Left { TYPE * 3 / 2 } else { 0 };
            let before = if side == Side::Left { share > ROOM } else { share > 1.0 - ROOM };
            let (at, anchor) = if before { (x - GAP, "end") } else { (x + GAP, "start") };
            ([(x, self.bottom), (x, self.top)], (at, row), anchor, HANGING)
        } else {
            let above = if side == Side::Top { share < 1.0 - LOW } else { share < LOW };
            let (at, drop) = if above { (y - GAP, None) } else { (y + GAP, HANGING) };
            ([(LEFT, y), (RIGHT, y)], (RIGHT, at), "end", drop)
        };
        html! { (Path::default().line(line).markup("l", "limit")) (text("limit", at, anchor, drop, label)) }
    }
}

/// A share of the way from one end of an axis to the other. What lies far outside is held at a distance.
// Within the drawing, which is a few thousand units wide.
#[allow(clippy::cast_possible_truncation)]
fn place(share: f64, start: i32, end: i32) -> i32 {
    start + (f64::from(end - start) * share.clamp(-2.0, 3.0)).round() as i32
}

fn text(class: &str, (x, y): Place, anchor: &str, drop: Option<&str>, text: &str) -> Markup {
    html! { text class=(class) x=(x) y=(y) text-anchor=(anchor) dy=[drop] { (text) } }
}

/// The name of an axis, with the power of ten that its labels leave out.
fn named(name: &str, scale: &Scale) -> String {
    match (scale.exponent, name.rsplit_once(", ")) {
        (0, _) => name.to_owned(),
        (exponent, Some((quantity, unit))) => format!("{quantity}, 10{} {unit}", raised(exponent)),
        (exponent, None) => format!("{name}, 10{}", raised(exponent)),
    }
}
