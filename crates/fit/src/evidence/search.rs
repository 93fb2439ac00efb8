//! The likeliest spreads and noise of some rows.

use super::averages::Averages;
use super::columns::Columns;
use super::marginal::{Evaluated, Marginal, SECONDS, Spreads};
use super::noise::{Wander, Whitened};

/// The first steps of the search, in natural logarithms: from the priors, and from what was found of nearly the same rows.
const FAR: f64 = 1.6;
const NEAR: f64 = 0.4;

/// The last one.
const LAST: f64 = 0.2;

/// A gain of the likelihood's logarithm that is not worth a step.
const ENOUGH: f64 = 0.02;

/// Between these a wander's logarithm of its ratio is looked for.
const RATIOS: (f64, f64) = (-5.0, 4.0);

/// The shortest time in which a wander forgets, seconds: what forgets sooner is white to groups of 10 s; it is at least
/// this that the longest one is.
const SHORTEST_S: f64 = 60.0;

/// What was found of the spreads and of the noise.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(super) spreads: Spreads,
    pub(super) wander: Wander,
}

impl Found {
    /// The likeliest of all.
    pub(super) fn search(columns: &Columns, averages: &Averages) -> Option<(Self, Evaluated)> {
        let wander = Wander { log_ratio: 0.0, log_seconds: SECONDS.mean };
        Self { spreads: Spreads::prior(&columns.kinds), wander }.from(columns, averages, FAR)
    }

    /// The likeliest about what was found of nearly the same rows.
    pub(super) fn search_nearby(&self, columns: &Columns, averages: &Averages) -> Option<(Self, Evaluated)> {
        self.clone().from(columns, averages, NEAR)
    }

    /// Looks along the wander's two numbers for likelier ones, steps halved where there are none (compass search: Kolda,
    /// Lewis and Torczon, *Optimization by direct search*, 2003); the spreads follow by their gradient.
    fn from(mut self, columns: &Columns, averages: &Averages, first: f64) -> Option<(Self, Evaluated)> {
        let longest = (averages.time_s.last()? - averages.time_s[0]).max(2.0 * SHORTEST_S);
        let held = |wander: Wander| Wander {
            log_ratio: wander.log_ratio.clamp(RATIOS.0, RATIOS.1),
            log_seconds: wander.log_seconds.clamp(libm::log(SHORTEST_S), libm::log(longest)),
        };
        let at = |wander: Wander, spreads: &Spreads| {
            let marginal = Marginal::new(&columns.kinds, &Whitened::new(averages, wander), wander);
            marginal.ascend(spreads.clone())
        };
        self.wander = held(self.wander);
        let (spreads, mut best) = at(self.wander, &self.spreads)?;
        self.spreads = spreads;
        let mut step = first;
        while step >= LAST {
            let better =
                [(step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step)].into_iter().find_map(|(ratio, time)| {
                    let Wander { log_ratio, log_seconds } = self.wander;
                    let wander = held(Wander { log_ratio: log_ratio + ratio, log_seconds: log_seconds + time });
                    let (spreads, tried) = at(wander, &self.spreads)?;
                    (tried.cost < best.cost - ENOUGH).then_some((Self { spreads, wander }, tried))
                });
            match better {
                Some(found) => (self, best) = found,
                None => step *= 0.5,
            }
        }
        Some((self, best))
    }
}
