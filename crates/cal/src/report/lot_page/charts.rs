//! The figures of a lot.

use maud::html;

use super::figure::{Figure, Ink, Mark, Panel, Sample};
use crate::report::lot::{LotAxis, LotReport, LotUnit, Quantity};

/// The figures drawn here; those of the worst units are counted on from it.
pub(super) const FIGURES: usize = 2;

/// Bars in a histogram.
const BARS: usize = 40;

/// Units in a running median, at most.
const WINDOW: usize = 51;

/// What is drawn.
const DRAWN: [Quantity; 4] = [Quantity::Drift, Quantity::Reading, Quantity::HeldOut, Quantity::InSample];

/// The units that were fitted and not rejected.
fn sound(report: &LotReport) -> impl Iterator<Item = &LotUnit> {
    report.units.iter().filter(|unit| unit.rejected.is_empty())
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
pub(super) fn distribution(report: &LotReport) -> Figure {
    let panel = |quantity: Quantity| {
        let numbers = |place| values(report, quantity, place).into_iter().map(|(_, value)| value).collect::<Vec<f64>>();
        let axes = [numbers(0), numbers(1)];
        let range = bounds(&axes.concat());
        let name = format!("{}, counts", quantity.words());
        let mut panel =
            Panel::new(format!("Distribution: {}", quantity.words()), name, "units").with_x_range(Some(range));
        for (ink, values) in [Ink::X, Ink::Y].into_iter().zip(&axes) {
            panel = panel.with(Mark::Line(ink, outline(values, range)));
        }
        panel
    };
    Figure {
        id: "distribution-figure".into(),
        name: "Figure 1".into(),
        caption: html! {
            "Units by what their fits give, " (sound(report).count()) " units that were not rejected. What lies beyond an axis's "
            "ends is counted in its last step."
        },
        key: key(),
        columns: columns(panel),
    }
}

/// One panel a quantity over time, with a running median.
pub(super) fn over_time(report: &LotReport) -> Figure {
    let panel = |quantity: Quantity| {
        let name = format!("{}, counts", quantity.words());
        let mut panel = Panel::new(format!("Over time: {}", quantity.words()), "days since the first unit", name);
        for (place, ink) in [Ink::X, Ink::Y].into_iter().enumerate() {
            let points = values(report, quantity, place).into_iter().map(|(unit, value)| (unit.day, value));
            let points: Vec<(f64, f64)> = points.filter(|point| point.0.is_finite()).collect();
            panel = panel.with(Mark::Dots(ink, points.clone())).with(Mark::Line(ink, running_median(&points)));
        }
        panel
    };
    Figure {
        id: "time-figure".into(),
        name: "Figure 2".into(),
        caption: html! { "Each unit at the time of its recording; the line is the median of " (WINDOW) " units about it." },
        key: key(),
        columns: columns(panel),
    }
}

fn key() -> Vec<(Ink, Sample, String)> {
    vec![(Ink::X, Sample::Line, "X".into()), (Ink::Y, Sample::Line, "Y".into())]
}

fn columns(panel: impl Fn(Quantity) -> Panel) -> Vec<Vec<Panel>> {
    DRAWN.chunks(DRAWN.len() / 2).map(|half| half.iter().map(|quantity| panel(*quantity)).collect()).collect()
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

/// The median of the points about each point.
fn running_median(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let median = |place: usize| {
        let (from, to) = (place.saturating_sub(WINDOW / 2), (place + WINDOW / 2 + 1).min(points.len()));
        let mut about: Vec<f64> = points[from..to].iter().map(|point| point.1).collect();
        about.sort_by(f64::total_cmp);
        (points[place].0, about[about.len() / 2])
    };
    (0..points.len()).map(median).collect()
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
    fn a_running_median_passes_over_a_single_wild_unit() {
        let mut points: Vec<(f64, f64)> = (0..200).map(|k| (f64::from(k), 5.0)).collect();
        points[100].1 = 1e6;
        assert!(running_median(&points).iter().all(|point| (point.1 - 5.0).abs() < 1e-12));
    }
}
