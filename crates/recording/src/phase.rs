//! What the chamber was doing.

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
