//! The figures of a lot.

use maud::html;

use super::figure::{Figure, Ink, Mark, Panel, Sample, Side, extent};
use crate::lot::{LotAxis, LotLimit, LotReport, LotUnit, Quantity};
use crate::number::{counted, exact};

/// Bars in a histogram.
const BARS: usize = 40;

/// Units in a running median, at most.
const WINDOW: usize = 51;

/// Units from which on a running median is drawn: with fewer it would follow each of them.
const LEAST_FOR_MEDIAN: usize = 20;

/// A limit is drawn as long as it is no more than this many times the span of the units away from them: a panel that shows
/// a limit far away shows nothing of the units.
const FURTHEST: f64 = 3.0;

/// What is drawn.
const DRAWN: [Quantity; 4] = [Quantity::Drift, Quantity::Reading, Quantity::HeldOut, Quantity::InSample];

/// The units that were fitted and not rejected.
pub(super) fn sound(report: &LotReport) -> impl Iterator<Item = &LotUnit> {
    report.units.iter().filter(|unit| unit.rejected.is_empty() && !unit.axes.is_empty())
}

/// The values of an axis over the units, with the unit.
fn values(report: &LotReport, quantity: Quantity, place: usize) -> Vec<(&LotUnit, f64)> {
    let value = |axis: &LotAxis| axis.values[quantity as usize];
    let of = |unit| -> Option<(&LotUnit, f64)> {
        let unit: &LotUnit = unit;
        unit.axes.get(place).map(value).filter(|value| value.is_finite()).map(|value| (unit, value))
    };
    sound(report).filter_map(of).collect()
}

/// One histogram a quantity, X and Y in each. What is far out of the rest, beyond ten quartiles, is drawn at the end.
/// None where no unit has a number.
pub(super) fn distribution(report: &LotReport, number: usize) -> Option<Figure> {
    let panel = |quantity: Quantity| {
        let numbers = |place| values(report, quantity, place).into_iter().map(|(_, value)| value).collect::<Vec<f64>>();
        let axes = [numbers(0), numbers(1)];
        let all = axes.concat();
        let limits = Limits::of(report, quantity, bounds(&all));
        let range = limits.range();
        // Bars as fine as without a limit; what lies beyond it is never counted on this side of it.
        let (low, high) = extent(all.iter().copied())?;
        let bars = if high > low { (low.max(range.0), high.min(range.1)) } else { range };
        let name = format!("{}, counts", quantity.words());
        let axes = [Ink::X, Ink::Y].into_iter().zip(&axes).filter(|(_, values)| !values.is_empty());
        let mut marks: Vec<Mark> = axes.map(|(ink, values)| Mark::Line(ink, outline(values, bars))).collect();
        marks.extend(limits.marks([Side::Left, Side::Right]));
        let panel = Panel::new(format!("Distribution: {}", quantity.words()), name, "units", marks);
        Some((Panel { x_range: Some(range), counts: true, ..panel }, limits.far))
    };
    let drawn = Drawn::of(panel)?;
    Some(Figure {
        id: "distribution-figure".into(),
        name: format!("Figure {number}"),
        caption: html! {
            "Units by what their fits give, " (counted(sound(report).count(), "unit")) " not rejected. What lies beyond an "
            "axis's ends is counted in its last step." (drawn.far)
        },
        key: drawn.key(report),
        columns: drawn.columns(),
    })
}

/// One panel a quantity over time, with a running median where there are units enough. None where no unit has a number,
/// or all have one time.
pub(super) fn over_time(report: &LotReport, number: usize) -> Option<Figure> {
    let days = || sound(report).map(|unit| unit.day).filter(|day| day.is_finite());
    let undated = sound(report).filter(|unit| !unit.day.is_finite()).count();
    let (_, last) = extent(days()).filter(|(first, last)| last > first)?;
    let (unit_name, days_in_unit) = time_unit(last);
    let window = window(days().count());
    let panel = |quantity: Quantity| {
        let axes = [0, 1].map(|place| {
            let points = values(report, quantity, place).into_iter();
            let points = points.map(|(unit, value)| (unit.day / days_in_unit, value));
            points.filter(|point| point.0.is_finite()).collect::<Vec<(f64, f64)>>()
        });
        let limits = Limits::of(report, quantity, extent(axes.iter().flatten().map(|point| point.1))?);
        let mut marks = Vec::new();
        for (ink, points) in [Ink::X, Ink::Y].into_iter().zip(axes).filter(|(_, points)| !points.is_empty()) {
            let median = window.map(|window| Mark::Line(ink, running_median(&points, window)));
            marks.push(Mark::Dots(ink, points));
            marks.extend(median);
        }
        marks.extend(limits.marks([Side::Bottom, Side::Top]));
        let (title, up) = (format!("Over time: {}", quantity.words()), format!("{}, counts", quantity.words()));
        Some((Panel::new(title, format!("{unit_name} since the first unit"), up, marks), limits.far))
    };
    let drawn = Drawn::of(panel)?;
    Some(Figure {
        id: "time-figure".into(),
        name: format!("Figure {number}"),
        caption: html! {
            "Each unit at the time of its recording"
            @match window {
                Some(window) => { "; the line is the median of " (window) " units about each." }
                None => { ". With fewer than " (LEAST_FOR_MEDIAN) " units no running median is drawn." }
            }
            @if undated > 0 { " " (counted(undated, "unit")) " without a time of a known zone (`recorded_at`) left out." }
            (drawn.far)
        },
        key: drawn.key(report),
        columns: drawn.columns(),
    })
}

/// The unit of time that suits a span of days: its name and the days in it.
fn time_unit(days: f64) -> (&'static str, f64) {
    match days * 24.0 {
        hours if hours < 2.0 => ("minutes", 1.0 / 1440.0),
        hours if hours < 48.0 => ("hours", 1.0 / 24.0),
        _ => ("days", 1.0),
    }
}

/// Units in a running median over so many: a quarter of them, an odd number, and none where there are too few.
fn window(units: usize) -> Option<usize> {
    (units >= LEAST_FOR_MEDIAN).then(|| WINDOW.min((units / 4) | 1))
}

/// The panels drawn, and what is said of limits that are not.
struct Drawn {
    panels: Vec<Panel>,
    far: String,
}

impl Drawn {
    /// The panel of each quantity that has one; none where no quantity has.
    fn of(panel: impl Fn(Quantity) -> Option<(Panel, Vec<String>)>) -> Option<Self> {
        let (panels, far): (Vec<Panel>, Vec<Vec<String>>) = DRAWN.into_iter().filter_map(panel).unzip();
        let far = far.concat().join("; ");
        let far = if far.is_empty() { far } else { format!(" Limits too far from all units to be drawn: {far}.") };
        (!panels.is_empty()).then_some(Self { panels, far })
    }

    fn key(&self, report: &LotReport) -> Vec<(Ink, Sample, String)> {
        let has = |wanted: fn(&Mark) -> bool| self.panels.iter().flat_map(|panel| &panel.marks).any(wanted);
        let name = |place: usize| sound(report).find_map(|unit| unit.axes.get(place)).map(|axis| axis.name.clone());
        let axes = [Ink::X, Ink::Y].into_iter().enumerate();
        let sample = if has(|mark| matches!(mark, Mark::Line(..))) { Sample::Line } else { Sample::Dot };
        let mut key: Vec<_> = axes.filter_map(|(place, ink)| name(place).map(|name| (ink, sample, name))).collect();
        if has(|mark| matches!(mark, Mark::Limit(..))) {
            key.push((Ink::Limit, Sample::Line, "limit".into()));
        }
        key
    }

    fn columns(self) -> Vec<Vec<Panel>> {
        self.panels.chunks(self.panels.len().div_ceil(2)).map(<[Panel]>::to_vec).collect()
    }
}

/// The limits of a quantity about the range of its values.
struct Limits {
    values: (f64, f64),
    least: Option<f64>,
    greatest: Option<f64>,
    /// Those too far away to be drawn.
    far: Vec<String>,
}

impl Limits {
    fn of(report: &LotReport, quantity: Quantity, values: (f64, f64)) -> Self {
        let limits = || report.limits.iter().filter(|limit| limit.quantity == quantity);
        // Equal values have no span: then what they are is the measure.
        let span = if values.1 > values.0 { values.1 - values.0 } else { values.1.abs().max(1.0) };
        let most = span * FURTHEST;
        let near = |at: &f64| values.0 - most <= *at && *at <= values.1 + most;
        let bounds = |of: fn(&LotLimit) -> f64| limits().map(of).find(|at| at.is_finite());
        let (least, greatest) = (bounds(|limit| limit.min), bounds(|limit| limit.max));
        let far = [("at least", least), ("at most", greatest)].into_iter();
        let far = far.filter_map(|(word, at)| at.filter(|at| !near(at)).map(|at| (word, at)));
        let far = far.map(|(word, at)| format!("{} {word} {}", quantity.words(), exact(at))).collect();
        Self { values, least: least.filter(near), greatest: greatest.filter(near), far }
    }

    /// The range that shows the values and the limits drawn.
    fn range(&self) -> (f64, f64) {
        let (low, high) = self.values;
        let drawn = || [self.least, self.greatest].into_iter().flatten();
        let (least, most) = (drawn().fold(low, f64::min), drawn().fold(high, f64::max));
        // A line at the very edge would look like the axis.
        let room = 0.03 * (most - least);
        (if least < low { least - room } else { low }, if most > high { most + room } else { high })
    }

    /// The limits as they are drawn, the least on the first side.
    fn marks(&self, [first, second]: [Side; 2]) -> impl Iterator<Item = Mark> {
        let limits = [(first, "at least", self.least), (second, "at most", self.greatest)];
        let drawn = limits.into_iter().filter_map(|(side, word, at)| Some((side, word, at?)));
        drawn.map(|(side, word, at)| Mark::Limit(side, at, format!("{word} {}", exact(at))))
    }
}

/// The range of a histogram: all values, but none further than ten quartile ranges from the quartiles.
fn bounds(values: &[f64]) -> (f64, f64) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (Some(min), Some(max)) = (sorted.first(), sorted.last()) else {
        return (0.0, 1.0);
    };
    let (low, high) = (sorted[sorted.len() / 4], sorted[sorted.len() * 3 / 4]);
    let room = 10.0 * (high - low);
    let (low, high) = (min.max(low - room), max.min(high + room));
    if high > low { (low, high) } else { (low - 0.5, low + 0.5) }
}

/// The outline of a histogram's bars.
// A bar's number is clamped.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn outline(values: &[f64], (low, high): (f64, f64)) -> Vec<(f64, f64)> {
    let mut counts = [0_u32; BARS];
    for value in values {
        let place = (value - low) / (high - low) * BARS as f64;
        counts[(place.max(0.0) as usize).min(BARS - 1)] += 1;
    }
    let edge = |bar: usize| low + (high - low) * bar as f64 / BARS as f64;
    let bars = counts.iter().enumerate();
    let tops = bars.flat_map(|(bar, count)| [(edge(bar), f64::from(*count)), (edge(bar + 1), f64::from(*count))]);
    std::iter::once((low, 0.0)).chain(tops).chain([(high, 0.0)]).collect()
}

/// The median of so many points about each point that has them.
fn running_median(points: &[(f64, f64)], window: usize) -> Vec<(f64, f64)> {
    let median = |about: &[(f64, f64)]| {
        let mut values: Vec<f64> = about.iter().map(|point| point.1).collect();
        values.sort_by(f64::total_cmp);
        (about[window / 2].0, values[window / 2])
    };
    points.windows(window).map(median).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_counts_every_value_once() {
        let values = [1.0, 2.0, 2.5, 9.0, 1000.0];
        let outline = outline(&values, (0.0, 10.0));
        let counted: f64 = outline[1..outline.len() - 1].iter().step_by(2).map(|point| point.1).sum();
        assert!((counted - 5.0).abs() < 1e-12);
    }

    #[test]
    fn a_running_median_passes_over_a_single_outlying_unit() {
        let mut points: Vec<(f64, f64)> = (0..200).map(|k| (f64::from(k), 5.0)).collect();
        points[100].1 = 1e6;
        let median = running_median(&points, 51);
        assert!(median.len() == 150 && median.iter().all(|point| (point.1 - 5.0).abs() < 1e-12));
    }

    #[test]
    fn a_running_median_is_of_as_many_units_as_it_says_and_of_none_in_a_small_lot() {
        assert_eq!([19, 20, 100, 204, 5000].map(window), [None, Some(5), Some(25), Some(51), Some(51)]);
    }
}
