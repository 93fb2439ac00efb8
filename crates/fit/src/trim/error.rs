//! What can be wrong with the trim experiment.

use thiserror::Error;
use zerorate_core::trim::MAX_TAP_OFFSETS;

use super::{LEAST_POINTS, REACH_TAPS};
use crate::least_squares::FitError;

/// Why there is no trim model.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum TrimFitError {
    /// Too few supply voltages.
    #[error("{found} supply voltages do not settle a line: measure at {LEAST_POINTS} or more (the paper: 21)")]
    TooFewPoints {
        /// Voltages measured.
        found: usize,
    },
    /// A reading is no number.
    #[error("at {supply_v:.4} V a reading is not a number: the group was empty or lost; measure this voltage again")]
    NotFinite {
        /// The supply voltage.
        supply_v: f64,
    },
    /// The search ended at the same tap at every voltage.
    #[error(
        "the search ended at tap {tap} at every supply voltage: the supply did not reach the inputs, the wiper does not move, or the span of voltages is less than a tap; check that what is fed changes the reading, and measure again"
    )]
    OneTap {
        /// The tap.
        tap: u16,
    },
    /// The reading at the middle tap does not follow the supply.
    #[error(
        "the reading stays at {reading:.1} counts whatever the supply and the tap: the supply does not reach the input; check its leads, and measure again"
    )]
    OneReading {
        /// The reading.
        reading: f64,
    },
    /// A higher tap lowers the reading.
    #[error(
        "a higher tap lowers the reading ({slope_taps_per_count:.5} taps per count; the law needs a slope below zero): swap the supply's leads, or the sign of the zero-adjust circuit"
    )]
    WrongSign {
        /// The slope found.
        slope_taps_per_count: f64,
    },
    /// The tap search did not reach the centre.
    #[error(
        "at {supply_v:.4} V the search ended at tap {tap} with a reading of {trimmed:.1} counts, {off_taps:.1} taps from the centre aimed at, {aim:.1} (at most {REACH_TAPS}): the voltage is beyond the trim's range; use a narrower span of voltages, or check the wiper"
    )]
    NotReached {
        /// The supply voltage.
        supply_v: f64,
        /// The tap found.
        tap: u16,
        /// The reading there, counts.
        trimmed: f64,
        /// The centre aimed at, counts.
        aim: f64,
        /// How far off, taps.
        off_taps: f64,
    },
    /// A point lies off the line of the others.
    #[error(
        "at {supply_v:.4} V the point lies {off_taps:.1} taps off the line of the others (reading at the middle tap {at_middle:.1} counts): the converter was at its end there, or the supply had not settled; use a narrower span, or wait longer"
    )]
    Stray {
        /// The supply voltage.
        supply_v: f64,
        /// The reading at the middle tap, counts.
        at_middle: f64,
        /// How far off, taps.
        off_taps: f64,
    },
    /// The line could not be fitted.
    #[error("the trim line could not be fitted: {0}")]
    Fit(#[from] FitError),
    /// The centre is no number.
    #[error("the centre of a trim model must be a finite number of counts")]
    Centre,
    /// No tap was swept.
    #[error("the sweep of taps is empty: read every tap of the working range once")]
    EmptySweep,
    /// A reading of the sweep is no number.
    #[error("the reading at tap {tap} is not a number: the group was empty or lost; read this tap again")]
    SweepNotFinite {
        /// The tap.
        tap: u16,
    },
    /// The middle tap is not among those swept.
    #[error(
        "the sweep from tap {first} to {last} has no reading at the middle tap {middle}, which all are compared with"
    )]
    NoMiddle {
        /// The middle tap.
        middle: u16,
        /// The first tap swept.
        first: u16,
        /// The last.
        last: u16,
    },
    /// A tap of the working range was not read.
    #[error("the sweep of taps has a gap: tap {tap} was not read")]
    Gap {
        /// The first tap missing.
        tap: u16,
    },
    /// A higher tap does not raise the reading.
    #[error(
        "from tap {tap} to the next the reading does not rise: the part is not monotone there, or a reading was taken before it had settled; sweep again with more groups a point"
    )]
    NotRising {
        /// The lower of the two taps.
        tap: u16,
    },
    /// More taps than a model holds.
    #[error(
        "{found} taps were swept, and a trim model holds {MAX_TAP_OFFSETS}: sweep only the taps that the drift crosses"
    )]
    TooManyTaps {
        /// Taps swept.
        found: usize,
    },
}
