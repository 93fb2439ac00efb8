//! What makes a unit bad, done to its recording.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};
use zerorate_cal::recording::{GroupRow, RecordingInfo};
use zerorate_core::units::Axis;

/// What is bad about a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Defect {
    /// An axis's temperature sensor repeats its last group from somewhere in the run on.
    StuckTemperature,
    /// An axis's reading does.
    StuckReading,
    /// The recording ends before the ramp does.
    CutRun,
    /// The recording has another unit's serial.
    WrongSerial,
    /// Some groups of an axis are hundreds to thousands of counts off.
    Outliers,
}

impl Defect {
    /// Every kind.
    pub const ALL: [Self; 5] =
        [Self::StuckTemperature, Self::CutRun, Self::Outliers, Self::WrongSerial, Self::StuckReading];
}

/// Spoils a recording.
pub(super) fn spoil(defect: Defect, seed: u64, rows: &mut Vec<GroupRow>, info: &mut RecordingInfo, other_serial: &str) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0xbad);
    let axis = Axis::BOTH[random.random_range(0..2)];
    match defect {
        Defect::WrongSerial => info.unit_serial = other_serial.to_owned(),
        Defect::CutRun => {
            // Both rows of a group.
            let kept = random.random_range(rows.len() / 5..rows.len() * 9 / 10) / 2 * 2;
            rows.truncate(kept);
        }
        Defect::StuckTemperature | Defect::StuckReading => {
            let from = random.random_range(rows.len() / 5..rows.len() * 3 / 5);
            let mut held = None;
            for row in rows.iter_mut().skip(from).filter(|row| row.axis == axis) {
                let held = *held.get_or_insert(row.sums);
                if defect == Defect::StuckTemperature {
                    (row.sums.temperature, row.sums.temperature_sq) = (held.temperature, held.temperature_sq);
                } else {
                    (row.sums.zro, row.sums.zro_sq) = (held.zro, held.zro_sq);
                }
            }
        }
        Defect::Outliers => {
            let outliers = random.random_range(8..40);
            for _ in 0..outliers {
                let place = random.random_range(0..rows.len() / 2) * 2 + axis.index();
                let shift: u64 = random.random_range(400..3000);
                shift_down(&mut rows[place], shift);
            }
        }
    }
}

/// Every sample of a group this many counts lower, as far as the converter goes.
fn shift_down(row: &mut GroupRow, counts: u64) {
    let n = u64::from(row.sums.n);
    let shift = counts.min(row.sums.zro / n.max(1) / 2);
    // sum (z - d)^2 = sum z^2 - 2 d sum z + n d^2
    row.sums.zro_sq = row.sums.zro_sq + n * shift * shift - 2 * shift * row.sums.zro;
    row.sums.zro -= n * shift;
}
