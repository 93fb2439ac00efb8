//! A controller as a set-up has it, and as it is once it was checked.

use std::time::Duration;

use documented::DocumentedFields;
use serde::{Deserialize, Serialize};
use zerorate_core::units::Celsius;

use super::form::{Degrees, Form, WordOrder};
use super::presets::{self, Preset};

/// The chamber's controller. `preset` names its registers; a field that stands here besides takes the preset's place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(default, deny_unknown_fields)]
pub struct ControllerTable {
    /// eurotherm, watlow-f4t, binder or espec; or own, where every register stands here. Each with its source in
    /// docs/instruments.md, which says what was tried on the real thing.
    pub preset: String,
    /// The unit's number on the line, 1 to 247.
    pub unit: u8,
    /// Where the chamber is sent at the end of a run, or when it stops, before it is stopped, degrees C.
    pub safe_c: f64,
    /// How long an answer may take, milliseconds.
    pub time_out_ms: u64,
    /// The holding register of the air's temperature, counted from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actual_register: Option<u16>,
    /// The holding register of the set point, counted from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set_point_register: Option<u16>,
    /// How a temperature stands in them: i16 (one register, with scale) or f32 (two registers, with word_order).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<Form>,
    /// What a degree is in an i16: 10 for tenths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Which register of an f32 comes first: high-first or low-first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub word_order: Option<WordOrder>,
    /// Degrees of the controller: C or F.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degrees: Option<Degrees>,
    /// The holding register by which the chamber runs and stops; without it only the set point is written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run_register: Option<u16>,
    /// What makes it run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run_value: Option<u16>,
    /// What makes it stop; without it the chamber stays at the safe set point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_value: Option<u16>,
}

impl Default for ControllerTable {
    fn default() -> Self {
        Self {
            preset: "own".into(),
            unit: 1,
            safe_c: 25.0,
            time_out_ms: 1000,
            actual_register: None,
            set_point_register: None,
            form: None,
            scale: None,
            word_order: None,
            degrees: None,
            run_register: None,
            run_value: None,
            stop_value: None,
        }
    }
}

/// A controller's registers, checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Registers {
    /// The air's temperature.
    pub(super) actual: u16,
    /// The set point.
    pub(super) set_point: u16,
    /// How a temperature stands in them.
    pub(super) form: Form,
    /// What a degree is in an i16.
    pub(super) scale: f64,
    /// Which register of an f32 comes first.
    pub(super) word_order: WordOrder,
    /// Where it is made run, and by what.
    pub(super) run: Option<(u16, u16)>,
    /// Where it is made stop, and by what.
    pub(super) stop: Option<(u16, u16)>,
}

impl ControllerTable {
    /// A table of a preset, everything in it as the preset has it.
    #[must_use]
    pub fn of(preset: &str) -> Self {
        Self { preset: preset.into(), ..Self::default() }
    }

    /// A table of a preset with every register written out, to be held against the controller's manual and changed.
    ///
    /// # Errors
    /// A sentence, where there is no such preset.
    pub fn whole(preset: &str) -> Result<Self, String> {
        let mut table = Self::of(preset);
        if preset == "own" {
            // Numbers that a person must look up: a set-up with them contradicts itself.
            table = Self {
                actual_register: Some(0),
                set_point_register: Some(0),
                form: Some(Form::I16),
                scale: Some(10.0),
                ..table
            };
        }
        let registers = table.registers()?;
        Ok(Self {
            actual_register: Some(registers.actual),
            set_point_register: Some(registers.set_point),
            form: Some(registers.form),
            scale: Some(registers.scale),
            word_order: Some(registers.word_order),
            degrees: Some(Degrees::C),
            run_register: registers.run.map(|(register, _)| register),
            run_value: registers.run.map(|(_, value)| value),
            stop_value: registers.stop.map(|(_, value)| value),
            ..table
        })
    }

    /// What cannot be, in sentences; `limits` are the chamber's.
    #[must_use]
    pub fn contradictions(&self, limits: [Celsius; 2]) -> Vec<String> {
        let mut found = Vec::new();
        let mut must = |holds: bool, sentence: String| {
            if !holds {
                found.push(sentence);
            }
        };
        must(
            (1..=247).contains(&self.unit),
            format!("chamber.controller.unit is {}: a unit's number is 1 to 247", self.unit),
        );
        must(
            (limits[0].0..=limits[1].0).contains(&self.safe_c),
            format!(
                "chamber.controller.safe_c {} is outside the chamber's limits {} to {}",
                self.safe_c, limits[0].0, limits[1].0
            ),
        );
        must(
            (50..=30_000).contains(&self.time_out_ms),
            format!("chamber.controller.time_out_ms is {}: give 50 to 30000", self.time_out_ms),
        );
        must(
            self.scale.is_none_or(|scale| scale > 0.0 && scale.is_finite()),
            "chamber.controller.scale must be above 0: 10 where the registers hold tenths".into(),
        );
        match self.registers() {
            Ok(registers) => must(
                registers.actual != registers.set_point,
                format!(
                    "chamber.controller.actual_register and set_point_register are both {}: look them up in the controller's manual",
                    registers.actual
                ),
            ),
            Err(sentence) => must(false, sentence),
        }
        found
    }

    /// The registers, the preset's where none stands here.
    ///
    /// # Errors
    /// A sentence that says what is missing.
    pub fn registers(&self) -> Result<Registers, String> {
        let preset = match self.preset.as_str() {
            "own" => Preset::default(),
            name => presets::named(name).ok_or_else(|| {
                format!("chamber.controller.preset is \"{name}\": give {} or own", presets::names().join(", "))
            })?,
        };
        let missing = |field: &str| format!("chamber.controller.{field} is missing: preset \"own\" needs it");
        let form = self.form.or(preset.form).ok_or_else(|| missing("form (i16 or f32)"))?;
        let run_register = self.run_register.or(preset.run_register);
        let at = |value: Option<u16>| Some((run_register?, value?));
        let run_value = self.run_value.or(preset.run_value);
        if run_register.is_some() != run_value.is_some() {
            return Err("chamber.controller.run_register and run_value belong together: give both or neither".into());
        }
        let stop_value = self.stop_value.or(preset.stop_value);
        if run_register.is_some() && run_value == stop_value {
            return Err("chamber.controller.run_value and stop_value are one number, and a chamber that runs could not be told from one that is stopped: give each its own".into());
        }
        Ok(Registers {
            actual: self.actual_register.or(preset.actual_register).ok_or_else(|| missing("actual_register"))?,
            set_point: self
                .set_point_register
                .or(preset.set_point_register)
                .ok_or_else(|| missing("set_point_register"))?,
            form,
            scale: match (form, self.scale.or(preset.scale)) {
                (_, Some(scale)) => scale,
                (Form::F32, None) => 1.0,
                (Form::I16, None) => return Err(missing("scale (10 where the registers hold tenths)")),
            },
            word_order: match (form, self.word_order.or(preset.word_order)) {
                (_, Some(order)) => order,
                (Form::I16, None) => WordOrder::HighFirst,
                (Form::F32, None) => return Err(missing("word_order (high-first or low-first)")),
            },
            run: at(run_value),
            stop: at(stop_value),
        })
    }

    /// Degrees of the controller.
    pub(super) fn degrees(&self) -> Degrees {
        self.degrees.unwrap_or(Degrees::C)
    }

    /// How long an answer may take.
    pub(super) const fn time_out(&self) -> Duration {
        Duration::from_millis(self.time_out_ms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: [Celsius; 2] = [Celsius(-60.0), Celsius(150.0)];

    #[test]
    fn every_preset_is_whole_and_a_field_takes_its_place() {
        for name in presets::names() {
            assert_eq!(ControllerTable::of(name).contradictions(LIMITS), Vec::<String>::new(), "{name}");
        }
        let table = ControllerTable { set_point_register: Some(24), ..ControllerTable::of("eurotherm") };
        assert_eq!(table.registers().map(|registers| (registers.actual, registers.set_point)), Ok((1, 24)));
    }

    #[test]
    fn what_is_missing_or_cannot_be_is_named() {
        let own =
            ControllerTable { actual_register: Some(1), set_point_register: Some(2), ..ControllerTable::default() };
        for (table, told) in [
            (ControllerTable::of("weiss"), "give eurotherm, watlow-f4t, binder, espec or own"),
            (ControllerTable::default(), "controller.form (i16 or f32) is missing"),
            (
                ControllerTable { form: Some(Form::F32), ..own.clone() },
                "word_order (high-first or low-first) is missing",
            ),
            (ControllerTable { form: Some(Form::I16), ..own.clone() }, "scale (10 where"),
            (ControllerTable { run_value: Some(1), ..ControllerTable::of("eurotherm") }, "belong together"),
            (ControllerTable { run_value: Some(62), ..ControllerTable::of("watlow-f4t") }, "are one number"),
            (ControllerTable { safe_c: 200.0, ..ControllerTable::of("binder") }, "safe_c 200 is outside"),
            (ControllerTable { safe_c: f64::NAN, ..ControllerTable::of("binder") }, "safe_c NaN is outside"),
            (ControllerTable { unit: 0, ..ControllerTable::of("binder") }, "1 to 247"),
            (ControllerTable::whole("own").unwrap(), "set_point_register are both 0"),
            (ControllerTable { scale: Some(0.0), ..ControllerTable::of("espec") }, "above 0"),
        ] {
            let found = table.contradictions(LIMITS).join("; ");
            assert!(found.contains(told), "{told} is missing from: {found}");
        }
    }
}
