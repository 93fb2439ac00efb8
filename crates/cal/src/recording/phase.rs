//! The words of a recording's columns: what the chamber was doing, and the flag bits.

use serde::{Deserialize, Serialize};

use crate::named::Named;

/// What the chamber was doing while a group was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Held at a temperature.
    Soak,
    /// On the way up.
    Heating,
    /// On the way down.
    Cooling,
    /// At room temperature, the supply in the gyros' place.
    Supply,
}

impl Named for Phase {
    const WHAT: &'static str = "phase";
    const ALL: &'static [Self] = &[Self::Soak, Self::Heating, Self::Cooling, Self::Supply];

    fn name(self) -> &'static str {
        Self::name(self)
    }
}

impl Phase {
    /// As in the column `phase`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Soak => "soak",
            Self::Heating => "heating",
            Self::Cooling => "cooling",
            Self::Supply => "supply",
        }
    }

    /// Whether a drift is fitted to its groups.
    #[must_use]
    pub const fn is_ramp(self) -> bool {
        matches!(self, Self::Heating | Self::Cooling)
    }
}

/// Bits of the column `flags`.
pub mod flags {
    /// The temperature was below the calibrated range.
    pub const BELOW: u16 = 1;
    /// The temperature was above the calibrated range.
    pub const ABOVE: u16 = 2;
    /// The reading was at an end of the converter.
    pub const SATURATED: u16 = 4;
    /// The tap changed when the group closed.
    pub const MOVED: u16 = 8;
    /// The temperature did not move by a count for too long, and was not believed.
    pub const STUCK: u16 = 16;
    /// The temperature jumped more than a temperature can, and was not believed.
    pub const JUMPED: u16 = 32;
    /// The temperature stood at an end of the converter, and was not believed.
    pub const TEMPERATURE_SATURATED: u16 = 64;
    /// The wiper could not be written when the group closed.
    pub const TRIM_FAILED: u16 = 128;
}
