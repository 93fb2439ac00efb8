//! What a fit of one recording comes to, however it was made.

use zerorate_cal::calibration::AxisCalibration;
use zerorate_cal::quality::Judgement;

/// The fit of one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// The verdict on the unit.
    pub judgement: Judgement,
    /// The axes that could be fitted, of a rejected unit too: to be looked at.
    pub axes: Vec<AxisRow>,
    /// Groups whose means are not those of their sums: the file is damaged.
    pub inconsistent: u64,
}

/// The fit of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisRow {
    /// The axis's name.
    pub axis: String,
    /// Everything that a calibration has of it.
    pub calibration: AxisCalibration,
}
