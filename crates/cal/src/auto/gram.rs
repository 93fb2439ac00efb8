//! Sums of products of columns, and ridge regression on some of them.
//!
//! Candidates are many and share their columns, so the products are summed once a stretch; a candidate is a choice of
//! rows and columns of the sums, and a fit without a stretch is a subtraction. The columns are of the order of one and the
//! rates are taken from their mean, so that squaring the condition number costs nothing that the ridge has not settled.

/// `A'WA` of columns `A` with the rate as the last one.
#[derive(Debug, Clone)]
pub(super) struct Gram {
    size: usize,
    entries: Vec<f64>,
    /// Sum of the weights.
    pub weight: f64,
}

impl Gram {
    pub(super) fn new(columns: usize) -> Self {
        Self { size: columns + 1, entries: vec![0.0; (columns + 1) * (columns + 1)], weight: 0.0 }
    }

    /// Takes in a row of columns and its rate.
    pub(super) fn push(&mut self, row: &[f64], rate: f64, weight: f64) {
        self.weight += weight;
        let last = self.size - 1;
        for (i, entries) in self.entries.chunks_exact_mut(self.size).take(last).enumerate() {
            let scaled = weight * row[i];
            if scaled == 0.0 {
                continue;
            }
            entries[i..last].iter_mut().zip(&row[i..]).for_each(|(entry, value)| *entry += scaled * value);
            entries[last] += scaled * rate;
        }
        self.entries[last * self.size + last] += weight * rate * rate;
    }

    /// The same sums as those of `columns` among more of them; the others' are nothing.
    pub(super) fn among(&self, columns: &[usize], of: usize) -> Self {
        let mut whole = Self { weight: self.weight, ..Self::new(of) };
        let own = self.size - 1;
        for (i, &row) in columns.iter().enumerate() {
            for (j, &column) in columns.iter().enumerate().skip(i) {
                whole.entries[row.min(column) * whole.size + row.max(column)] = self.entries[i * self.size + j];
            }
            whole.entries[row * whole.size + of] = self.entries[i * self.size + own];
        }
        whole.entries[of * whole.size + of] = self.entries[own * self.size + own];
        whole
    }

    pub(super) fn add(&mut self, other: &Self, sign: f64) {
        self.weight += sign * other.weight;
        self.entries.iter_mut().zip(&other.entries).for_each(|(own, other)| *own += sign * other);
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.entries[i.min(j) * self.size + i.max(j)]
    }

    /// The mean square of `rate - sum of beta column` over the rows taken in.
    pub(super) fn mean_square(&self, columns: &[usize], beta: &[f64]) -> f64 {
        let last = self.size - 1;
        let mut sum = self.at(last, last);
        for (&i, b) in columns.iter().zip(beta) {
            sum -= 2.0 * b * self.at(i, last);
            for (&j, c) in columns.iter().zip(beta) {
                sum += b * c * self.at(i, j);
            }
        }
        sum.max(0.0) / self.weight
    }
}

/// Room for a solution, used again and again.
#[derive(Debug, Clone, Default)]
pub(super) struct Workspace {
    factor: Vec<f64>,
    pub beta: Vec<f64>,
}

/// A pivot below this share of its diagonal is rounding, not data: 1e4 times the square root of f64's rounding, squared.
const LEAST_PIVOT: f64 = 1e-9;

impl Workspace {
    /// Minimises `|rate - A beta|^2 + weight * sum of penalty`, where the penalty is `ridge[k] beta_k^2` a column and
    /// `smooth` times the squared second differences of the coefficients `hats`. `false` where the rows do not settle it.
    pub(super) fn solve(&mut self, gram: &Gram, fit: &Penalised<'_>) -> bool {
        if !self.factorise(gram, fit) {
            return false;
        }
        let n = fit.columns.len();
        self.beta.clear();
        self.beta.extend(fit.columns.iter().map(|&column| gram.at(column, gram.size - 1)));
        for i in 0..n {
            let known: f64 = (0..i).map(|k| self.factor[i * n + k] * self.beta[k]).sum();
            self.beta[i] = (self.beta[i] - known) / self.factor[i * n + i];
        }
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|k| self.factor[k * n + i] * self.beta[k]).sum();
            self.beta[i] = (self.beta[i] - known) / self.factor[i * n + i];
        }
        true
    }

    /// The lower Cholesky factor of `A'WA + penalty`.
    fn factorise(&mut self, gram: &Gram, fit: &Penalised<'_>) -> bool {
        let n = fit.columns.len();
        self.factor.clear();
        self.factor.resize(n * n, 0.0);
        for (i, &column) in fit.columns.iter().enumerate() {
            for (j, &other) in fit.columns[..=i].iter().enumerate() {
                self.factor[i * n + j] = gram.at(column, other);
            }
            self.factor[i * n + i] += gram.weight * fit.ridge[i];
        }
        for middle in 1..fit.hats.saturating_sub(1) {
            let differences = [(middle - 1, 1.0), (middle, -2.0), (middle + 1, 1.0)];
            for (i, a) in differences {
                for (j, b) in differences.iter().filter(|(j, _)| *j <= i) {
                    self.factor[i * n + j] += gram.weight * fit.smooth * a * b;
                }
            }
        }
        for i in 0..n {
            for j in 0..=i {
                let (upper, lower) = self.factor.split_at(i * n);
                let known: f64 = if i == j {
                    lower[..j].iter().map(|value| value * value).sum()
                } else {
                    lower[..j].iter().zip(&upper[j * n..]).map(|(a, b)| a * b).sum()
                };
                let left = self.factor[i * n + j] - known;
                if i == j {
                    if left.is_nan() || left <= LEAST_PIVOT * self.factor[i * n + i] {
                        return false;
                    }
                    self.factor[i * n + i] = left.sqrt();
                } else {
                    self.factor[i * n + j] = left / self.factor[j * n + j];
                }
            }
        }
        true
    }

    /// The inverse of `A'WA + penalty`, a row a coefficient; `None` where the rows do not settle it.
    pub(super) fn inverse(&mut self, gram: &Gram, fit: &Penalised<'_>) -> Option<Vec<Vec<f64>>> {
        if !self.factorise(gram, fit) {
            return None;
        }
        let n = fit.columns.len();
        // inv(L), a row after the other; inv(LL') = inv(L)' inv(L).
        let mut inverse = vec![vec![0.0; n]; n];
        for i in 0..n {
            let (above, row) = inverse.split_at_mut(i);
            let row = &mut row[0];
            row[i] = 1.0 / self.factor[i * n + i];
            for (j, value) in row[..i].iter_mut().enumerate() {
                let known: f64 = (j..i).map(|k| self.factor[i * n + k] * above[k][j]).sum();
                *value = -known / self.factor[i * n + i];
            }
        }
        let entry = |a: usize, b: usize| (a.max(b)..n).map(|k| inverse[k][a] * inverse[k][b]).sum();
        Some((0..n).map(|a| (0..n).map(|b| entry(a, b)).collect()).collect())
    }
}

/// What is to be minimised: which columns, and how strongly their coefficients are drawn to zero.
#[derive(Debug, Clone, Copy)]
pub(super) struct Penalised<'a> {
    pub columns: &'a [usize],
    pub ridge: &'a [f64],
    /// The first so many columns are the hats of a table; 0 for a polynomial.
    pub hats: usize,
    pub smooth: f64,
}
