//! Where an instrument is, as people write it.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use crate::line::Line;
use crate::line::serial::SerialLine;
use crate::line::tcp::TcpLine;

/// The rate of a Modbus line where none is named: most controllers leave the factory with it.
pub const MODBUS_BAUD: u32 = 9600;
/// The rate of a supply's line where none is named.
pub const SCPI_BAUD: u32 = 9600;

/// What an instrument speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Protocol {
    /// Modbus over TCP.
    ModbusTcp,
    /// Modbus in RTU frames on a serial line.
    ModbusRtu,
    /// SCPI, lines of text.
    Scpi,
}

/// The way to an instrument.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Way {
    /// `HOST:PORT`.
    Tcp(String),
    /// A port's path, and baud.
    Serial(PathBuf, u32),
}

/// Where an instrument is, and what it speaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Address {
    /// What it speaks.
    pub protocol: Protocol,
    way: Way,
}

/// A text that names no instrument.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "'{0}' names no instrument: give modbus-tcp:HOST:PORT, modbus-rtu:PATH (or modbus-rtu:PATH@BAUD), scpi:HOST:PORT or scpi:PATH (or scpi:PATH@BAUD)"
)]
pub struct UnknownAddress(String);

impl FromStr for Address {
    type Err = UnknownAddress;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let unknown = || UnknownAddress(text.into());
        let (protocol, place) = text.split_once(':').ok_or_else(unknown)?;
        let (protocol, way) = match protocol {
            "modbus-tcp" => (Protocol::ModbusTcp, tcp(place)),
            "modbus-rtu" => (Protocol::ModbusRtu, serial(place, MODBUS_BAUD)),
            "scpi" => (Protocol::Scpi, tcp(place).or_else(|| serial(place, SCPI_BAUD))),
            _ => return Err(unknown()),
        };
        Ok(Self { protocol, way: way.ok_or_else(unknown)? })
    }
}

fn tcp(place: &str) -> Option<Way> {
    let (host, port) = place.rsplit_once(':')?;
    let is_sound = !host.is_empty() && port.parse::<u16>().is_ok_and(|port| port > 0);
    is_sound.then(|| Way::Tcp(place.into()))
}

fn serial(place: &str, baud: u32) -> Option<Way> {
    let with_baud = place.rsplit_once('@').and_then(|(path, baud)| Some((path, baud.parse().ok()?)));
    let (path, baud) = with_baud.unwrap_or((place, baud));
    (!path.is_empty() && baud > 0).then(|| Way::Serial(path.into(), baud))
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (protocol, baud) = match self.protocol {
            Protocol::ModbusTcp => ("modbus-tcp", MODBUS_BAUD),
            Protocol::ModbusRtu => ("modbus-rtu", MODBUS_BAUD),
            Protocol::Scpi => ("scpi", SCPI_BAUD),
        };
        match &self.way {
            Way::Tcp(address) => write!(f, "{protocol}:{address}"),
            Way::Serial(path, own) if *own == baud => write!(f, "{protocol}:{}", path.display()),
            Way::Serial(path, own) => write!(f, "{protocol}:{}@{own}", path.display()),
        }
    }
}

impl Address {
    /// The line to it; nothing is opened before it is needed.
    #[must_use]
    pub fn line(&self) -> Box<dyn Line> {
        match &self.way {
            Way::Tcp(address) => Box::new(TcpLine::new(address.clone())),
            Way::Serial(path, baud) => Box::new(SerialLine::new(path.clone(), *baud)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instrument_is_written_as_it_is_read() {
        for text in [
            "modbus-tcp:chamber.lab:502",
            "modbus-tcp:[::1]:502",
            "modbus-rtu:/dev/ttyUSB0",
            "modbus-rtu:/dev/ttyUSB0@19200",
            "scpi:10.0.0.7:5025",
            "scpi:/dev/ttyACM0@115200",
        ] {
            assert_eq!(text.parse::<Address>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn what_names_no_instrument_is_told_what_would() {
        for text in
            ["", "modbus", "modbus-tcp:", "modbus-tcp:host", "modbus-tcp:host:0", "modbus-rtu:", "visa:x", "scpi:"]
        {
            let error = text.parse::<Address>().unwrap_err().to_string();
            assert!(error.contains("modbus-tcp:HOST:PORT"), "{error}");
        }
    }
}
