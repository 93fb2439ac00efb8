//! Axes side by side: the fit of one knows nothing of the others, and takes longer than the reading of most logs.

use std::iter::once;
use std::panic::resume_unwind;
use std::thread::{Builder, scope};

/// What `work` makes of each place, in their order. Where there are no threads, as in a page, one after the other.
#[must_use]
pub fn side_by_side<T: Send>(places: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    if cfg!(target_family = "wasm") || places < 2 {
        return (0..places).map(work).collect();
    }
    let work = &work;
    scope(|scope| {
        let others: Vec<_> =
            (1..places).map(|place| (place, Builder::new().spawn_scoped(scope, move || work(place)))).collect();
        let first = work(0);
        let finished = others.into_iter().map(|(place, worker)| match worker {
            Ok(worker) => worker.join().unwrap_or_else(|panic| resume_unwind(panic)),
            Err(_) => work(place),
        });
        once(first).chain(finished).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_made_of_each_place_comes_in_their_order() {
        for places in [0, 1, 2, 9] {
            assert_eq!(side_by_side(places, |place| place * place), (0..places).map(|n| n * n).collect::<Vec<_>>());
        }
    }

    #[test]
    #[should_panic(expected = "a fault of one")]
    fn a_panic_of_one_is_a_panic_of_all() {
        let _ = side_by_side(3, |place| assert!(place < 2, "a fault of one"));
    }
}
