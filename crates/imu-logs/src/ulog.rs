//! PX4's ULog, by its specification (docs.px4.io, "ULog File Format", version 1): gyros and accelerometers with their
//! temperatures, and UTC by the satellite receiver, message by message, in bounded memory.
//!
//! The crate px4-ulog 0.6 streams too, but a log of thirty bytes makes it panic (a subscription or a parameter shorter than
//! its own header), nested formats of a few hundred bytes keep it busy for ever, and of a damaged log it gives only what
//! is before the damage. So the few messages that matter are read here, over the same definitions.

mod definition;

use std::io::{self, Read};

use crate::streams::Streams;
use crate::window::{Damage, Window};
use crate::{Ending, Remark, Sensor, Sink};
use definition::{Definitions, Topic};

/// What every ULog starts with; a byte with the version follows, and the time at which logging began.
pub(super) const MAGIC: [u8; 7] = [0x55, 0x4c, 0x6f, 0x67, 0x01, 0x12, 0x35];

/// Bytes of the file's header.
const HEADER_BYTES: usize = 16;

/// Bytes of a message's header: the size of its body, and its kind.
const MESSAGE_HEADER_BYTES: usize = 3;

/// The synchronisation message, by which a reader finds its way after damage.
const SYNC: [u8; 11] = [0x08, 0x00, b'S', 0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];

/// The flag of a log to which a crash dump was appended: the only incompatible one that version 1 has.
const DATA_APPENDED: u8 = 1;

/// Reads a log from its beginning. What is whole of a cut or damaged log is read.
///
/// # Errors
/// Where the file cannot be read.
pub(super) fn read(file: impl Read, sink: &mut dyn Sink) -> io::Result<Ending> {
    let mut reader = Reader {
        window: Window::new(file),
        definitions: Definitions::default(),
        streams: Streams::default(),
        damage: Damage::default(),
        appended: Vec::new(),
        unknown_flags: false,
        lost_ms: 0,
        dropouts: 0,
    };
    while reader.message(sink)? {}
    let mut ending = reader.streams.finish(sink);
    ending.remarks.extend(reader.damage.remarks());
    if reader.dropouts > 0 {
        ending.remarks.push(Remark::Dropouts { times: reader.dropouts, lost_s: reader.lost_ms as f64 / 1e3 });
    }
    if reader.unknown_flags {
        ending.remarks.push(Remark::NewerFormat);
    }
    Ok(ending)
}

struct Reader<R> {
    window: Window<R>,
    definitions: Definitions,
    streams: Streams,
    damage: Damage,
    /// Where data were appended, in order; before each a message may be cut.
    appended: Vec<u64>,
    unknown_flags: bool,
    lost_ms: u64,
    dropouts: u64,
}

impl<R: Read> Reader<R> {
    /// Reads one message; `false` at the end of the file.
    fn message(&mut self, sink: &mut dyn Sink) -> io::Result<bool> {
        let position = self.window.position();
        let bytes = self.window.peek(HEADER_BYTES)?;
        if bytes.is_empty() {
            return Ok(false);
        }
        if bytes.starts_with(&MAGIC) {
            // The first header, or that of another log after the end of one.
            let header = bytes.len().min(HEADER_BYTES);
            self.definitions = Definitions::default();
            self.appended.clear();
            self.window.pass(header);
            return Ok(true);
        }
        if bytes.len() < MESSAGE_HEADER_BYTES {
            return Ok(self.cut(position));
        }
        let length = MESSAGE_HEADER_BYTES + usize::from(u16::from_le_bytes([bytes[0], bytes[1]]));
        let kind = bytes[2];
        if let Some(appended) = self.appended.iter().copied().find(|appended| *appended > position)
            && appended < position + length as u64
        {
            // The message was cut when the dump was appended.
            self.window.pass(usize::try_from(appended - position).unwrap_or(usize::MAX));
            return Ok(true);
        }
        if !kind.is_ascii_uppercase() {
            return self.seek();
        }
        let bytes = self.window.peek(length)?;
        if bytes.len() < length {
            return Ok(self.cut(position));
        }
        let body = &bytes[MESSAGE_HEADER_BYTES..length];
        let sound = match kind {
            b'D' => {
                data(body, &mut self.definitions, &mut self.streams, sink);
                true
            }
            b'F' => self.definitions.format(body),
            b'A' => self.definitions.subscribe(body),
            b'B' => match flags(body) {
                Some((appended, known)) => {
                    self.appended = appended;
                    self.unknown_flags |= !known;
                    true
                }
                None => false,
            },
            b'O' if body.len() >= 2 => {
                self.dropouts += 1;
                self.lost_ms += u64::from(u16::from_le_bytes([body[0], body[1]]));
                true
            }
            // What a reader does not know it passes over.
            _ => true,
        };
        if !sound {
            self.damage.skipped += length as u64;
        }
        self.window.pass(length);
        Ok(true)
    }

    /// The file ends in the middle of a message.
    fn cut(&mut self, position: u64) -> bool {
        self.damage.cut_at = Some(position);
        false
    }

    /// Looks for the next place at which a message certainly begins.
    fn seek(&mut self) -> io::Result<bool> {
        let definitions = &self.definitions;
        // Not from here: this is no message.
        self.window.pass(1);
        let skipped = self.window.seek(HEADER_BYTES, |bytes| {
            bytes.starts_with(&MAGIC) || bytes.starts_with(&SYNC) || definitions.begins_data(bytes)
        })?;
        self.damage.skipped += skipped + 1;
        Ok(true)
    }
}

/// The places of appended data, and whether all flags are known.
fn flags(body: &[u8]) -> Option<(Vec<u64>, bool)> {
    // The compatible flags come first, and change nothing for a reader.
    let (incompatible, rest) = body.get(8..)?.split_at_checked(8)?;
    let known = incompatible[0] & !DATA_APPENDED == 0 && incompatible[1..].iter().all(|flag| *flag == 0);
    let appended = rest.chunks_exact(8).take(3).filter_map(|bytes| Some(u64::from_le_bytes(bytes.try_into().ok()?)));
    Some((appended.filter(|place| *place > 0 && incompatible[0] & DATA_APPENDED != 0).collect(), known))
}

/// Takes in a row of a sensor, or a receiver's time; what is of another topic is passed over.
fn data(body: &[u8], definitions: &mut Definitions, streams: &mut Streams, sink: &mut dyn Sink) {
    let topic = match definitions.topic_of(body) {
        Some(Topic::Sensor(topic)) => topic,
        Some(Topic::Receiver(layout)) => {
            layout.times(body).into_iter().for_each(|[time_us, utc_us]| streams.set_clock(time_us, utc_us));
            return;
        }
        None => return,
    };
    let Some(row) = topic.row(body) else { return };
    if topic.number.is_none_or(|(_, device_id)| device_id != row.device_id) {
        let sensor = Sensor {
            kind: topic.kind,
            instance: topic.instance,
            device_id: (row.device_id != 0).then_some(row.device_id),
        };
        topic.number = Some((streams.number(sensor, sink), row.device_id));
    }
    if let Some((Some(number), _)) = topic.number {
        streams.push(number, row.time_us, row.temperature, row.values, sink);
    }
}

#[cfg(test)]
mod tests;
