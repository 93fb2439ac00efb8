//! How far each group is from the groups beside it.
//!
//! A wild group stands out from its neighbours. What a curve that is too poor leaves does not, however large it is: the
//! drift, the settling after a chamber is switched, a gyro's slow noise all take many groups to come and go.

use zerorate_fit::robust::median;

/// Neighbours of a group: six seconds to each side of it, over which a die of some seconds moves little. The median of
/// eight is not moved by three wild ones in a row.
const NEIGHBOURS: usize = 8;

/// What a curve leaves of each group, less the median of what it leaves of the neighbours; at an end these are to one
/// side. Empty where there are too few groups to have neighbours.
pub(super) fn distances(residuals: &[f64]) -> impl Iterator<Item = f64> {
    let last = residuals.len().saturating_sub(1);
    let groups = if last < NEIGHBOURS { 0 } else { residuals.len() };
    (0..groups).map(move |group| {
        let first = group.saturating_sub(NEIGHBOURS / 2).min(last - NEIGHBOURS);
        let mut beside = [0.0; NEIGHBOURS];
        let others = (first..=first + NEIGHBOURS).filter(|other| *other != group);
        beside.iter_mut().zip(others).for_each(|(place, other)| *place = residuals[other]);
        residuals[group] - median(&mut beside)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_keeps_no_distance_but_at_its_ends() {
        let line: Vec<f64> = (0..20).map(f64::from).collect();
        let found: Vec<f64> = distances(&line).collect();
        assert!(found[4..16].iter().all(|distance| distance.abs() < 1e-12), "{found:?}");
        // Of 1 to 8 the median is 4.5.
        assert!((found[0] + 4.5).abs() < 1e-12 && (found[19] - 4.5).abs() < 1e-12);
    }

    #[test]
    fn three_wild_groups_in_a_row_are_each_as_far_as_they_are_off() {
        let mut residuals = vec![0.0; 30];
        residuals[10..13].fill(50.0);
        let found: Vec<f64> = distances(&residuals).collect();
        assert!((0..30).all(|group| (found[group] - residuals[group]).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn eight_groups_have_too_few_neighbours() {
        assert_eq!((distances(&[1.0; 8]).count(), distances(&[]).count(), distances(&[1.0; 9]).count()), (0, 0, 9));
    }
}
