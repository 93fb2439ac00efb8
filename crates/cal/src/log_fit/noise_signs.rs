//! What a log's noise is known by: a copy of it that was rounded, saved in other units or with other times has other rows,
//! and the same noise.
//!
//! Of each four successive averages the third difference, `a - 3 b + 3 c - d`, is noise alone: what a drift does in four
//! averages is a parabola at most. No average is in two of them, so that their signs are as many throws of a coin; two runs
//! agree in half of them, a copy in nearly all.

use crate::condition::Group;

/// Averages of which a sign is made.
const OF: usize = 4;

/// Signs that are kept of a sensor's log.
const MOST: usize = 192;

/// The fewest signs that both logs have. 31 of 32 coins fall alike in one of 10^8 pairs of logs.
const LEAST: usize = 32;

/// The share of signs that agree in a copy, at least: where a difference is as small as the rounding, they may not.
const ALIKE: f64 = 0.95;

/// The signs of one sensor's noise from the log's beginning: `+`, `-`, and `0` where there is none.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct NoiseSigns(String);

impl NoiseSigns {
    /// Of a log's groups, all axes of the first four, then of the next.
    pub(super) fn of(groups: &[Group]) -> Self {
        let sign = |four: &[Group], axis: usize| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|place: usize| four[place].axes[axis].rate);
            match a - 3.0 * b + 3.0 * c - d {
                difference if difference > 0.0 => '+',
                difference if difference < 0.0 => '-',
                _ => '0',
            }
        };
        let signs = groups.chunks_exact(OF).flat_map(|four| (0..four[0].axes.len()).map(move |axis| sign(four, axis)));
        Self(signs.take(MOST).collect())
    }

    /// As a calibration keeps them; `None` where there are too few to tell anything.
    pub(super) fn written(&self) -> Option<String> {
        (self.0.len() >= LEAST).then(|| self.0.clone())
    }

    /// Whether two logs have one noise.
    pub(super) fn is_of(&self, other: &str) -> bool {
        let both = self.0.bytes().zip(other.bytes()).filter(|(own, other)| *own != b'0' && *other != b'0');
        let (signs, alike) =
            both.fold((0, 0), |(signs, alike), (own, other)| (signs + 1, alike + usize::from(own == other)));
        signs >= LEAST && alike as f64 >= ALIKE * signs as f64
    }

    /// The same of another log's signs.
    pub(super) fn are_of(&self, other: &Self) -> bool {
        self.is_of(&other.0)
    }
}
