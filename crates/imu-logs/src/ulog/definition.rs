//! Where the fields of a sensor and of a satellite receiver lie in their messages: formats and subscriptions.

use std::collections::HashMap;

use crate::SensorKind;

/// Formats that are kept, at most: those of the four topics that matter, and what a damaged log may name so again.
const MAX_TOPICS: usize = 64;

/// What is known of the messages so far.
#[derive(Debug, Default)]
pub(super) struct Definitions {
    formats: HashMap<Vec<u8>, Format>,
    /// By message id.
    topics: HashMap<u16, Topic>,
    /// How long the messages of each are.
    sizes: HashMap<u16, usize>,
}

/// A format that matters.
#[derive(Debug, Clone, Copy)]
enum Format {
    Sensor(SensorKind, Layout),
    Receiver(ReceiverLayout),
}

/// Where a sensor's fields lie, in bytes from the beginning of a message's body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    time: usize,
    device_id: Option<usize>,
    values: [usize; 3],
    temperature: Option<usize>,
    /// The body is as long as this at least.
    least: usize,
}

/// Where a satellite receiver's times lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ReceiverLayout {
    time: usize,
    utc: usize,
}

/// A subscription to a topic that matters.
#[derive(Debug, Clone)]
pub(super) enum Topic {
    Sensor(SensorTopic),
    Receiver(ReceiverLayout),
}

/// A subscription to a sensor's topic.
#[derive(Debug, Clone)]
pub(super) struct SensorTopic {
    pub(super) kind: SensorKind,
    pub(super) instance: u8,
    /// The number of the sensor's stream, if it has one, for the device id of the last row.
    pub(super) number: Option<(Option<usize>, u32)>,
    layout: Layout,
}

/// One reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Row {
    pub(super) time_us: u64,
    /// 0 where the log has none.
    pub(super) device_id: u32,
    pub(super) temperature: f64,
    pub(super) values: [f64; 3],
}

impl Definitions {
    /// Takes in a format, `name:type field;type field;...`; `false` where it is none.
    pub(super) fn format(&mut self, body: &[u8]) -> bool {
        let Some(colon) = body.iter().position(|byte| *byte == b':') else { return false };
        let (name, fields) = (&body[..colon], &body[colon + 1..]);
        if let Some(format) = Format::of(name, fields) {
            self.formats.insert(name.to_vec(), format);
        }
        !name.is_empty()
    }

    /// Takes in a subscription: instance, message id, name; `false` where it is none.
    pub(super) fn subscribe(&mut self, body: &[u8]) -> bool {
        let [instance, low, high, name @ ..] = body else { return false };
        let id = u16::from_le_bytes([*low, *high]);
        if let Some(format) = self.formats.get(name)
            && self.topics.len() < MAX_TOPICS
        {
            let topic = match *format {
                Format::Sensor(kind, layout) => {
                    Topic::Sensor(SensorTopic { kind, instance: *instance, number: None, layout })
                }
                Format::Receiver(layout) => Topic::Receiver(layout),
            };
            self.topics.insert(id, topic);
        }
        true
    }

    /// The topic of a data message, if it matters.
    pub(super) fn topic_of(&mut self, body: &[u8]) -> Option<&mut Topic> {
        let id = u16::from_le_bytes([*body.first()?, *body.get(1)?]);
        let topic = self.topics.get_mut(&id)?;
        self.sizes.entry(id).or_insert(body.len());
        Some(topic)
    }

    /// Whether a data message of a known topic, as long as those before it, may begin here.
    pub(super) fn begins_data(&self, bytes: &[u8]) -> bool {
        let [size_low, size_high, b'D', id_low, id_high, ..] = bytes else { return false };
        let size = usize::from(u16::from_le_bytes([*size_low, *size_high]));
        self.sizes.get(&u16::from_le_bytes([*id_low, *id_high])) == Some(&size)
    }
}

/// A format's fields by name: place and type.
struct Fields<'a>(HashMap<&'a [u8], (usize, &'a [u8])>);

impl<'a> Fields<'a> {
    /// The fields in their order; `None` where a message could not hold them.
    fn of(fields: &'a [u8]) -> Option<Self> {
        let mut found = HashMap::new();
        // The message id comes first.
        let mut offset = 2_usize;
        for field in fields.split(|byte| *byte == b';') {
            let Some(space) = field.iter().position(|byte| *byte == b' ') else { continue };
            let (kind, name) = (&field[..space], &field[space + 1..]);
            found.insert(name, (offset, kind));
            // After a type that is not known, no place is.
            let Some(size) = size_of(kind) else { break };
            offset = offset.checked_add(size).filter(|end| *end <= usize::from(u16::MAX))?;
        }
        Some(Self(found))
    }

    /// The place of a field of a type.
    fn place(&self, name: &str, wanted: &str) -> Option<usize> {
        self.0.get(name.as_bytes()).filter(|(_, kind)| *kind == wanted.as_bytes()).map(|(place, _)| *place)
    }
}

impl Format {
    /// The format of a topic that matters; `None` for another, and where a field that is needed is missing or of another
    /// type.
    fn of(name: &[u8], fields: &[u8]) -> Option<Self> {
        let sensor = |kind| Some(Self::Sensor(kind, Layout::of(&Fields::of(fields)?)?));
        match name {
            b"sensor_gyro" => sensor(SensorKind::Gyro),
            b"sensor_accel" => sensor(SensorKind::Accelerometer),
            // What the receiver says, and what the estimator took of one or more; older logs have only the second.
            b"sensor_gps" | b"vehicle_gps_position" => {
                let fields = Fields::of(fields)?;
                let place = |name| fields.place(name, "uint64_t");
                Some(Self::Receiver(ReceiverLayout { time: place("timestamp")?, utc: place("time_utc_usec")? }))
            }
            _ => None,
        }
    }
}

impl Layout {
    fn of(fields: &Fields<'_>) -> Option<Self> {
        let (time, x, y, z) = (
            fields.place("timestamp", "uint64_t")?,
            fields.place("x", "float")?,
            fields.place("y", "float")?,
            fields.place("z", "float")?,
        );
        let (device_id, temperature) = (fields.place("device_id", "uint32_t"), fields.place("temperature", "float"));
        let ends = [
            Some(time + 8),
            Some(x + 4),
            Some(y + 4),
            Some(z + 4),
            device_id.map(|p| p + 4),
            temperature.map(|p| p + 4),
        ];
        let least = ends.into_iter().flatten().max()?;
        Some(Self { time, device_id, values: [x, y, z], temperature, least })
    }
}

/// Bytes of a field's type, `float` or `float[3]`; `None` for one that is a format itself.
fn size_of(kind: &[u8]) -> Option<usize> {
    let (base, count) = match kind.iter().position(|byte| *byte == b'[') {
        Some(bracket) => {
            let count = std::str::from_utf8(kind[bracket + 1..].strip_suffix(b"]")?).ok()?;
            (&kind[..bracket], count.parse::<usize>().ok()?)
        }
        None => (kind, 1),
    };
    let size: usize = match base {
        b"int8_t" | b"uint8_t" | b"bool" | b"char" => 1,
        b"int16_t" | b"uint16_t" => 2,
        b"int32_t" | b"uint32_t" | b"float" => 4,
        b"int64_t" | b"uint64_t" | b"double" => 8,
        _ => return None,
    };
    size.checked_mul(count)
}

impl ReceiverLayout {
    /// The log's time and UTC since 1970, microseconds, in a message's body; `None` where it is too short.
    pub(super) fn times(&self, body: &[u8]) -> Option<[u64; 2]> {
        Some([eight(body, self.time)?, eight(body, self.utc)?])
    }
}

fn eight(body: &[u8], place: usize) -> Option<u64> {
    body.get(place..place + 8)?.try_into().ok().map(u64::from_le_bytes)
}

impl SensorTopic {
    /// The reading in a message's body; `None` where it is too short.
    pub(super) fn row(&self, body: &[u8]) -> Option<Row> {
        if body.len() < self.layout.least {
            return None;
        }
        let four = |place: usize| <[u8; 4]>::try_from(body.get(place..place + 4)?).ok();
        let float = |place: usize| four(place).map(|bytes| f64::from(f32::from_le_bytes(bytes)));
        let [x, y, z] = self.layout.values;
        Some(Row {
            time_us: eight(body, self.layout.time)?,
            device_id: self.layout.device_id.and_then(four).map_or(0, u32::from_le_bytes),
            temperature: self.layout.temperature.and_then(float).unwrap_or(f64::NAN),
            values: [float(x)?, float(y)?, float(z)?],
        })
    }
}
