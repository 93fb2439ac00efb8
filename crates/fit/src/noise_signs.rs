//! What a log's noise is known by: a copy of it that was rounded, saved in other units or with other times has other numbers,
//! and the same noise.
//!
//! Of four successive rows the third difference, `a - 3 b + 3 c - d`, is noise alone: what a drift does in four rows is a
//! parabola at most. Four rows of each 32 are looked at, so that the signs are as many throws of a coin, and not of one
//! moment; two runs agree in half of them, a copy in nearly all.

/// Rows of which a sign is made.
const OF: usize = 4;

/// From the first of four rows to that of the next four.
const EVERY: u64 = 32;

/// Signs that are kept of a sensor's log.
const MOST: usize = 192;

/// The fewest signs that both logs have: 32 moments of three axes, whose noise may be one. 31 of 32 coins fall alike in one of
/// 10^8 pairs of logs.
const LEAST: usize = 96;

/// The share of signs that agree in a copy, at least: where a difference is as small as the rounding, they may not.
const ALIKE: f64 = 0.95;

/// The signs of one sensor's noise from the log's beginning: `+`, `-`, and `0` where there is none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NoiseSigns {
    signs: String,
    rows: u64,
    /// The rows of the four that are being taken in, one after the other.
    four: Vec<f64>,
}

impl NoiseSigns {
    /// Takes in successive rows: a column of values an axis, all as long.
    pub fn push_rows<A: AsRef<[f64]>>(&mut self, values: &[A]) {
        let axes = values.len();
        for row in 0..values.first().map_or(0, |axis| axis.as_ref().len()) {
            let place = self.rows % EVERY;
            self.rows += 1;
            if place >= OF as u64 || self.signs.len() >= MOST {
                continue;
            }
            self.four.extend(values.iter().map(|axis| axis.as_ref()[row]));
            if self.four.len() == OF * axes {
                let four = std::mem::take(&mut self.four);
                self.signs.extend((0..axes).map(|axis| sign([0, 1, 2, 3].map(|row| four[row * axes + axis]))));
            }
        }
    }

    /// As a calibration keeps them; `None` where there are too few to tell anything.
    #[must_use]
    pub fn written(&self) -> Option<String> {
        (self.signs.len() >= LEAST).then(|| self.signs.clone())
    }

    /// Whether this is the noise of a log whose signs were written. An axis that is silent in one of the two is another's.
    #[must_use]
    pub fn is_of(&self, other: &str) -> bool {
        let both = self.signs.bytes().zip(other.bytes()).filter(|(own, other)| *own != b'0' || *other != b'0');
        let count = |(signs, alike), (own, other)| (signs + 1, alike + usize::from(own == other));
        let (signs, alike) = both.fold((0, 0), count);
        signs >= LEAST && alike as f64 >= ALIKE * signs as f64
    }

    /// Whether two logs have one noise.
    #[must_use]
    pub fn are_of(&self, other: &Self) -> bool {
        self.is_of(&other.signs)
    }
}

fn sign([a, b, c, d]: [f64; OF]) -> char {
    match a - 3.0 * b + 3.0 * c - d {
        difference if difference > 0.0 => '+',
        difference if difference < 0.0 => '-',
        _ => '0',
    }
}
