//! The polynomial nearest to a curve.

use zerorate_core::drift::{Polynomial, Scale, ValidRange};

use crate::least_squares::{Basis, Fit};

/// Points at which the curve is sampled: the nearest polynomial of so many equally spaced points is that of the curve, to 1e-4
/// of what is left.
const POINTS: usize = 1001;

/// The polynomial of an order that is nearest to a curve over a range by least squares, every temperature alike: of a next
/// run nobody knows how long it stays where, and the rows of this one are uneven.
pub fn nearest(curve: impl Fn(f64) -> f64, range: ValidRange, order: usize) -> Option<Polynomial> {
    let scale = Scale::spanning(range.min(), range.max())?;
    let mut fit = Fit::new(scale, Basis::Powers(order));
    for point in 0..POINTS {
        let temperature = range.min() + (range.max() - range.min()) * point as f64 / (POINTS - 1) as f64;
        fit.push(temperature, curve(temperature));
    }
    Polynomial::new(scale, &fit.finish().ok()?.coefficients)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of |x| over -1..1 the nearest quadratic is 3/16 + 15/16 x^2: by the Legendre polynomials, by hand.
    #[test]
    fn of_a_kink_it_is_the_one_that_is_known_by_hand() {
        let range = ValidRange::new(-20.0, 60.0).expect("a range");
        let kink = |temperature: f64| ((temperature - 20.0) / 40.0).abs();
        let found = nearest(kink, range, 2).expect("a quadratic");
        for (own, wanted) in found.coefficients().iter().zip([3.0 / 16.0, 0.0, 15.0 / 16.0]) {
            assert!((own - wanted).abs() < 2e-3, "{own} {wanted}");
        }
    }
}
