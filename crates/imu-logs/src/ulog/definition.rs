//! Where a sensor's fields lie in its messages: formats and subscriptions.

use std::collections::HashMap;

use crate::SensorKind;

/// Formats that are kept, at most: those of the two topics that matter, and what a damaged log may name so again.
const MAX_TOPICS: usize = 64;

/// What is known of the messages so far.
#[derive(Debug, Default)]
pub(super) struct Definitions {
    layouts: HashMap<Vec<u8>, Layout>,
    /// By message id.
    topics: HashMap<u16, Topic>,
    /// How long the messages of each are.
    sizes: HashMap<u16, usize>,
}

/// Where the fields of a format lie, in bytes from the beginning of a message's body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    time: usize,
    device_id: Option<usize>,
    values: [usize; 3],
    temperature: Option<usize>,
    /// The body is as long as this at least.
    least: usize,
}

/// A subscription to a sensor's topic.
#[derive(Debug, Clone)]
pub(super) struct Topic {
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
        if Topic::kind_of(name).is_some()
            && let Some(layout) = Layout::of(fields)
        {
            self.layouts.insert(name.to_vec(), layout);
        }
        !name.is_empty()
    }

    /// Takes in a subscription: instance, message id, name; `false` where it is none.
    pub(super) fn subscribe(&mut self, body: &[u8]) -> bool {
        let [instance, low, high, name @ ..] = body else { return false };
        let id = u16::from_le_bytes([*low, *high]);
        if let Some((kind, layout)) = Topic::kind_of(name).zip(self.layouts.get(name))
            && self.topics.len() < MAX_TOPICS
        {
            self.topics.insert(id, Topic { kind, instance: *instance, number: None, layout: *layout });
        }
        true
    }

    /// The topic of a data message, if it is a sensor's.
    pub(super) fn topic_of(&mut self, body: &[u8]) -> Option<&mut Topic> {
        let id = u16::from_le_bytes([*body.first()?, *body.get(1)?]);
        let topic = self.topics.get_mut(&id)?;
        self.sizes.entry(id).or_insert(body.len());
        Some(topic)
    }

    /// Whether a data message of a known sensor, as long as those before it, may begin here.
    pub(super) fn begins_data(&self, bytes: &[u8]) -> bool {
        let [size_low, size_high, b'D', id_low, id_high, ..] = bytes else { return false };
        let size = usize::from(u16::from_le_bytes([*size_low, *size_high]));
        self.sizes.get(&u16::from_le_bytes([*id_low, *id_high])) == Some(&size)
    }
}

impl Layout {
    /// The layout by a format's fields, in their order; `None` where one that is needed is missing or of another type.
    fn of(fields: &[u8]) -> Option<Self> {
        let mut found: HashMap<&[u8], (usize, &[u8])> = HashMap::new();
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
        let place = |name: &str, wanted: &str| {
            found.get(name.as_bytes()).filter(|(_, kind)| *kind == wanted.as_bytes()).map(|(place, _)| *place)
        };
        let (time, x, y, z) =
            (place("timestamp", "uint64_t")?, place("x", "float")?, place("y", "float")?, place("z", "float")?);
        let (device_id, temperature) = (place("device_id", "uint32_t"), place("temperature", "float"));
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

impl Topic {
    /// The kind of sensor that a topic is of, by its name.
    fn kind_of(name: &[u8]) -> Option<SensorKind> {
        match name {
            b"sensor_gyro" => Some(SensorKind::Gyro),
            b"sensor_accel" => Some(SensorKind::Accelerometer),
            _ => None,
        }
    }

    /// The reading in a message's body; `None` where it is too short.
    pub(super) fn row(&self, body: &[u8]) -> Option<Row> {
        if body.len() < self.layout.least {
            return None;
        }
        let four = |place: usize| <[u8; 4]>::try_from(body.get(place..place + 4)?).ok();
        let float = |place: usize| four(place).map(|bytes| f64::from(f32::from_le_bytes(bytes)));
        let time = body.get(self.layout.time..self.layout.time + 8)?.try_into().ok()?;
        let [x, y, z] = self.layout.values;
        Some(Row {
            time_us: u64::from_le_bytes(time),
            device_id: self.layout.device_id.and_then(four).map_or(0, u32::from_le_bytes),
            temperature: self.layout.temperature.and_then(float).unwrap_or(f64::NAN),
            values: [float(x)?, float(y)?, float(z)?],
        })
    }
}
