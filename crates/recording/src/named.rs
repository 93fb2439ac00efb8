//! What stands in files by its name: modes, axes, phases of the chamber.

use serde::{Deserialize, Deserializer, Serializer, de};
use zerorate_core::compensate::Mode;
use zerorate_core::units::Axis;

/// Something with a name in files.
pub trait Named: Copy + 'static {
    /// What it is, for messages.
    const WHAT: &'static str;
    /// All there are.
    const ALL: &'static [Self];

    /// Its name.
    fn name(self) -> &'static str;

    /// The one of a name.
    ///
    /// # Errors
    /// What is wrong with it.
    fn of_name(name: &str) -> Result<Self, String> {
        let names = || Self::ALL.iter().map(|known| known.name()).collect::<Vec<_>>().join(", ");
        let found = Self::ALL.iter().copied().find(|known| known.name() == name);
        found.ok_or_else(|| format!("'{name}' is no {}: there are {}", Self::WHAT, names()))
    }
}

impl Named for Mode {
    const WHAT: &'static str = "mode";
    const ALL: &'static [Self] = &[Self::Off, Self::Trim, Self::Digital, Self::Hybrid];

    fn name(self) -> &'static str {
        Self::name(self)
    }
}

impl Named for Axis {
    const WHAT: &'static str = "axis";
    const ALL: &'static [Self] = &Self::BOTH;

    fn name(self) -> &'static str {
        Self::name(self)
    }
}

/// Writes the name, for `#[serde(with = "zerorate_recording::named")]`.
// By serde's rule a value is passed by reference.
/// # Errors
/// The serializer's.
#[allow(clippy::trivially_copy_pass_by_ref)]
pub fn serialize<T: Named, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(value.name())
}

/// Reads the name.
///
/// # Errors
/// When there is none of that name.
pub fn deserialize<'de, T: Named, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    T::of_name(&String::deserialize(deserializer)?).map_err(de::Error::custom)
}
