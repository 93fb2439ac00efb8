//! The variable that curves are kept in.

/// A span of temperature and the centred variable on it: `x = (T - centre) / half_span`, -1 to 1 from end to end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    centre: f64,
    half_span: f64,
}

impl Scale {
    /// The scale that maps `min..max` to -1..1; `None` unless both are finite and `min < max`.
    #[must_use]
    pub fn spanning(min: f64, max: f64) -> Option<Self> {
        Self::new(f64::midpoint(min, max), 0.5 * (max - min))
    }

    /// A scale by its centre and half span, in the temperature's unit; `None` unless finite and `half_span > 0`.
    #[must_use]
    pub fn new(centre: f64, half_span: f64) -> Option<Self> {
        (centre.is_finite() && half_span.is_finite() && half_span > 0.0).then_some(Self { centre, half_span })
    }

    /// The temperature at `x = 0`.
    #[must_use]
    pub const fn centre(&self) -> f64 {
        self.centre
    }

    /// The temperature from `x = 0` to `x = 1`.
    #[must_use]
    pub const fn half_span(&self) -> f64 {
        self.half_span
    }

    /// The centred variable at a temperature.
    #[must_use]
    pub fn x(&self, temperature: f64) -> f64 {
        (temperature - self.centre) / self.half_span
    }

    /// The temperature at a value of the centred variable.
    #[must_use]
    pub fn temperature(&self, x: f64) -> f64 {
        self.centre + self.half_span * x
    }
}
