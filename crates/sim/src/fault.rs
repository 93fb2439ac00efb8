//! What can be broken on purpose.

use zerorate_core::units::Axis;

/// A fault of the bench, for [`crate::Plant::inject`]. Those that count mend themselves when they have happened so often.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// An axis's temperature channel repeats its last sample.
    StuckTemperature(Axis),
    /// An axis's temperature sensor stands still, and the converter's last bit goes on moving.
    FrozenTemperature(Axis),
    /// An axis's temperature channel is off by so many counts, for so many passes: a loose contact, a glitch.
    TemperatureOff {
        /// The axis.
        axis: Axis,
        /// By how much, counts; the reading stays within the converter.
        counts: i32,
        /// For how many passes; without oversampling each is a scan.
        scans: u32,
    },
    /// An axis's temperature channel reads one and the same: 0 when its sensor is torn off, say.
    TemperatureAt {
        /// The axis.
        axis: Axis,
        /// The reading, counts.
        counts: u16,
    },
    /// An axis's amplifier stands at its upper rail: the zero-rate channel reads 16 383.
    SaturatedInput(Axis),
    /// Every SPI transfer fails with [`crate::BusFault`].
    DeadSpi,
    /// The next transfers with the acquisition port fail.
    PortSpi {
        /// How many.
        transfers: u32,
    },
    /// The acquisition port's output stays low in the next transfers: what is read is zeros.
    MutePort {
        /// How many.
        transfers: u32,
    },
    /// The next transfers with the potentiometer fail: it does not hear them.
    PotentiometerSpi {
        /// How many.
        transfers: u32,
    },
    /// The potentiometer's non-volatile registers are worn out: a store leaves what they held.
    WornMemory,
    /// The processor is late: so many sets go by before it looks at data ready again.
    Overrun {
        /// How many.
        sets: u32,
    },
    /// The acquisition port's clock has stopped: no scans are taken though it was told to run.
    NoScans,
}

/// The buses that can be broken one by one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Bus {
    Port,
    Potentiometer,
    Converter,
}

impl Fault {
    /// What is left of it to happen, where it counts.
    fn left(&mut self) -> Option<&mut u32> {
        match self {
            Self::TemperatureOff { scans: left, .. }
            | Self::PortSpi { transfers: left }
            | Self::MutePort { transfers: left }
            | Self::PotentiometerSpi { transfers: left }
            | Self::Overrun { sets: left } => Some(left),
            _ => None,
        }
    }

    /// Whether it breaks a transfer on a bus.
    const fn breaks(self, bus: Bus) -> bool {
        match self {
            Self::DeadSpi => true,
            Self::PortSpi { .. } => matches!(bus, Bus::Port),
            Self::PotentiometerSpi { .. } => matches!(bus, Bus::Potentiometer),
            _ => false,
        }
    }
}

/// The faults that are in force.
#[derive(Debug, Clone, Default)]
pub(crate) struct Faults(Vec<Fault>);

impl Faults {
    pub(crate) fn push(&mut self, fault: Fault) {
        self.0.push(fault);
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    pub(crate) fn contains(&self, fault: Fault) -> bool {
        self.0.contains(&fault)
    }

    /// Lets the first fault that is asked for happen once more; `false` if there is none in force.
    fn happens(&mut self, is_asked: impl Fn(Fault) -> bool) -> bool {
        let Some(index) = self.0.iter().position(|&fault| is_asked(fault)) else { return false };
        let Some(left) = self.0[index].left() else { return true };
        let happens = *left > 0;
        *left = left.saturating_sub(1);
        if *left == 0 {
            self.0.remove(index);
        }
        happens
    }

    pub(crate) fn break_transfer(&mut self, bus: Bus) -> bool {
        self.happens(|fault| fault.breaks(bus))
    }

    pub(crate) fn mutes_transfer(&mut self, bus: Bus) -> bool {
        matches!(bus, Bus::Port) && self.happens(|fault| matches!(fault, Fault::MutePort { .. }))
    }

    pub(crate) fn lets_a_set_go_by(&mut self) -> bool {
        self.happens(|fault| matches!(fault, Fault::Overrun { .. }))
    }

    /// What becomes of an axis's temperature reading.
    pub(crate) fn temperature(&mut self, axis: Axis, reading: u16) -> u16 {
        let mut reading = i32::from(reading);
        for fault in &self.0 {
            match *fault {
                Fault::TemperatureOff { axis: of, counts, .. } if of == axis => reading += counts,
                Fault::TemperatureAt { axis: of, counts } if of == axis => reading = i32::from(counts),
                _ => {}
            }
        }
        self.happens(|fault| matches!(fault, Fault::TemperatureOff { axis: of, .. } if of == axis));
        u16::try_from(reading.clamp(0, 16_383)).unwrap_or(0)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_counts_mends_itself_and_the_rest_stays() {
        let mut faults = Faults::default();
        faults.push(Fault::PotentiometerSpi { transfers: 2 });
        faults.push(Fault::TemperatureOff { axis: Axis::X, counts: -20_000, scans: 1 });
        faults.push(Fault::TemperatureAt { axis: Axis::Y, counts: 7 });
        assert!(!faults.break_transfer(Bus::Port) && !faults.lets_a_set_go_by());
        let breaks: Vec<bool> = (0..3).map(|_| faults.break_transfer(Bus::Potentiometer)).collect();
        assert_eq!(breaks, [true, true, false]);
        assert_eq!([faults.temperature(Axis::X, 9000), faults.temperature(Axis::X, 9000)], [0, 9000]);
        assert_eq!([faults.temperature(Axis::Y, 9000), faults.temperature(Axis::Y, 9000)], [7, 7]);
        faults.push(Fault::DeadSpi);
        assert!((0..5).all(|_| faults.break_transfer(Bus::Converter)));
    }
}
