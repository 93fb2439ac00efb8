//! Rows a second of the fit kernel: an order-3 fit, pushed column by column.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use zerorate_core::drift::Scale;
use zerorate_fit::least_squares::{Basis, Fit};

/// Enough rows to be past every cache, as in a long log.
const ROWS: u32 = 1_000_000;

fn fit_kernel(criterion: &mut Criterion) {
    let temperatures: Vec<f64> = (0..ROWS).map(|i| 10.0 + 50.0 * (1e-5 * f64::from(i)).sin()).collect();
    let rates: Vec<f64> = temperatures.iter().map(|t| (t / 30.0).cos()).collect();
    let scale = Scale::spanning(-40.0, 60.0).expect("a span");

    let mut group = criterion.benchmark_group("fit kernel");
    group.throughput(Throughput::Elements(u64::from(ROWS)));
    group.sample_size(20);
    group.bench_function("order 3", |bencher| {
        bencher.iter(|| {
            let mut fit = Fit::new(scale, Basis::Powers(3));
            fit.push_rows(black_box(&temperatures), black_box(&rates));
            fit.finish().expect("a solution")
        });
    });
    group.finish();
}

criterion_group!(benches, fit_kernel);
criterion_main!(benches);
