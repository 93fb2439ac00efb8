//! What a person at a virtual board can do, in words.

use std::str::FromStr;

use zerorate_core::units::{Axis, Celsius, Volts};
use zerorate_sim::Fault;

/// The orders, for help texts.
const KNOWN: &str = "chamber C, feed VOLTS, gyros, voltmeter, power, break \
                     stuck-x|stuck-y|frozen-x|frozen-y|torn-x|torn-y|jump-x|jump-y|saturated-x|saturated-y|overrun|no-scans|port|trim|memory|spi, \
                     byte-errors RATE, mend, status, quit";

/// What a person does at the bench of a virtual board.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    /// Sends the chamber somewhere.
    Chamber(Celsius),
    /// Puts the supply in the gyros' place.
    Feed(Volts),
    /// Puts the gyros back.
    Gyros,
    /// Reads a voltmeter at the gyros' outputs.
    Voltmeter,
    /// Switches gyros and board off and on.
    Power,
    /// Breaks something.
    Break(Fault),
    /// Damages so many of the line's bytes.
    ByteErrors(f64),
    /// Mends everything.
    Mend,
    /// Says how things are.
    Status,
    /// Ends the board.
    Quit,
}

impl FromStr for Order {
    type Err = String;

    fn from_str(line: &str) -> Result<Self, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite());
        let order = match words[..] {
            ["chamber", at] => number(at).map(|at| Self::Chamber(Celsius(at))),
            ["feed", volts] => number(volts).map(|volts| Self::Feed(Volts(volts))),
            ["gyros"] => Some(Self::Gyros),
            ["voltmeter"] => Some(Self::Voltmeter),
            ["power"] => Some(Self::Power),
            ["break", what] => fault(what).map(Self::Break),
            ["byte-errors", rate] => number(rate).filter(|rate| (0.0..0.5).contains(rate)).map(Self::ByteErrors),
            ["mend"] => Some(Self::Mend),
            ["status"] => Some(Self::Status),
            ["quit"] => Some(Self::Quit),
            _ => None,
        };
        order.ok_or_else(|| format!("unknown: '{}'. Orders: {KNOWN}", line.trim()))
    }
}

/// A contact that is loose for a second.
const fn jump(axis: Axis) -> Fault {
    Fault::TemperatureOff { axis, counts: -2000, scans: 333 }
}

fn fault(what: &str) -> Option<Fault> {
    match what {
        "stuck-x" => Some(Fault::StuckTemperature(Axis::X)),
        "stuck-y" => Some(Fault::StuckTemperature(Axis::Y)),
        "frozen-x" => Some(Fault::FrozenTemperature(Axis::X)),
        "frozen-y" => Some(Fault::FrozenTemperature(Axis::Y)),
        "saturated-x" => Some(Fault::SaturatedInput(Axis::X)),
        "saturated-y" => Some(Fault::SaturatedInput(Axis::Y)),
        "torn-x" => Some(Fault::TemperatureAt { axis: Axis::X, counts: 0 }),
        "torn-y" => Some(Fault::TemperatureAt { axis: Axis::Y, counts: 0 }),
        "jump-x" => Some(jump(Axis::X)),
        "jump-y" => Some(jump(Axis::Y)),
        "overrun" => Some(Fault::Overrun { sets: 3 }),
        "no-scans" => Some(Fault::NoScans),
        "port" => Some(Fault::PortSpi { transfers: 4 }),
        "trim" => Some(Fault::PotentiometerSpi { transfers: 4 }),
        "memory" => Some(Fault::WornMemory),
        "spi" => Some(Fault::DeadSpi),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_words_and_numbers() {
        assert_eq!("chamber -40".parse(), Ok(Order::Chamber(Celsius(-40.0))));
        assert_eq!("  feed 2.4998 ".parse(), Ok(Order::Feed(Volts(2.4998))));
        assert_eq!("break stuck-y".parse(), Ok(Order::Break(Fault::StuckTemperature(Axis::Y))));
        for wrong in ["chamber", "chamber warm", "feed inf", "byte-errors 2", "break", "reboot"] {
            assert!(wrong.parse::<Order>().unwrap_err().contains("voltmeter"), "{wrong}");
        }
    }
}
