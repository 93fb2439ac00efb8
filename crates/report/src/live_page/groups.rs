//! The groups of a step as they have come. A step of days keeps every so manieth of them.

use zerorate_cal::recording::GroupRow;
use zerorate_core::compensate::Mode;

/// Groups kept at most: a ramp of an hour has 2400, and a figure shows some hundred.
const MOST: usize = 16_384;

/// One axis of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunGroup {
    /// Seconds since the run began.
    pub time_s: f64,
    /// The mean temperature reading.
    pub temperature_counts: f64,
    /// The mean zero-rate output after the correction, if there is one.
    pub reading_counts: f64,
    /// Whether a drift is fitted to such groups.
    pub is_ramp: bool,
    /// Whether the device takes the drift off.
    pub is_compensated: bool,
}

impl From<&GroupRow> for RunGroup {
    fn from(row: &GroupRow) -> Self {
        Self {
            time_s: row.t_s,
            temperature_counts: row.sums.mean_temperature().0,
            reading_counts: row.corrected_counts,
            is_ramp: row.phase.is_ramp(),
            is_compensated: row.mode != Mode::Off,
        }
    }
}

/// One axis's groups.
#[derive(Debug, Clone, Default)]
pub struct RunGroups {
    kept: Vec<RunGroup>,
    last: Option<RunGroup>,
    came: usize,
    /// One of `1 << thinned` groups is kept.
    thinned: u32,
}

impl RunGroups {
    /// A group has come.
    pub fn push(&mut self, group: RunGroup) {
        if self.came.is_multiple_of(1 << self.thinned) {
            self.kept.push(group);
        }
        self.came += 1;
        self.last = Some(group);
        if self.kept.len() == MOST {
            self.thinned += 1;
            let mut place = 0;
            self.kept.retain(|_| {
                place += 1;
                place % 2 == 1
            });
        }
    }

    /// The newest.
    pub(super) const fn last(&self) -> Option<&RunGroup> {
        self.last.as_ref()
    }

    /// Those that are kept.
    pub(super) fn kept(&self) -> &[RunGroup] {
        &self.kept
    }

    /// How many have come.
    pub(super) const fn came(&self) -> usize {
        self.came
    }

    /// The groups of ramps; all of them where none is of a ramp.
    pub(super) fn ramp(&self) -> Vec<RunGroup> {
        let of_ramps: Vec<RunGroup> = self.kept.iter().copied().filter(|group| group.is_ramp).collect();
        if of_ramps.is_empty() { self.kept.clone() } else { of_ramps }
    }

    /// Temperatures and readings of the groups of ramps that are not compensated.
    pub(super) fn uncompensated_ramp(&self) -> (Vec<f64>, Vec<f64>) {
        let groups = self.kept.iter().filter(|group| group.is_ramp && !group.is_compensated);
        groups.map(|group| (group.temperature_counts, group.reading_counts)).unzip()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_of_days_keeps_groups_evenly_from_its_first_to_its_last() {
        let mut groups = RunGroups::default();
        for group in 0..200_000_u32 {
            groups.push(RunGroup {
                time_s: f64::from(group),
                temperature_counts: 0.0,
                reading_counts: 0.0,
                is_ramp: false,
                is_compensated: false,
            });
        }
        let steps = groups.kept().windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
        assert!(groups.kept().len() < MOST && steps.clone().all(|step| (step - 16.0).abs() < 1e-9));
        assert!((groups.last().unwrap().time_s - 199_999.0).abs() < 1e-9 && groups.came() == 200_000);
    }
}
