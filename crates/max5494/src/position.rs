//! Where a wiper stands.

/// A wiper's position, in taps from the L end: 0 to 1023. No other value can be built.
///
/// ```
/// # use max5494::Position;
/// assert_eq!(Position::new(1023), Some(Position::LAST));
/// assert_eq!(Position::new(1024), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Position(u16);

impl Position {
    /// The tap closest to the L end.
    pub const FIRST: Self = Self(0);
    /// The tap closest to the H end. The part has ten bits: 2^10 - 1.
    pub const LAST: Self = Self((1 << 10) - 1);

    /// The position `taps` away from the L end, or `None` above 1023.
    #[must_use]
    pub const fn new(taps: u16) -> Option<Self> {
        if taps <= Self::LAST.0 {
            Some(Self(taps))
        } else {
            None
        }
    }

    /// The position in taps, 0 to 1023.
    #[must_use]
    pub const fn get(self) -> u16 {
        self.0
    }
}
