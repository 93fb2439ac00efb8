//! ArduPilot's DataFlash (ardupilot.org, "DataFlash Logs"): gyros and accelerometers with their temperatures, as they were
//! before the autopilot corrected them, and UTC by the satellite receiver, message by message, in bounded memory.
//!
//! The crate ardupilot-binlog 0.2 streams too, but a format that says a length below three makes it panic, a half float
//! makes it lose every message of that format, and it does not tell what it passed over or that the file was cut. So the
//! messages that matter are read here.

mod format;
mod restore;
mod rotation;

use std::io::{self, Read, Seek};

use crate::streams::Streams;
use crate::window::{Damage, Window};
use crate::{Ending, Remark, Sensor, SensorKind, Sink};
use format::{FORMAT_BYTES, FORMAT_TYPE, Fields, Format, HEADER_BYTES, Kind};
use restore::Parameters;
pub use restore::temperature_parameters;

/// What every message starts with; its type follows.
pub(super) const MAGIC: [u8; 2] = [0xa3, 0x95];

/// What is read of a log.
const READ: [Kind; 4] = [Kind::Parameter, Kind::Imu, Kind::Learning, Kind::Receiver];

/// How much of a file is read for its parameters before its readings: they are logged while it begins.
const PARAMETER_BYTES: u64 = 16 << 20;

/// The beginning of GPS time, 6 January 1980, in seconds since 1970, and a GPS week.
const GPS_BEGINS_S: u64 = 315_964_800;
const WEEK_S: u64 = 7 * 86_400;

/// Seconds that GPS time is ahead of UTC since 2017, as the autopilot takes it too: an earlier log is told a second or two
/// early.
const LEAP_S: u64 = 18;

/// `Status` of a fix in space, from which on the autopilot believes the receiver's time.
const FIX_3D: u8 = 3;

/// Whether a file may be such a log: its first message defines a format.
pub(super) fn recognises(start: &[u8]) -> bool {
    matches!(start, [0xa3, 0x95, FORMAT_TYPE, ..])
}

/// Reads a log from its beginning. What is whole of a cut or damaged log is read.
///
/// # Errors
/// Where the file cannot be read.
pub(super) fn read(mut file: impl Read + Seek, sink: &mut dyn Sink) -> io::Result<Ending> {
    // The parameters that the log begins with may stand behind its first readings.
    let mut parameters = Parameters::default();
    let mut first = Reader::new(&mut file);
    while first.window.position() < PARAMETER_BYTES {
        match first.message(&[Kind::Parameter])? {
            Some((Message::Parameter(name, value), _)) => parameters.begin(&name, value),
            Some(_) => {}
            None => break,
        }
    }
    file.rewind()?;
    let mut reader = Reader::new(file);
    let mut streams = Streams::default();
    let mut means = 0;
    while let Some((message, time_us)) = reader.message(&READ)? {
        match message {
            Message::Parameter(name, value) => parameters.change(&name, value),
            Message::Imu { instance, temperature, gyro, accelerometer } => {
                for (kind, values) in [(SensorKind::Gyro, gyro), (SensorKind::Accelerometer, accelerometer)] {
                    let Some(restored) = parameters.restore(kind, instance, temperature, values) else { continue };
                    let sensor = Sensor { kind, instance, device_id: parameters.device_id(kind, instance) };
                    if let Some(number) = streams.number(sensor, sink) {
                        streams.push(number, time_us, temperature, restored, sink);
                    }
                }
            }
            Message::Learning { .. } => means += 1,
            Message::Clock { utc_us } => streams.set_clock(time_us, utc_us),
            Message::Other => {}
        }
    }
    // A log of the learning alone has no readings: its sums are means over half a degree each.
    let learning_only = streams.is_empty() && means > 0;
    if learning_only {
        read_learning(&mut reader, &parameters, &mut streams, sink)?;
    }
    let mut ending = streams.finish(sink);
    ending.remarks.extend(reader.damage.remarks());
    ending.remarks.extend(parameters.remarks());
    if learning_only {
        ending.remarks.push(Remark::LearningOnly { means });
    }
    Ok(ending)
}

/// Reads the log again for what the autopilot learned from.
fn read_learning<R: Read + Seek>(
    reader: &mut Reader<R>,
    parameters: &Parameters,
    streams: &mut Streams,
    sink: &mut dyn Sink,
) -> io::Result<()> {
    reader.restart()?;
    while let Some((message, time_us)) = reader.message(&[Kind::Learning])? {
        let Message::Learning { instance, kind, temperature, means } = message else { continue };
        let sensor = Sensor { kind, instance, device_id: parameters.device_id(kind, instance) };
        if let Some(number) = streams.number(sensor, sink) {
            streams.push(number, time_us, temperature, means, sink);
        }
    }
    Ok(())
}

/// A message that matters.
#[derive(Debug, Clone, PartialEq)]
enum Message {
    Parameter(String, f64),
    Imu {
        instance: u8,
        temperature: f64,
        gyro: [f64; 3],
        accelerometer: [f64; 3],
    },
    Learning {
        instance: u8,
        kind: SensorKind,
        temperature: f64,
        means: [f64; 3],
    },
    /// UTC by a satellite receiver, microseconds since 1970.
    Clock {
        utc_us: u64,
    },
    /// One that does not.
    Other,
}

struct Reader<R> {
    window: Window<R>,
    /// By type.
    formats: Vec<Option<Format>>,
    damage: Damage,
}

impl<R: Read> Reader<R> {
    fn new(file: R) -> Self {
        Self { window: Window::new(file), formats: vec![None; 256], damage: Damage::default() }
    }

    /// The next message with its time in microseconds; `None` at the end of the file. What is not of the kinds wanted is
    /// not decoded.
    fn message(&mut self, wanted: &[Kind]) -> io::Result<Option<(Message, u64)>> {
        loop {
            let position = self.window.position();
            let bytes = self.window.peek(HEADER_BYTES)?;
            if bytes.is_empty() {
                return Ok(None);
            }
            if bytes.len() < HEADER_BYTES {
                self.damage.cut_at = Some(position);
                return Ok(None);
            }
            let kind = bytes[2];
            let length = match (bytes.starts_with(&MAGIC), kind, &self.formats[usize::from(kind)]) {
                (true, FORMAT_TYPE, _) => FORMAT_BYTES,
                (true, _, Some(format)) => format.length,
                _ => {
                    self.seek()?;
                    continue;
                }
            };
            let bytes = self.window.peek(length)?;
            if bytes.len() < length {
                self.damage.cut_at = Some(position);
                return Ok(None);
            }
            let body = &bytes[HEADER_BYTES..length];
            let message = if kind == FORMAT_TYPE {
                if let Some((kind, format)) = Format::read(body) {
                    self.formats[usize::from(kind)] = Some(format);
                }
                None
            } else {
                let format = self.formats[usize::from(kind)].as_ref();
                format
                    .filter(|format| format.kind.is_some_and(|kind| wanted.contains(&kind)))
                    .map(|format| format.message(body))
            };
            self.window.pass(length);
            return Ok(Some(message.unwrap_or((Message::Other, 0))));
        }
    }

    /// Looks for the next place at which a message of a known format may begin.
    fn seek(&mut self) -> io::Result<()> {
        let formats = &self.formats;
        self.window.pass(1);
        let skipped = self.window.seek(HEADER_BYTES, |bytes| {
            bytes.starts_with(&MAGIC)
                && bytes.get(2).is_some_and(|kind| *kind == FORMAT_TYPE || formats[usize::from(*kind)].is_some())
        })?;
        self.damage.skipped += skipped + 1;
        Ok(())
    }
}

impl<R: Read + Seek> Reader<R> {
    fn restart(&mut self) -> io::Result<()> {
        self.window.rewind()?;
        self.damage = Damage::default();
        Ok(())
    }
}

impl Format {
    /// A message of a kind that matters, by its fields; [`Message::Other`] where one that is needed is missing.
    fn message(&self, body: &[u8]) -> (Message, u64) {
        let fields = Fields { format: self, body };
        let time_us = fields.time_us();
        let message = match self.kind {
            Some(Kind::Parameter) => parameter(&fields),
            Some(Kind::Imu) => imu(&fields, self.instance),
            Some(Kind::Learning) => learning(&fields),
            Some(Kind::Receiver) => clock(&fields),
            None => None,
        };
        (message.unwrap_or(Message::Other), time_us)
    }
}

fn parameter(fields: &Fields<'_>) -> Option<Message> {
    Some(Message::Parameter(fields.text("Name")?, fields.number("Value")?))
}

fn imu(fields: &Fields<'_>, instance: u8) -> Option<Message> {
    let three = |names: [&str; 3]| Some([fields.number(names[0])?, fields.number(names[1])?, fields.number(names[2])?]);
    Some(Message::Imu {
        instance: fields.byte("I").unwrap_or(instance),
        temperature: fields.number("T").or_else(|| fields.number("Temp")).unwrap_or(f64::NAN),
        gyro: three(["GyrX", "GyrY", "GyrZ"])?,
        accelerometer: three(["AccX", "AccY", "AccZ"])?,
    })
}

/// The week of GPS time, and the milliseconds in it.
fn clock(fields: &Fields<'_>) -> Option<Message> {
    fields.byte("Status").filter(|status| *status >= FIX_3D)?;
    let [week, ms] = [fields.whole("GWk")?, fields.whole("GMS")?];
    let gps_ms = week.checked_mul(1000 * WEEK_S)?.checked_add(ms)?;
    let utc_ms = gps_ms.checked_add(1000 * (GPS_BEGINS_S - LEAP_S))?;
    Some(Message::Clock { utc_us: utc_ms.checked_mul(1000)? })
}

/// The autopilot logs sums and how many readings they are of.
fn learning(fields: &Fields<'_>) -> Option<Message> {
    let samples = fields.number("NSamp").filter(|samples| *samples > 0.0)?;
    let mean = |name| fields.number(name).map(|sum| sum / samples);
    let kind = match fields.byte("SType")? {
        0 => SensorKind::Accelerometer,
        1 => SensorKind::Gyro,
        _ => return None,
    };
    Some(Message::Learning {
        instance: fields.byte("I")?,
        kind,
        temperature: fields.number("Temp")?,
        means: [mean("X")?, mean("Y")?, mean("Z")?],
    })
}

#[cfg(test)]
mod tests;
