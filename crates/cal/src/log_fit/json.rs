//! The JSON that `zerorate fit --json` prints.

use serde::ser::{Serialize, SerializeMap, SerializeStruct, Serializer};

use super::{AxisFit, AxisVerdict, LogFit};

/// The schema's version.
const SCHEMA: u32 = 1;

impl Serialize for LogFit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("LogFit", 6)?;
        fields.serialize_field("schema", &SCHEMA)?;
        fields.serialize_field("source", &self.source)?;
        fields.serialize_field("verdict", &self.judgement.verdict)?;
        fields.serialize_field("reasons", &self.judgement.reasons)?;
        fields.serialize_field("axes", &Axes(&self.axes))?;
        fields.serialize_field("verdicts", &Verdicts(&self.verdicts))?;
        fields.end()
    }
}

/// The axes by name, in the order of the columns.
struct Axes<'a>(&'a [AxisFit]);

impl Serialize for Axes<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for axis in self.0 {
            map.serialize_entry(&axis.name, axis)?;
        }
        map.end()
    }
}

/// The verdict on each axis by name, of those rejected too.
struct Verdicts<'a>(&'a [AxisVerdict]);

impl Serialize for Verdicts<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for axis in self.0 {
            map.serialize_entry(&axis.name, &axis.judgement.verdict)?;
        }
        map.end()
    }
}

impl Serialize for AxisFit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("AxisFit", 11)?;
        if let Some(sensor) = &self.sensor {
            fields.serialize_field("sensor", sensor)?;
        }
        if let Some(reference) = &self.reference_temperature {
            fields.serialize_field("reference_temperature", reference)?;
        }
        fields.serialize_field("model", &self.choice.model.to_string())?;
        fields.serialize_field("raw_coefficients", &self.choice.solution.raw_coefficients())?;
        fields.serialize_field("rate_unit", &self.rate_unit)?;
        fields.serialize_field("temperature_unit", &self.temperature_unit)?;
        fields.serialize_field("temperature", &[self.drift.valid.min(), self.drift.valid.max()])?;
        fields.serialize_field("in_sample", &self.in_sample)?;
        fields.serialize_field("held_out", &self.held_out)?;
        fields.serialize_field("samples_used", &self.samples_used)?;
        fields.serialize_field("samples_rejected", &self.samples_rejected)?;
        fields.end()
    }
}
