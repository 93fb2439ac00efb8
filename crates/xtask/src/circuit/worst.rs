//! The circuit with its parts off their values: one at a time, all in the worst direction, and at random.

use anyhow::{Context, Result};

use super::parts::{self, Spread, Unit};
use super::spice::{Measured, Spice, Values};

/// Boards drawn at random, each part anywhere within its tolerance with equal likelihood: no maker's distribution is
/// known, and this one is harsher than a bell.
pub const SAMPLES: usize = 1000;

/// The seed of the draws: the same boards in every run.
const SEED: u64 = 5494;

/// How far one measured quantity goes.
pub struct Range {
    /// bench.cir's vector.
    pub name: String,
    /// Lowest and highest with every part at the end of its tolerance that takes it there.
    pub worst: [f64; 2],
    /// Lowest and highest of the random boards.
    pub random: [f64; 2],
    /// The random boards' standard deviation.
    pub deviation: f64,
    /// Whose tolerance moves it most.
    pub largest: String,
}

/// The ranges of the named quantities, where each unit is off by at most what `spread` gives.
pub fn ranges(
    spice: &Spice,
    units: &[Unit],
    names: &[&str],
    spread: impl Fn(&Unit) -> Spread + Copy,
) -> Result<Vec<Range>> {
    let nominal = parts::nominal(units);
    let measure = |fractions: &[Vec<f64>]| -> Result<Vec<Measured>> {
        let runs: Vec<Values> = fractions.iter().map(|fractions| parts::off(units, fractions, spread)).collect();
        spice.measure(&nominal, &runs)
    };
    let alone = |index: usize, fraction: f64| {
        let mut fractions = vec![0.0; units.len()];
        fractions[index] = fraction;
        fractions
    };
    let up = measure(&(0..units.len()).map(|index| alone(index, 1.0)).collect::<Vec<_>>())?;
    let down = measure(&(0..units.len()).map(|index| alone(index, -1.0)).collect::<Vec<_>>())?;

    // The circuit is all but linear in each part: the end that takes a quantity up alone takes it up among others.
    let corner = |name: &str, sign: f64| -> Vec<f64> {
        let effects = up.iter().zip(&down).map(|(up, down)| value(up, name) - value(down, name));
        effects.map(|effect| if effect == 0.0 { 0.0 } else { sign * effect.signum() }).collect()
    };
    let corners: Vec<Vec<f64>> = names.iter().flat_map(|name| [corner(name, -1.0), corner(name, 1.0)]).collect();
    let corners = measure(&corners)?;
    let mut random = Random(SEED);
    let boards = measure(&(0..SAMPLES).map(|_| units.iter().map(|_| random.fraction()).collect()).collect::<Vec<_>>())?;

    let range = |(name, corners): (&&str, &[Measured])| {
        let effect = |index: &usize| (value(&up[*index], name) - value(&down[*index], name)).abs();
        let largest = (0..units.len()).max_by(|a, b| effect(a).total_cmp(&effect(b))).context("no parts")?;
        let values = boards.iter().map(|board| value(board, name));
        #[allow(clippy::cast_precision_loss)] // A thousand.
        let count = boards.len() as f64;
        let mean = values.clone().sum::<f64>() / count;
        let variance = values.clone().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
        Ok(Range {
            name: (*name).to_owned(),
            worst: [value(&corners[0], name), value(&corners[1], name)],
            random: [values.clone().fold(f64::NAN, f64::min), values.fold(f64::NAN, f64::max)],
            deviation: variance.sqrt(),
            largest: units[largest].reference.clone(),
        })
    };
    names.iter().zip(corners.chunks(2)).map(range).collect()
}

/// What was measured; what was not is no number and spoils every comparison that it enters.
fn value(measured: &Measured, name: &str) -> f64 {
    measured.get(name).copied().unwrap_or(f64::NAN)
}

/// SplitMix64 (Steele, Lea, Flood 2014): too little is drawn here for a dependency.
struct Random(u64);

impl Random {
    /// From -1 to 1, evenly.
    #[allow(clippy::cast_precision_loss)] // 53 bits are kept.
    fn fraction(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ mixed >> 31) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_even_and_repeat() {
        let mut random = Random(SEED);
        let draws: Vec<f64> = (0..10_000).map(|_| random.fraction()).collect();
        let mut again = Random(SEED);
        assert!(draws.iter().all(|draw| draw.to_bits() == again.fraction().to_bits()));
        assert!(draws.iter().all(|draw| (-1.0..1.0).contains(draw)));
        assert!(draws.iter().sum::<f64>().abs() / 10_000.0 < 0.02);
        let square = draws.iter().map(|draw| draw * draw).sum::<f64>() / 10_000.0;
        assert!((square - 1.0 / 3.0).abs() < 0.01);
    }
}
