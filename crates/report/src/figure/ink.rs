//! What a mark in a figure stands for. Its colour is the style sheet's business, so that figures follow the reader's
//! light or dark scheme and turn plain on paper.

/// What a mark stands for. The pairs that meet in one figure (X and Y, heating and cooling, raw and corrected) differ in
/// marker and dash as well as in colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// The first axis of the gyro.
    X,
    /// The second axis of the gyro.
    Y,
    /// Recorded while it warmed.
    Heating,
    /// Recorded while it cooled.
    Cooling,
    /// A fitted curve.
    Curve,
    /// A line that was aimed at, or zero.
    Aim,
    /// A limit that must be kept.
    Limit,
    /// What was not corrected.
    Raw,
    /// What a correction left.
    Corrected,
    /// An interval excluded from a fit.
    Excluded,
}

/// The shape that a point is drawn with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Marker {
    Dot,
    Ring,
    Triangle,
}

impl Ink {
    /// The class by which the style sheet knows it.
    pub(super) fn class(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Heating => "heating",
            Self::Cooling => "cooling",
            Self::Curve => "curve",
            Self::Aim => "aim",
            Self::Limit => "limit",
            Self::Raw => "raw",
            Self::Corrected => "corrected",
            Self::Excluded => "excluded",
        }
    }

    /// The shape of its points.
    pub(super) fn marker(self) -> Marker {
        match self {
            Self::Y | Self::Cooling => Marker::Triangle,
            Self::Curve => Marker::Ring,
            _ => Marker::Dot,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_that_meet_in_a_figure_have_different_markers() {
        assert_ne!(Ink::X.marker(), Ink::Y.marker());
        assert_ne!(Ink::Heating.marker(), Ink::Cooling.marker());
    }
}
