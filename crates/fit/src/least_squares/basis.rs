//! The functions of temperature that a fit combines.

/// The functions of the scaled temperature x, -1 to 1, of which a drift is a linear combination.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// 1, x, x^2, ... up to this order.
    Powers(usize),
    /// Piecewise linear over this many equal intervals: each function is 1 at its node, 0 at the other nodes, and straight
    /// between. A combination of them is the table whose node values are the coefficients.
    PiecewiseLinear(usize),
}

impl Basis {
    /// The number of functions, and so of coefficients.
    #[must_use]
    pub fn size(self) -> usize {
        match self {
            Self::Powers(size) | Self::PiecewiseLinear(size) => size + 1,
        }
    }

    /// Writes the basis at each x into `columns`, column-major, a column every `stride` numbers.
    pub(super) fn write(self, x: &[f64], columns: &mut [f64], stride: usize) {
        match self {
            Self::Powers(order) => {
                columns[..x.len()].fill(1.0);
                for power in 1..=order {
                    let (lower, column) = columns.split_at_mut(power * stride);
                    let lower = &lower[(power - 1) * stride..];
                    for ((value, lower), x) in column.iter_mut().zip(lower).zip(x) {
                        *value = lower * x;
                    }
                }
            }
            Self::PiecewiseLinear(intervals) => {
                for node in 0..=intervals {
                    columns[node * stride..node * stride + x.len()].fill(0.0);
                }
                for (row, &x) in x.iter().enumerate() {
                    let (interval, part) = interval_of(x, intervals);
                    columns[interval * stride + row] = 1.0 - part;
                    columns[(interval + 1) * stride + row] = part;
                }
            }
        }
    }
}

/// The interval that x lies in, or the end interval nearest to it, and how far along it x is: 0 to 1 inside it.
// The clamp makes the cast exact.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn interval_of(x: f64, intervals: usize) -> (usize, f64) {
    let place = (x + 1.0) / 2.0 * intervals as f64;
    let interval = place.floor().clamp(0.0, (intervals - 1) as f64);
    (interval as usize, place - interval)
}
