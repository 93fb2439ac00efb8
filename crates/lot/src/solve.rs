//! From sums to a curve: the solve for each unit, on the client.
//!
//! The sums are of a centred, scaled variable, -1 to 1 over the unit's own sweep, and of readings less a level. So the
//! normal equations of order 5 have a condition number of some 1e4, and lose four of sixteen digits.

/// Sums over some groups of an axis: of powers of x, of v times them, and of v squared; v is the reading less its level.
#[derive(Debug, Clone, PartialEq)]
pub struct Sums {
    /// Groups.
    pub groups: u64,
    /// Of x to the power of the place, 0 to twice the order.
    pub powers: Vec<f64>,
    /// Of v x to the power of the place, 0 to the order.
    pub products: Vec<f64>,
    /// Of v squared.
    pub squares: f64,
}

impl Sums {
    /// Without groups.
    #[must_use]
    pub fn empty(order: usize) -> Self {
        Self { groups: 0, powers: vec![0.0; 2 * order + 1], products: vec![0.0; order + 1], squares: 0.0 }
    }

    /// The sums that a lower order needs.
    #[must_use]
    pub fn truncated(&self, order: usize) -> Self {
        Self { powers: self.powers[..=2 * order].to_vec(), products: self.products[..=order].to_vec(), ..self.clone() }
    }

    /// Takes in the sums over other groups.
    pub fn add(&mut self, other: &Self) {
        self.groups += other.groups;
        self.powers.iter_mut().zip(&other.powers).for_each(|(own, other)| *own += other);
        self.products.iter_mut().zip(&other.products).for_each(|(own, other)| *own += other);
        self.squares += other.squares;
    }

    /// The residual sum of squares under some coefficients.
    #[must_use]
    pub fn squares_of(&self, coefficients: &[f64]) -> f64 {
        let mut sum = self.squares;
        for (i, own) in coefficients.iter().enumerate() {
            let fitted: f64 = coefficients.iter().zip(&self.powers[i..]).map(|(other, power)| other * power).sum();
            sum += own * (fitted - 2.0 * self.products[i]);
        }
        sum.max(0.0)
    }

    /// The least-squares coefficients, constant first; `None` where the groups do not settle them.
    #[must_use]
    pub fn solve(&self) -> Option<Vec<f64>> {
        let size = self.products.len();
        if self.groups < size as u64 {
            return None;
        }
        let factor = self.factor()?;
        let mut solution = substitute(&factor, &self.products);
        // One step of refinement takes the rounding of the factor out.
        let left: Vec<f64> = (0..size)
            .map(|i| {
                let fitted: f64 = solution.iter().zip(&self.powers[i..]).map(|(c, power)| c * power).sum();
                self.products[i] - fitted
            })
            .collect();
        solution.iter_mut().zip(substitute(&factor, &left)).for_each(|(own, step)| *own += step);
        solution.iter().all(|c| c.is_finite()).then_some(solution)
    }

    /// The inverse of the normal equations' matrix, a row a vector.
    #[must_use]
    pub fn inverse(&self) -> Option<Vec<Vec<f64>>> {
        let factor = self.factor()?;
        let size = self.products.len();
        let unit = |place: usize| (0..size).map(|own| f64::from(u8::from(own == place))).collect::<Vec<f64>>();
        Some((0..size).map(|place| substitute(&factor, &unit(place))).collect())
    }

    /// Cholesky's lower-triangular factor.
    fn factor(&self) -> Option<Vec<Vec<f64>>> {
        let size = self.products.len();
        let mut factor = vec![vec![0.0; size]; size];
        for row in 0..size {
            for column in 0..=row {
                let known: f64 = (0..column).map(|k| factor[row][k] * factor[column][k]).sum();
                let rest = self.powers[row + column] - known;
                factor[row][column] = if row == column {
                    // A pivot this small against its diagonal is rounding, not data.
                    if rest <= f64::EPSILON * 64.0 * self.powers[2 * row] {
                        return None;
                    }
                    rest.sqrt()
                } else {
                    rest / factor[column][column]
                };
            }
        }
        Some(factor)
    }
}

/// Solves `L L' x = right`.
fn substitute(factor: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let size = right.len();
    let mut solution = right.to_vec();
    for row in 0..size {
        let known: f64 = (0..row).map(|k| factor[row][k] * solution[k]).sum();
        solution[row] = (solution[row] - known) / factor[row][row];
    }
    for row in (0..size).rev() {
        let known: f64 = (row + 1..size).map(|k| factor[k][row] * solution[k]).sum();
        solution[row] = (solution[row] - known) / factor[row][row];
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sums(order: usize, rows: impl Iterator<Item = (f64, f64)>) -> Sums {
        let mut sums = Sums::empty(order);
        for (x, v) in rows {
            sums.groups += 1;
            (0..).zip(&mut sums.powers).for_each(|(k, sum)| *sum += x.powi(k));
            (0..).zip(&mut sums.products).for_each(|(k, sum)| *sum += v * x.powi(k));
            sums.squares += v * v;
        }
        sums
    }

    fn at(coefficients: &[f64], x: f64) -> f64 {
        coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
    }

    #[test]
    fn an_order_five_curve_is_found_again_to_ten_digits() {
        let curve = [12.0, -300.0, 45.0, 7.0, -90.0, 33.0];
        let rows = || (0..2400).map(|k| -1.0 + f64::from(k) / 1199.5).map(|x| (x, at(&curve, x)));
        let found = sums(5, rows()).solve().unwrap();
        // Ten digits of the largest.
        assert!(found.iter().zip(curve).all(|(own, true_)| (own - true_).abs() < 1e-10 * 300.0), "{found:?}");
        assert!(sums(5, rows()).squares_of(&curve) < 1e-5);
    }

    #[test]
    fn too_few_different_temperatures_settle_nothing() {
        assert_eq!(sums(2, [(0.0, 1.0), (1.0, 2.0)].into_iter().cycle().take(100)).solve(), None);
        assert_eq!(sums(2, [(0.0, 1.0), (1.0, 2.0)].into_iter()).solve(), None);
    }

    #[test]
    fn sums_of_parts_are_the_sums_of_the_whole() {
        let rows = |from: i32, to: i32| (from..to).map(|k| f64::from(k) / 50.0 - 1.0).map(|x| (x, x * x + 0.1 * x));
        let mut parts = sums(2, rows(0, 30));
        parts.add(&sums(2, rows(30, 100)));
        let (parts, whole) = (parts.solve().unwrap(), sums(2, rows(0, 100)).solve().unwrap());
        assert!(parts.iter().zip(&whole).all(|(a, b)| (a - b).abs() < 1e-13));
    }
}
