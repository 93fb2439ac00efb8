//! Newtypes for the quantities that travel through the project.
//!
//! An unbounded quantity has a public field. A bounded one has a private field and a constructor that can refuse.
//! Temperature is affine: a difference of two [`Celsius`] is [`Kelvins`], and two `Celsius` cannot be added.

use core::ops::{Add, Mul, Sub};

use serde::{Deserialize, Serialize};

/// Defines linear quantities over `f64`: they can be added, subtracted and scaled by a number.
macro_rules! linear_quantities {
    ($($(#[$doc:meta])* $name:ident,)+) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
        pub struct $name(pub f64);

        impl Add for $name {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self(self.0 + other.0)
            }
        }

        impl Sub for $name {
            type Output = Self;
            fn sub(self, other: Self) -> Self {
                Self(self.0 - other.0)
            }
        }

        impl Mul<f64> for $name {
            type Output = Self;
            fn mul(self, factor: f64) -> Self {
                Self(self.0 * factor)
            }
        }
    )+};
}

linear_quantities! {
    /// A/D counts: a reading, a mean of readings, or a difference of them. One count is one step of the converter.
    Counts,
    /// Volts.
    Volts,
    /// A span of time in seconds.
    Seconds,
    /// A difference of temperatures in kelvins.
    Kelvins,
    /// Angular rate in degrees per second.
    DegreesPerSecond,
}

/// A temperature in degrees Celsius. Affine: `Celsius - Celsius = Kelvins`, `Celsius + Kelvins = Celsius`.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
pub struct Celsius(pub f64);

impl Sub for Celsius {
    type Output = Kelvins;
    fn sub(self, other: Self) -> Kelvins {
        Kelvins(self.0 - other.0)
    }
}

impl Add<Kelvins> for Celsius {
    type Output = Self;
    fn add(self, difference: Kelvins) -> Self {
        Self(self.0 + difference.0)
    }
}

/// The position of a 1024-tap potentiometer's wiper, 0 to 1023.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "u16", into = "u16")]
// One more than the position: so a tap that may be none fits one register, and an update of the loop needs no stack.
pub struct Taps(core::num::NonZeroU16);

impl Taps {
    /// The first position.
    pub const FIRST: Self = Self::at(0);
    /// The paper's N0: the lower of the two middle positions of 1024 (docs/paper.md, S2).
    pub const MIDDLE: Self = Self::at(511);
    /// The last position.
    pub const LAST: Self = Self::at(1023);

    /// A wiper position, or `None` above 1023.
    #[must_use]
    pub const fn new(position: u16) -> Option<Self> {
        if position <= Self::LAST.get() { Some(Self::at(position)) } else { None }
    }

    /// The position as a number, 0 to 1023.
    #[must_use]
    pub const fn get(self) -> u16 {
        self.0.get() - 1
    }

    /// How many taps this one is after another; more than there are when it is before it.
    #[inline]
    pub(crate) fn after(self, first: Self) -> usize {
        usize::from(self.0.get()).wrapping_sub(usize::from(first.0.get()))
    }

    /// A position below the highest number of 16 bits.
    const fn at(position: u16) -> Self {
        Self(core::num::NonZeroU16::MIN.saturating_add(position))
    }
}

impl core::fmt::Debug for Taps {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Taps").field(&self.get()).finish()
    }
}

impl From<Taps> for u16 {
    fn from(taps: Taps) -> Self {
        taps.get()
    }
}

impl TryFrom<u16> for Taps {
    type Error = &'static str;
    fn try_from(position: u16) -> Result<Self, Self::Error> {
        Self::new(position).ok_or("a wiper position is 0 to 1023")
    }
}

/// A group's mean temperature as the law takes it: an unsigned 16-bit code.
///
/// On a 14-bit board one code is a quarter count ([`TemperatureScale::QUARTER_COUNTS`]), so that the mean of a group
/// keeps the resolution that averaging gave it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct TemperatureCode(pub u16);

/// How a [`TemperatureCode`] stands for a temperature in the gyro's own unit: `T = zero + step * code`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TemperatureScale {
    /// The temperature at code 0, in the gyro's own unit (counts on the analogue board, degrees C on a digital IMU).
    pub zero: f64,
    /// The temperature of one code, in the same unit; above zero.
    pub step: f64,
}

impl TemperatureScale {
    /// A quarter count a code, from 0: all of a 14-bit converter's readings (4 x 16383 = 65532).
    pub const QUARTER_COUNTS: Self = Self { zero: 0.0, step: 0.25 };

    /// The temperature that a code stands for, in the gyro's own unit.
    #[must_use]
    pub fn temperature(&self, code: TemperatureCode) -> f64 {
        self.zero + self.step * f64::from(code.0)
    }

    /// The nearest code to a temperature; below or above the scale the first or last code; `None` for NaN.
    #[must_use]
    pub fn code(&self, temperature: f64) -> Option<TemperatureCode> {
        let steps = libm::round((temperature - self.zero) / self.step);
        if steps.is_nan() {
            return None;
        }
        // The clamp makes the cast exact.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        Some(TemperatureCode(steps.clamp(0.0, f64::from(u16::MAX)) as u16))
    }
}

/// One of the board's two gyros.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Axis {
    /// The first gyro.
    X,
    /// The second gyro.
    Y,
}

impl Axis {
    /// Both, in the order in which every array of axes is kept.
    pub const BOTH: [Self; 2] = [Self::X, Self::Y];

    /// The axis's place in an array of axes.
    #[must_use]
    pub const fn index(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
        }
    }

    /// The other of the two.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::X => Self::Y,
            Self::Y => Self::X,
        }
    }

    /// `"x"` or `"y"`, as in recordings and summaries.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
        }
    }
}

/// The number of a group since the device's acquisition was restarted. Everything on a bench is ordered by it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct GroupNumber(pub u32);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wiper_position_past_the_last_tap_cannot_be_built() {
        assert_eq!(Taps::new(1023), Some(Taps::LAST));
        assert_eq!(Taps::new(1024), None);
        assert!(postcard::from_bytes::<Taps>(&[0x80, 0x08]).is_err(), "1024 as a varint");
    }

    #[test]
    fn temperatures_are_affine() {
        assert_eq!(Celsius(60.0) - Celsius(-40.0), Kelvins(100.0));
        assert_eq!(Celsius(-40.0) + Kelvins(65.0), Celsius(25.0));
    }

    #[test]
    fn a_quarter_count_code_covers_a_14_bit_converter() {
        let scale = TemperatureScale::QUARTER_COUNTS;
        assert_eq!(scale.code(16383.0), Some(TemperatureCode(65532)));
        assert_eq!(scale.code(8500.13), Some(TemperatureCode(34001)));
        assert_eq!(scale.code(-3.0), Some(TemperatureCode(0)));
        assert_eq!(scale.code(1e9), Some(TemperatureCode(u16::MAX)));
        assert_eq!(scale.code(f64::NAN), None);
        for code in (0..=u16::MAX).map(TemperatureCode) {
            assert_eq!(scale.code(scale.temperature(code)), Some(code));
        }
    }
}
