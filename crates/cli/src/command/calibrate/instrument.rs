//! Who obeys at the bench.

use std::str::FromStr;

use zerorate_bench::remote::Address;

/// An instrument by who obeys.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Instrument {
    /// The simulated bench's.
    Simulated,
    /// A person, told what to do.
    Manual,
    /// The instrument itself.
    Remote(Address),
}

impl FromStr for Instrument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "simulated" => Ok(Self::Simulated),
            "manual" => Ok(Self::Manual),
            address => {
                address.parse().map(Self::Remote).map_err(|unknown| format!("{unknown}; or manual, or simulated"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instrument_is_somebody_or_an_address() {
        assert_eq!("manual".parse(), Ok(Instrument::Manual));
        assert!(matches!("modbus-tcp:host:502".parse(), Ok(Instrument::Remote(_))));
        let told = "gpib".parse::<Instrument>().unwrap_err();
        assert!(told.contains("modbus-tcp:HOST:PORT") && told.contains("or manual"), "{told}");
    }
}
