//! What a mark in a figure stands for. Its colour is the style sheet's business, so that figures follow the reader's
//! light or dark scheme and turn plain on paper.

use plotters::style::{RGBAColor, ShapeStyle};

/// What a mark stands for. The pairs that meet in one figure (X and Y, heating and cooling, raw and corrected) differ in
/// marker and dash as well as in colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// Grid lines.
    Grid,
    /// The axis line.
    Frame,
    /// Numbers at the ticks, names of the axes.
    Word,
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
    /// A stretch left out of a fit.
    LeftOut,
}

/// The shape that a point is drawn with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Marker {
    Dot,
    Ring,
    Triangle,
}

/// All inks, in the order of their numbers.
const ALL: [Ink; 13] = [
    Ink::Grid,
    Ink::Frame,
    Ink::Word,
    Ink::X,
    Ink::Y,
    Ink::Heating,
    Ink::Cooling,
    Ink::Curve,
    Ink::Aim,
    Ink::Limit,
    Ink::Raw,
    Ink::Corrected,
    Ink::LeftOut,
];

impl Ink {
    /// The class by which the style sheet knows it.
    pub(crate) fn class(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::Frame => "frame",
            Self::Word => "word",
            Self::X => "x",
            Self::Y => "y",
            Self::Heating => "heating",
            Self::Cooling => "cooling",
            Self::Curve => "curve",
            Self::Aim => "aim",
            Self::Limit => "limit",
            Self::Raw => "raw",
            Self::Corrected => "corrected",
            Self::LeftOut => "left-out",
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

    /// The ink as a colour of plotters, which passes colours through to the backend untouched.
    pub(super) fn color(self) -> RGBAColor {
        // Thirteen inks fit into a byte.
        #[allow(clippy::cast_possible_truncation)]
        let number = self as usize as u8;
        RGBAColor(number, 0, 0, 1.0)
    }

    /// The ink as a style; the width is the style sheet's.
    pub(super) fn style(self) -> ShapeStyle {
        ShapeStyle { color: self.color(), filled: true, stroke_width: 1 }
    }

    /// The ink that [`Ink::color`] made this colour of.
    pub(super) fn of(rgb: (u8, u8, u8)) -> Self {
        ALL.get(usize::from(rgb.0)).copied().unwrap_or(Self::Frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ink_survives_its_way_through_a_colour() {
        for ink in ALL {
            let RGBAColor(red, green, blue, _) = ink.color();
            assert_eq!(Ink::of((red, green, blue)), ink);
        }
    }

    #[test]
    fn pairs_that_meet_in_a_figure_have_different_markers() {
        assert_ne!(Ink::X.marker(), Ink::Y.marker());
        assert_ne!(Ink::Heating.marker(), Ink::Cooling.marker());
    }
}
