//! What the plant knows of itself without noise. Only reports see it, never a fit.

/// The noise-free means of one set of scans.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// The set's number, as the acquisition port counts; when the processor drives the A/D, the number of earlier takes.
    pub set: u32,
    /// Scans in it.
    pub scans: u32,
    /// The chamber's air in degrees C, ripple included.
    pub chamber_c: f64,
    /// The chamber's set point at the end of the set, in degrees C.
    pub chamber_set_c: f64,
    /// X and Y.
    pub axes: [AxisTruth; 2],
}

/// One axis in a [`Truth`]. A reading is `drift + wiper + rotation + noise`.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisTruth {
    /// The temperature channel as a converter without steps or noise reads it, in counts: the mean that a group of
    /// samples tends to.
    pub temperature_counts: f64,
    /// The reading at rest with the wiper at N0, in counts: null with lag, gradient and this power-up's offset (or the fine
    /// supply), circuit, low-pass and converter, without noise, flicker and random walk.
    pub drift_counts: f64,
    /// What the actual wiper adds to that, behind the low-pass, in counts.
    pub wiper_counts: f64,
    /// What the platform's turning adds to that, behind the low-pass, in counts.
    pub rotation_counts: f64,
    /// The package in degrees C: where the temperature sensor is.
    pub package_c: f64,
    /// The die in degrees C: where the drift is.
    pub die_c: f64,
}

/// Sums on the way to a [`Truth`].
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sums {
    pub(crate) scans: u32,
    pub(crate) chamber_c: f64,
    pub(crate) axes: [AxisSums; 2],
}

/// One axis of [`Sums`].
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct AxisSums {
    pub(crate) package_c: f64,
    pub(crate) die_c: f64,
    /// The noise-free voltages behind the low-pass: at N0, with the actual wiper, turning.
    pub(crate) signals_v: [f64; 3],
}
