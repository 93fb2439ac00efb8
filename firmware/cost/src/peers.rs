//! What PX4 does for one axis, written from its formula (firmware/README.md): a cubic in float with a clamp and a
//! subtraction.

/// `d = clamp(T, TMIN, TMAX) - TREF; offset = X0 + X1 d + X2 d^2 + X3 d^3`, T in degrees C and the offset in rad/s.
pub struct Cubic {
    min: f32,
    max: f32,
    reference: f32,
    x: [f32; 4],
}

/// One such calibration.
pub const CUBIC: Cubic = Cubic { min: -10.0, max: 55.0, reference: 25.0, x: [0.011, -2.1e-4, 3.0e-6, -4.0e-8] };

/// `corrected = raw - offset`.
pub fn correct(cubic: &Cubic, temperature: f32, raw: f32) -> f32 {
    let held = if temperature < cubic.min {
        cubic.min
    } else if temperature > cubic.max {
        cubic.max
    } else {
        temperature
    };
    let d = held - cubic.reference;
    let [x0, x1, x2, x3] = cubic.x;
    raw - (x0 + (x1 + (x2 + x3 * d) * d) * d)
}
