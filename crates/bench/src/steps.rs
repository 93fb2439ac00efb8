//! What a tap change does to the user of the samples: the largest jump of the corrected output.

use zerorate_core::units::Axis;
use zerorate_core::wire::{Sample, SampleWindow};

/// Samples that the output is low-passed by, and over which a jump is measured.
const WINDOW: usize = 20;
#[allow(clippy::cast_possible_truncation)] // 20
const LAST: u16 = WINDOW as u16;

/// The samples that [`StepWatch`] looks at: of an axis, the first so many of each group, and the last of the one before.
#[must_use]
pub fn window(axis: Axis, first: usize) -> SampleWindow {
    let mut axes = [false; 2];
    axes[axis.index()] = true;
    SampleWindow { axes, first: u16::try_from(first).unwrap_or(u16::MAX), last: LAST }
}

/// Watches one axis's corrected samples. A tap is changed when a group closes, so its jump, if any, lies at the
/// beginning of the next group; each group's is measured over its first second.
#[derive(Debug, Clone, Default)]
pub struct StepWatch {
    /// The last samples of the group before, at most two windows.
    tail: Vec<f64>,
}

impl StepWatch {
    /// The largest jump in the first `first` samples of a group, counts: the difference of two adjacent means of 20
    /// samples, the later of which begins in it. NaN where there are too few samples to tell.
    pub fn largest_jump(&mut self, samples: &[Sample], first: usize) -> f64 {
        let corrected = samples.iter().map(|sample| sample.corrected().0);
        let mut values = core::mem::take(&mut self.tail);
        let before = values.len();
        values.extend(corrected);
        let end = (before + first).min(values.len());
        let jump = values[..end]
            .windows(2 * WINDOW)
            .map(|both| (both[WINDOW..].iter().sum::<f64>() - both[..WINDOW].iter().sum::<f64>()).abs())
            .fold(f64::NAN, f64::max);
        // The later window of the first jump begins with the next group's first sample.
        values.drain(..values.len().saturating_sub(WINDOW));
        self.tail = values;
        #[allow(clippy::cast_precision_loss)]
        {
            jump / WINDOW as f64
        }
    }
}

/// The largest jump in the second after a tap change, less the largest in as many seconds elsewhere, counts.
///
/// `jumps` holds each group's largest jump and `moved` whether the tap changed when the group closed. For each change
/// the second to compare with begins seven groups (10.5 s) before it, so both are the largest of as many seconds of the
/// same noise: a difference near zero means that a tap change cannot be told from noise. 0 without a change to compare.
#[must_use]
pub fn largest_step(jumps: &[f64], moved: &[bool]) -> f64 {
    const BEFORE: usize = 7;
    let after_change = |group: usize| group > 0 && moved[group - 1];
    let mut after = f64::NEG_INFINITY;
    let mut elsewhere = f64::NEG_INFINITY;
    for group in (BEFORE..jumps.len()).filter(|&group| after_change(group)) {
        let quiet = (1..=BEFORE).rev().map(|back| group - back).find(|&other| !after_change(other));
        if let Some(other) = quiet {
            after = after.max(jumps[group]);
            elsewhere = elsewhere.max(jumps[other]);
        }
    }
    if after.is_finite() && elsewhere.is_finite() { after - elsewhere } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(values: impl Iterator<Item = f64>) -> Vec<Sample> {
        #[allow(clippy::cast_possible_truncation)]
        values.map(|v| Sample { temperature: 0, zro: 0, corrected_q16: (v * 65_536.0) as i32 }).collect()
    }

    #[test]
    fn a_step_between_two_groups_is_seen_whole() {
        let mut watch = StepWatch::default();
        let flat = |level: f64| samples((0..500).map(move |_| level));
        assert!(watch.largest_jump(&flat(8200.0), 333).abs() < 1e-9);
        assert!((watch.largest_jump(&flat(8231.0), 333) - 31.0).abs() < 1e-9);
        assert!(watch.largest_jump(&flat(8231.0), 333).abs() < 1e-9);
    }

    #[test]
    fn the_window_of_samples_shows_the_same_jumps_as_whole_groups() {
        let (mut whole, mut part) = (StepWatch::default(), StepWatch::default());
        let first = 60;
        for group in 0..5_u32 {
            let all = samples((0..500_u32).map(|k| f64::from((k * 7919 + group * 104_729) % 97)));
            let (before, from) = window(Axis::X, first).of(Axis::X, 500);
            let sent = [&all[..usize::from(before)], &all[usize::from(from)..]].concat();
            assert_eq!(sent.len(), 80);
            let jumps = [whole.largest_jump(&all, first), part.largest_jump(&sent, first)];
            assert_eq!(jumps[0].to_bits(), jumps[1].to_bits());
            assert!(jumps[0] > 0.0);
        }
    }

    #[test]
    fn the_largest_step_is_what_a_change_adds_to_the_noise() {
        let mut jumps = vec![2.0; 40];
        let mut moved = vec![false; 40];
        assert!(largest_step(&jumps, &moved).abs() < 1e-9);
        moved[19] = true;
        jumps[20] = 5.5;
        assert!((largest_step(&jumps, &moved) - 3.5).abs() < 1e-9);
    }
}
