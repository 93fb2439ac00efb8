//! The autopilot's board orientations (libraries/AP_Math/rotations.h).

/// Roll, pitch and yaw in degrees, by number.
const ANGLES: [[f64; 3]; 44] = [
    [0.0, 0.0, 0.0],
    [0.0, 0.0, 45.0],
    [0.0, 0.0, 90.0],
    [0.0, 0.0, 135.0],
    [0.0, 0.0, 180.0],
    [0.0, 0.0, 225.0],
    [0.0, 0.0, 270.0],
    [0.0, 0.0, 315.0],
    [180.0, 0.0, 0.0],
    [180.0, 0.0, 45.0],
    [180.0, 0.0, 90.0],
    [180.0, 0.0, 135.0],
    [0.0, 180.0, 0.0],
    [180.0, 0.0, 225.0],
    [180.0, 0.0, 270.0],
    [180.0, 0.0, 315.0],
    [90.0, 0.0, 0.0],
    [90.0, 0.0, 45.0],
    [90.0, 0.0, 90.0],
    [90.0, 0.0, 135.0],
    [270.0, 0.0, 0.0],
    [270.0, 0.0, 45.0],
    [270.0, 0.0, 90.0],
    [270.0, 0.0, 135.0],
    [0.0, 90.0, 0.0],
    [0.0, 270.0, 0.0],
    [0.0, 180.0, 90.0],
    [0.0, 180.0, 270.0],
    [90.0, 90.0, 0.0],
    [180.0, 90.0, 0.0],
    [270.0, 90.0, 0.0],
    [90.0, 180.0, 0.0],
    [270.0, 180.0, 0.0],
    [90.0, 270.0, 0.0],
    [180.0, 270.0, 0.0],
    [270.0, 270.0, 0.0],
    [90.0, 180.0, 90.0],
    [90.0, 0.0, 270.0],
    // Its name rounds 68.8 and 293.3 degrees.
    [90.0, 68.8, 293.3],
    [0.0, 315.0, 0.0],
    [90.0, 315.0, 0.0],
    [0.0, 7.0, 0.0],
    [45.0, 0.0, 0.0],
    [315.0, 0.0, 0.0],
];

/// A rotation from the sensor's axes to the board's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rotation([[f64; 3]; 3]);

impl Rotation {
    /// The rotation of an orientation: about x by roll, then y by pitch, then z by yaw. `None` for a number that has no
    /// angles, as the custom ones.
    pub(super) fn of(orientation: f64) -> Option<Self> {
        let number = (0..ANGLES.len()).find(|number| (orientation - *number as f64).abs() < 0.5)?;
        let [(sr, cr), (sp, cp), (sy, cy)] = ANGLES[number].map(|degrees| degrees.to_radians().sin_cos());
        Some(Self([
            [cp * cy, sr * sp * cy - cr * sy, cr * sp * cy + sr * sy],
            [cp * sy, sr * sp * sy + cr * cy, cr * sp * sy - sr * cy],
            [-sp, sr * cp, cr * cp],
        ]))
    }

    /// From the board's axes back to the sensor's.
    pub(super) fn inverse(&self, v: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|column| (0..3).map(|row| self.0[row][column] * v[row]).sum())
    }

    #[cfg(test)]
    pub(super) fn forward(&self, v: [f64; 3]) -> [f64; 3] {
        self.0.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum())
    }
}
