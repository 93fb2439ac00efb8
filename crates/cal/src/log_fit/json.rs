//! The JSON that `zerorate fit --json` prints.

use serde::ser::{Serialize, SerializeMap, SerializeStruct, Serializer};

use super::{AxisFit, AxisVerdict, LogFit};
use crate::calibration::CandidateStatistics;

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
        let mut fields = serializer.serialize_struct("AxisFit", 14)?;
        if let Some(sensor) = &self.sensor {
            fields.serialize_field("sensor", sensor)?;
        }
        if let Some(reference) = &self.reference_temperature {
            fields.serialize_field("reference_temperature", reference)?;
        }
        fields.serialize_field("model", &self.model())?;
        fields.serialize_field("raw_coefficients", &self.choice.solution.raw_coefficients())?;
        fields.serialize_field("rate_unit", &self.rate_unit)?;
        fields.serialize_field("temperature_unit", &self.temperature_unit)?;
        fields.serialize_field("temperature", &[self.drift.valid.min(), self.drift.valid.max()])?;
        fields.serialize_field("in_sample", &self.in_sample)?;
        fields.serialize_field("held_out", &self.held_out)?;
        if let Some(nested) = &self.nested {
            fields.serialize_field("nested", nested)?;
        }
        if let Some(drift) = &self.time_drift {
            fields.serialize_field("time_drift", drift)?;
        }
        let candidates = CandidateStatistics::of(&self.choice.candidates);
        if candidates.len() > 1 {
            fields.serialize_field("candidates", &candidates)?;
        }
        fields.serialize_field("samples_used", &self.samples_used)?;
        fields.serialize_field("samples_rejected", &self.samples_rejected)?;
        fields.end()
    }
}
