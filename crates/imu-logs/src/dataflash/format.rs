//! Formats: where the fields of a message lie.

/// Bytes of a message's header.
pub(super) const HEADER_BYTES: usize = 3;

/// The type of the message that defines a format.
pub(super) const FORMAT_TYPE: u8 = 0x80;

/// Its bytes: header, type, length, name, letters, labels.
pub(super) const FORMAT_BYTES: usize = HEADER_BYTES + 1 + 1 + 4 + 16 + 64;

/// A kind of message that matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Parameter,
    Imu,
    Learning,
    Receiver,
}

/// A format.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Format {
    /// Bytes of the whole message, header and all.
    pub(super) length: usize,
    /// What it is, where it matters.
    pub(super) kind: Option<Kind>,
    /// The sensor that the name tells, as `IMU2` of old logs.
    pub(super) instance: u8,
    /// Label, letter, and place in the body.
    fields: Vec<(String, u8, usize)>,
}

impl Format {
    /// Reads the body of a definition; `None` for one that contradicts itself.
    pub(super) fn read(body: &[u8]) -> Option<(u8, Self)> {
        let ([kind, length], rest) = body.split_first_chunk::<2>()?;
        let length = usize::from(*length);
        let (name, letters, labels) = (text(rest.get(..4)?), rest.get(4..20)?, text(rest.get(20..84)?));
        let letters = letters.iter().copied().take_while(|letter| *letter != 0);
        let mut place = 0;
        let mut fields = Vec::new();
        for (label, letter) in labels.split(',').zip(letters) {
            fields.push((label.trim().to_owned(), letter, place));
            // Behind a letter that is not known, no place is.
            let Some(size) = size_of(letter) else { break };
            place += size;
        }
        if length < HEADER_BYTES || *kind == FORMAT_TYPE {
            return None;
        }
        let (matters, instance) = match name.as_str() {
            "PARM" => (Some(Kind::Parameter), 0),
            "IMU" => (Some(Kind::Imu), 0),
            "IMU2" => (Some(Kind::Imu), 1),
            "IMU3" => (Some(Kind::Imu), 2),
            "TCLR" => (Some(Kind::Learning), 0),
            "GPS" => (Some(Kind::Receiver), 0),
            _ => (None, 0),
        };
        // Of the others only the length is needed.
        let fields = if matters.is_some() { fields } else { Vec::new() };
        Some((*kind, Self { length, kind: matters, instance, fields }))
    }
}

/// Bytes of a field by its letter.
fn size_of(letter: u8) -> Option<usize> {
    Some(match letter {
        b'b' | b'B' | b'M' => 1,
        b'h' | b'H' | b'c' | b'C' | b'g' => 2,
        b'i' | b'I' | b'e' | b'E' | b'f' | b'L' | b'n' => 4,
        b'q' | b'Q' | b'd' => 8,
        b'N' => 16,
        b'a' | b'Z' => 64,
        _ => return None,
    })
}

/// The text before the first zero.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// A message's body by its format.
pub(super) struct Fields<'a> {
    pub(super) format: &'a Format,
    pub(super) body: &'a [u8],
}

impl Fields<'_> {
    fn bytes<const N: usize>(&self, letter: u8, place: usize, letters: &[u8]) -> Option<[u8; N]> {
        letters.contains(&letter).then(|| self.body.get(place..place + N)?.try_into().ok()).flatten()
    }

    fn field(&self, label: &str) -> Option<(u8, usize)> {
        self.format.fields.iter().find(|(own, ..)| own == label).map(|(_, letter, place)| (*letter, *place))
    }

    /// A number that is logged as a float or a whole number; NaN is one.
    pub(super) fn number(&self, label: &str) -> Option<f64> {
        let (letter, place) = self.field(label)?;
        if let Some(bytes) = self.bytes(letter, place, b"f") {
            return Some(f64::from(f32::from_le_bytes(bytes)));
        }
        if let Some(bytes) = self.bytes(letter, place, b"d") {
            return Some(f64::from_le_bytes(bytes));
        }
        let hundredths = if b"cCeE".contains(&letter) { 0.01 } else { 1.0 };
        let whole = match letter {
            b'I' | b'E' => f64::from(u32::from_le_bytes(self.bytes(letter, place, b"IE")?)),
            b'i' | b'e' => f64::from(i32::from_le_bytes(self.bytes(letter, place, b"ie")?)),
            b'H' | b'C' => f64::from(u16::from_le_bytes(self.bytes(letter, place, b"HC")?)),
            b'h' | b'c' => f64::from(i16::from_le_bytes(self.bytes(letter, place, b"hc")?)),
            b'B' | b'M' => f64::from(self.byte(label)?),
            _ => return None,
        };
        Some(hundredths * whole)
    }

    /// A small whole number.
    pub(super) fn byte(&self, label: &str) -> Option<u8> {
        let (letter, place) = self.field(label)?;
        self.bytes::<1>(letter, place, b"BM").map(|[byte]| byte)
    }

    /// A whole number of any size.
    pub(super) fn whole(&self, label: &str) -> Option<u64> {
        let (letter, place) = self.field(label)?;
        Some(match letter {
            b'Q' => u64::from_le_bytes(self.bytes(letter, place, b"Q")?),
            b'I' => u32::from_le_bytes(self.bytes(letter, place, b"I")?).into(),
            b'H' => u16::from_le_bytes(self.bytes(letter, place, b"H")?).into(),
            _ => self.byte(label)?.into(),
        })
    }

    /// A text.
    pub(super) fn text(&self, label: &str) -> Option<String> {
        let (letter, place) = self.field(label)?;
        let size = size_of(letter).filter(|_| b"nNZ".contains(&letter))?;
        self.body.get(place..place + size).map(text)
    }

    /// The time, microseconds; old logs have milliseconds. 0 where there is none.
    pub(super) fn time_us(&self) -> u64 {
        let milliseconds = || self.whole("TimeMS").map(|ms| ms.saturating_mul(1000));
        self.whole("TimeUS").or_else(milliseconds).unwrap_or(0)
    }
}
