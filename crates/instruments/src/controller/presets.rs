//! The registers of some controllers, each with its source. None was tried on the real thing: hold a preset against the
//! manual of the controller in front of you, and begin with `zerorate calibrate --dry-run`, which only reads.

use super::form::{Form, WordOrder};

/// What a preset says of a controller.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Preset {
    pub(super) actual_register: Option<u16>,
    pub(super) set_point_register: Option<u16>,
    pub(super) form: Option<Form>,
    pub(super) scale: Option<f64>,
    pub(super) word_order: Option<WordOrder>,
    pub(super) run_register: Option<u16>,
    pub(super) run_value: Option<u16>,
    pub(super) stop_value: Option<u16>,
}

/// Eurotherm 2000 and 3000: PV.IN 1, TG.SP 2, whole numbers with the instrument's own decimals (Eurotherm 2000 series
/// communications handbook HA026230, and the drivers that cite it). Register 199, the instrument's mode, is left out: sources
/// disagree on which value is standby.
const EUROTHERM: Preset = Preset {
    actual_register: Some(1),
    set_point_register: Some(2),
    form: Some(Form::I16),
    scale: Some(10.0),
    word_order: None,
    run_register: None,
    run_value: None,
    stop_value: None,
};

/// Watlow F4T, control loop 1: process value 2820, set point 2782, mode 2730 (10 auto, 62 off), floats low word first, the
/// controller's own default (Espec North America, ChamberConnectLibrary, watlowf4t.py: loop 1).
const WATLOW_F4T: Preset = Preset {
    actual_register: Some(2820),
    set_point_register: Some(2782),
    form: Some(Form::F32),
    scale: None,
    word_order: Some(WordOrder::LowFirst),
    run_register: Some(2730),
    run_value: Some(10),
    stop_value: Some(62),
};

/// Binder MK 53 and others with the MCS and MB1 controllers: process value 0x11A9, manual set point 0x1581, floats low word
/// first, mode 0x1A22 with 0x0800 for manual (Binder's interface description, 2.11.7, as ovenctl and basil's
/// binder_mk53.py cite it). What stops it is not told there: it stays at the safe set point.
const BINDER: Preset = Preset {
    actual_register: Some(0x11A9),
    set_point_register: Some(0x1581),
    form: Some(Form::F32),
    scale: None,
    word_order: Some(WordOrder::LowFirst),
    run_register: Some(0x1A22),
    run_value: Some(0x0800),
    stop_value: None,
};

/// Espec North America's chambers with a Watlow F4: input 1 in 100, set point 1 in 300, tenths of a degree (Watlow Series F4
/// user's manual, Modbus registers; ChamberConnectLibrary, watlowf4.py). Espec's own P-300 and SCP-220 speak no Modbus.
const ESPEC: Preset = Preset {
    actual_register: Some(100),
    set_point_register: Some(300),
    form: Some(Form::I16),
    scale: Some(10.0),
    word_order: None,
    run_register: None,
    run_value: None,
    stop_value: None,
};

const ALL: [(&str, Preset); 4] =
    [("eurotherm", EUROTHERM), ("watlow-f4t", WATLOW_F4T), ("binder", BINDER), ("espec", ESPEC)];

/// A preset by name.
pub(super) fn named(name: &str) -> Option<Preset> {
    ALL.iter().find(|(own, _)| *own == name).map(|(_, preset)| *preset)
}

/// The names of all.
pub(super) fn names() -> Vec<&'static str> {
    ALL.iter().map(|(name, _)| *name).collect()
}
