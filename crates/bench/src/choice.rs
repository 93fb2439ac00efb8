//! Which device a command speaks to, as people write it.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use crate::client::DeviceClient;
use crate::link::{Link, LinkError, serial, tcp};

/// A device by where it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DeviceChoice {
    /// The application of `zerorate-device`, running in this program against the simulated bench.
    Native,
    /// The firmware on an emulated board, against the simulated bench.
    Emulated,
    /// A board on a serial line: the port's path, and baud.
    Serial(PathBuf, u32),
    /// A board behind a TCP socket: host and port.
    Tcp(String),
}

impl DeviceChoice {
    /// Whether time on it passes by itself: a board, or what stands in for one.
    #[must_use]
    pub const fn is_real(&self) -> bool {
        matches!(self, Self::Serial(..) | Self::Tcp(_))
    }

    /// Opens the line to a real device; `None` for a simulated one, which has no line before its bench is built.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn open(&self) -> Result<Option<DeviceClient>, LinkError> {
        let choice = self.clone();
        if !self.is_real() {
            return Ok(None);
        }
        let mut client = DeviceClient::new(choice.line()?);
        client.reopen_with(Box::new(move || choice.line()));
        Ok(Some(client))
    }

    /// The line that a board's scans go out on; a serial port at that line's rate, unless another than the host's is named.
    pub(crate) fn scan_line(&self) -> Result<Box<dyn Link>, LinkError> {
        match self {
            Self::Serial(path, serial::BAUD) => serial::open(path, serial::SCAN_BAUD),
            other => other.line(),
        }
    }

    fn line(&self) -> Result<Box<dyn Link>, LinkError> {
        match self {
            Self::Serial(path, baud) => serial::open(path, *baud),
            Self::Tcp(address) => tcp::open(address),
            Self::Native | Self::Emulated => Err(LinkError::NotOpened {
                line: self.to_string(),
                reason: "a simulated device has no line of its own".into(),
                remedy: "name a port, as serial:/dev/ttyUSB0",
            }),
        }
    }
}

impl fmt::Display for DeviceChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Native => f.write_str("native"),
            Self::Emulated => f.write_str("emulated"),
            Self::Serial(path, serial::BAUD) => write!(f, "serial:{}", path.display()),
            Self::Serial(path, baud) => write!(f, "serial:{}@{baud}", path.display()),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
        }
    }
}

/// A text that names no device.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' names no device: give serial:PATH (or serial:PATH@BAUD), tcp:HOST:PORT, emulated or native")]
pub struct UnknownDevice(String);

impl FromStr for DeviceChoice {
    type Err = UnknownDevice;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let unknown = || UnknownDevice(text.into());
        match text.split_once(':') {
            None if text == "native" => Ok(Self::Native),
            None if text == "emulated" => Ok(Self::Emulated),
            Some(("serial", port)) if !port.is_empty() => {
                let with_baud = port.rsplit_once('@').and_then(|(path, baud)| Some((path, baud.parse().ok()?)));
                let (path, baud) = with_baud.unwrap_or((port, serial::BAUD));
                Ok(Self::Serial(path.into(), baud))
            }
            Some(("tcp", address)) => {
                let (host, port) = address.rsplit_once(':').ok_or_else(unknown)?;
                let sound = !host.is_empty() && port.parse::<u16>().is_ok_and(|port| port > 0);
                if sound { Ok(Self::Tcp(address.into())) } else { Err(unknown()) }
            }
            _ => Err(unknown()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_is_written_as_it_is_read() {
        for text in ["native", "emulated", "serial:/dev/ttyUSB0", "serial:/dev/ttyACM1@921600", "tcp:[::1]:5555"] {
            assert_eq!(text.parse::<DeviceChoice>().unwrap().to_string(), text);
        }
        assert_eq!("serial:COM3".parse(), Ok(DeviceChoice::Serial("COM3".into(), 115_200)));
        assert_eq!("serial:/dev/board@home".parse(), Ok(DeviceChoice::Serial("/dev/board@home".into(), 115_200)));
    }

    #[test]
    fn what_names_no_device_is_told_what_would() {
        for text in
            ["", "usb", "serial:", "tcp:", "tcp:host", "tcp::5555", "tcp:host:port", "tcp:host:0", "/dev/ttyUSB0"]
        {
            let error = text.parse::<DeviceChoice>().unwrap_err().to_string();
            assert!(error.contains("serial:PATH"), "{error}");
        }
    }
}
