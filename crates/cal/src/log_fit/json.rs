//! The JSON that `zerorate fit --json` prints.

use serde::ser::{Serialize, SerializeMap, SerializeStruct, Serializer};

use zerorate_fit::least_squares::raw_coefficients;

use super::{AxisFit, AxisVerdict, LogFit};
use crate::recording::utc::rfc3339;

/// The schema's version.
const SCHEMA: u32 = 1;

impl Serialize for LogFit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("LogFit", 8)?;
        fields.serialize_field("schema", &SCHEMA)?;
        fields.serialize_field("source", &self.source())?;
        if let Some(started) = self.sources.first().and_then(|log| log.started) {
            fields.serialize_field("started", &rfc3339(started))?;
        }
        fields.serialize_field("verdict", &self.judgement.verdict)?;
        fields.serialize_field("reasons", &self.judgement.reasons)?;
        if let Some(averaged_over_s) = self.averaged_over_s() {
            fields.serialize_field("averaged_over_s", &averaged_over_s)?;
        }
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
        let axis = &self.calibration;
        let (model, statistics) = (&axis.fit.model, &axis.fit.statistics);
        let mut fields = serializer.serialize_struct("AxisFit", 20)?;
        if let Some(sensor) = &axis.sensor {
            fields.serialize_field("sensor", sensor)?;
        }
        if let Some(reference) = &axis.reference_temperature {
            fields.serialize_field("reference_temperature", reference)?;
        }
        fields.serialize_field("model", &axis.fit.chosen_model())?;
        fields.serialize_field("static_model", &axis.model().to_string())?;
        fields.serialize_field("raw_coefficients", &raw_coefficients(&model.drift.shape))?;
        fields.serialize_field("rate_unit", &axis.rate_unit)?;
        fields.serialize_field("temperature_unit", &self.temperature_unit)?;
        let (measured, believed) = (&axis.fit.measured, &model.drift.valid);
        fields.serialize_field("temperature", &[measured.min(), measured.max()])?;
        fields.serialize_field("believed", &[believed.min(), believed.max()])?;
        fields.serialize_field("in_sample", &statistics.in_sample)?;
        fields.serialize_field("held_out", &statistics.held_out)?;
        if let Some(deployed) = &statistics.deployed {
            fields.serialize_field("deployed", deployed)?;
        }
        if let Some(uncorrected) = &statistics.uncorrected {
            fields.serialize_field("uncorrected", uncorrected)?;
        }
        if !statistics.by_log.is_empty() {
            fields.serialize_field("by_log", &statistics.by_log)?;
        }
        if !statistics.trends.is_empty() {
            fields.serialize_field("trends", &statistics.trends)?;
        }
        if let Some(nested) = &statistics.nested {
            fields.serialize_field("nested", nested)?;
        }
        if let Some(drift) = &model.time_drift {
            fields.serialize_field("time_drift", drift)?;
        }
        if statistics.candidates.len() > 1 {
            fields.serialize_field("candidates", &statistics.candidates)?;
        }
        fields.serialize_field("samples_used", &statistics.samples_used)?;
        fields.serialize_field("samples_rejected", &self.samples_rejected)?;
        fields.end()
    }
}
