//! The orthogonal factor of a growing matrix, and the reflections that keep it up to date.

/// Rows gathered before they are folded in. With seven columns a block is 14 kB and stays in the first-level cache.
pub(super) const BLOCK_ROWS: usize = 256;

/// The upper-triangular factor R of a matrix A of which only R is kept: A = QR with Q's columns orthonormal.
///
/// `|A v| = |R v|` for every v, which is all that least squares needs. Rows enter a block at a time by Householder
/// reflections (Golub and Van Loan, *Matrix Computations*, 4th ed., 5.1 and 6.5.3), so the condition number is never
/// squared as it would be in A'A.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Factor {
    columns: usize,
    /// Column-major, `columns` x `columns`; below the diagonal it is zero.
    entries: Vec<f64>,
}

impl Factor {
    /// The factor of a matrix without rows.
    pub(super) fn new(columns: usize) -> Self {
        Self { columns, entries: vec![0.0; columns * columns] }
    }

    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    /// R's entry; zero below the diagonal.
    pub(super) fn entry(&self, row: usize, column: usize) -> f64 {
        self.entries[column * self.columns + row]
    }

    /// Folds `rows` further rows of A in.
    ///
    /// `block` holds them column-major, a column every `stride` numbers; it is overwritten.
    pub(super) fn fold(&mut self, block: &mut [f64], stride: usize, rows: usize) {
        for j in 0..self.columns {
            let (left, right) = block.split_at_mut((j + 1) * stride);
            let reflector = &left[j * stride..j * stride + rows];
            let below = dot(reflector, reflector);
            if below == 0.0 {
                continue;
            }
            // The reflector is [head; reflector]; it takes [diagonal; reflector] to [-sign(diagonal) norm; 0].
            let diagonal = self.entry(j, j);
            let reflected = -(diagonal * diagonal + below).sqrt().copysign(diagonal);
            let head = diagonal - reflected;
            let scale = 2.0 / (head * head + below);
            self.entries[j * self.columns + j] = reflected;
            for (k, column) in (j + 1..self.columns).zip(right.chunks_mut(stride)) {
                let column = &mut column[..rows];
                let top = &mut self.entries[k * self.columns + j];
                let share = scale * (head * *top + dot(reflector, column));
                *top -= share * head;
                for (value, r) in column.iter_mut().zip(reflector) {
                    *value -= share * r;
                }
            }
        }
    }

    /// Folds another factor in, as if its rows had been folded here.
    pub(super) fn merge(&mut self, other: &Self) {
        self.fold(&mut other.entries.clone(), other.columns, other.columns);
    }

    /// The factor of the matrix made of some of A's columns, in the order given.
    pub(super) fn select(&self, columns: &[usize]) -> Self {
        let mut picked: Vec<f64> = columns
            .iter()
            .flat_map(|&column| &self.entries[column * self.columns..(column + 1) * self.columns])
            .copied()
            .collect();
        let mut factor = Self::new(columns.len());
        factor.fold(&mut picked, self.columns, self.columns);
        factor
    }

    /// Solves `R[..n, ..n] v = right` for an upper-triangular part of R, or `None` where it is singular in f64.
    pub(super) fn solve(&self, right: &[f64]) -> Option<Vec<f64>> {
        let n = right.len();
        let mut solution = right.to_vec();
        for i in (0..n).rev() {
            let column_norm = (0..=i).map(|row| self.entry(row, i).powi(2)).sum::<f64>().sqrt();
            // A diagonal this small against its column is rounding, not data.
            let smallest = f64::EPSILON * 16.0 * self.columns as f64 * column_norm;
            if self.entry(i, i).abs() <= smallest {
                return None;
            }
            let known: f64 = (i + 1..n).map(|k| self.entry(i, k) * solution[k]).sum();
            solution[i] = (solution[i] - known) / self.entry(i, i);
        }
        Some(solution)
    }
}

/// The inner product, in eight sums so that the compiler may use vectors and the error does not grow with one long sum.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a_chunks, b_chunks) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_chunks.zip(b_chunks) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + rest
}
