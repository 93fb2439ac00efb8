//! Bits of the column `status_bits`: what the device said of a group.

/// Each bit once: its name, its value, and the sentence that stands here, in the README and in every file.
macro_rules! bits {
    ($(#[doc = $meaning:literal] $name:ident = $bit:literal;)+) => {
        $(#[doc = $meaning] pub const $name: u16 = $bit;)+

        /// Every bit with its meaning.
        pub(super) const MEANINGS: &[(u16, &str)] = &[$(($name, $meaning.trim_ascii())),+];
    };
}

bits! {
    /// The temperature was below the calibrated range.
    BELOW = 1;
    /// The temperature was above the calibrated range.
    ABOVE = 2;
    /// The reading was at an end of the converter.
    SATURATED = 4;
    /// The tap changed when the group closed.
    MOVED = 8;
    /// The temperature did not move by a count for too long, and was not believed.
    STUCK = 16;
    /// The temperature jumped more than a temperature can, and was not believed.
    JUMPED = 32;
    /// The temperature stood at an end of the converter, and was not believed.
    TEMPERATURE_SATURATED = 64;
    /// The wiper could not be written when the group closed.
    TRIM_FAILED = 128;
}
