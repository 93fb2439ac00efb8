//! What the groups of tests tell of noise, repeatability and the direction of temperature.

use zerorate_core::drift::ValidRange;

use super::left::{Left, Run};
use crate::summary::SoakPoint;

/// Fewer groups tell nothing of their part of the range.
const FEWEST: usize = 8;

/// The noise of one group's mean, counts: of three successive groups at one tap the first and the third less twice the second.
/// A drift that goes straight over three groups leaves nothing of itself there; independent noise of variance s^2 leaves 6 s^2.
pub(super) fn noise<'a>(ramps: impl Iterator<Item = &'a [Left]>) -> Option<f64> {
    let (mut squares, mut n) = (0.0, 0.0);
    for ramp in ramps {
        for three in ramp.windows(3) {
            let [a, b, c] = [three[0], three[1], three[2]];
            if a.tap == b.tap && b.tap == c.tap && c.group - a.group == 2 {
                let second = a.counts - 2.0 * b.counts + c.counts;
                squares += second * second;
                n += 1.0;
            }
        }
    }
    (n > 0.0).then(|| (squares / (6.0 * n)).sqrt())
}

/// Of soaks less the ramp's curve the rms, of which the repeatability has its part already; `None` where none is compared.
pub(super) fn soaks(points: &[SoakPoint], repeatability: f64) -> Option<f64> {
    let on_the_ramp = points.iter().filter(|soak| !soak.outside_ramp);
    let squares = mean(on_the_ramp.map(|soak| (soak.zro_counts - soak.ramp_counts).powi(2)))?;
    Some((squares - repeatability * repeatability).max(0.0).sqrt())
}

/// Equal parts of the measured range, so that each temperature counts as much as another: a chamber stays long at an end.
pub(super) struct Bins {
    range: ValidRange,
    noise: f64,
}

/// The mean of a part of the range, where there is one, with the variance that noise gives it.
type Means = [Option<(f64, f64)>; Bins::COUNT];

/// The repeatability.
pub(super) struct Repeated {
    /// Its standard uncertainty, counts.
    pub counts: f64,
    /// Of how many ramps.
    pub ramps: usize,
}

/// What the direction of temperature makes.
pub(super) struct Direction {
    /// Its standard uncertainty, counts.
    pub counts: f64,
    /// Of how many tests.
    pub ramps: usize,
}

impl Bins {
    /// How many parts.
    pub(super) const COUNT: usize = 20;

    /// Over a range; `noise` is that of a group, counts.
    pub(super) fn over(range: ValidRange, noise: f64) -> Self {
        Self { range, noise }
    }

    /// The rms, about zero, of the means of heating ramps, less what noise makes of them.
    pub(super) fn repeatability<'a>(&self, heating: impl Iterator<Item = &'a [Left]>) -> Option<Repeated> {
        let means: Vec<Means> = heating.map(|ramp| self.means(ramp)).collect();
        let squares = mean(means.iter().flatten().flatten().map(|(mean, variance)| mean * mean - variance))?;
        Some(Repeated { counts: squares.max(0.0).sqrt(), ramps: means.len() })
    }

    /// Cooling less heating of the same test. Half of all passes cool, so half of its mean square counts.
    pub(super) fn direction(&self, runs: &[Run]) -> Option<Direction> {
        let both: Vec<[Means; 2]> = runs
            .iter()
            .filter(|run| !run.cooling.is_empty())
            .map(|run| [self.means(&run.heating), self.means(&run.cooling)])
            .collect();
        let pairs = both.iter().flat_map(|[heating, cooling]| heating.iter().zip(cooling));
        let squares = pairs.filter_map(|(heating, cooling)| {
            let ((heating, of_heating), (cooling, of_cooling)) = (*heating).zip(*cooling)?;
            Some((cooling - heating).powi(2) - of_heating - of_cooling)
        });
        let squares = mean(squares)?;
        Some(Direction { counts: (0.5 * squares.max(0.0)).sqrt(), ramps: both.len() })
    }

    fn means(&self, ramp: &[Left]) -> Means {
        let width = (self.range.max() - self.range.min()) / Self::COUNT as f64;
        std::array::from_fn(|place| {
            let from = self.range.min() + width * place as f64;
            let within = ramp.iter().filter(|left| (from..from + width).contains(&left.temperature));
            let counts: Vec<f64> = within.map(|left| left.counts).collect();
            #[allow(clippy::cast_precision_loss)] // some thousands
            let n = counts.len() as f64;
            (counts.len() >= FEWEST).then(|| (counts.iter().sum::<f64>() / n, self.noise * self.noise / n))
        })
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values.fold((0.0, 0.0), |(sum, n), value| (sum + value, n + 1.0));
    (n > 0.0).then(|| sum / n)
}
