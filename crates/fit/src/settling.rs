//! The first readings after a start, which settle towards the others.

use crate::robust::{extrapolated, noise};

/// Groups at the beginning of a log that may settle: the first minute or so.
pub const MOST: usize = 8;

/// Groups behind them that show where the rate settles to.
const REFERENCE: usize = 12;

/// From group to group what settles comes closer by this factor at least, as with a time constant of 40 s; what is slower is
/// a drift.
const DECAY: f64 = 1.3;

/// A group further than this many standard deviations from where the others lead settles.
const SETTLING_SIGMA: f64 = 10.0;

/// By so many standard deviations more than that factor, from the first group to the one that has settled: the curve itself bends
/// away from a line, and with some noise the bend of one group comes closer fast enough.
const SURE: f64 = 3.0;

/// How many of the first groups settle, by more than `margin`: temperature and rate of each, `None` of one that cannot be used.
#[must_use]
pub fn settling(groups: &[Option<(f64, f64)>], margin: f64) -> usize {
    if groups.len() < 2 * (MOST + REFERENCE) {
        return 0;
    }
    let settled: Vec<(f64, f64)> = groups[MOST..MOST + REFERENCE].iter().copied().flatten().collect();
    let first: Vec<(f64, f64)> = groups[..MOST].iter().copied().flatten().collect();
    if settled.len() < REFERENCE / 2 || first.len() < MOST {
        return 0;
    }
    let sigma = noise(&groups[MOST..].iter().flatten().map(|point| point.1).collect::<Vec<_>>());
    let off = |place: usize| {
        let (temperature, rate) = groups[place].unwrap_or((f64::NAN, f64::NAN));
        let (predicted, spread) = extrapolated(&settled, temperature);
        ((rate - predicted).abs(), (SETTLING_SIGMA * sigma.max(spread)).max(margin))
    };
    let settling = (0..MOST).take_while(|place| off(*place).0 > off(*place).1).count();
    let fast = (0..settling).all(|place| off(place).0 > DECAY * off(place + 1).0);
    let decay = (0..settling).fold(1.0, |decay, _| DECAY * decay);
    let surely = off(0).0 - decay * off(settling).0 > SURE * sigma * libm::hypot(decay, 1.0);
    if settling > 0 && fast && surely { settling } else { 0 }
}
