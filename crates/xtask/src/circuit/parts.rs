//! The circuit's parts list, hardware/zero-adjust/parts.csv: what each part's value is and how far it may be off.

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail, ensure};

/// The first line of the list.
const HEADER: &str = "reference,quantity,value,tolerance,drift,part,devices,reason";

/// How far a value may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spread {
    /// By so much of itself.
    Relative(f64),
    /// By so much, in the value's own unit.
    Absolute(f64),
}

impl Spread {
    /// So many times as far.
    pub fn times(self, factor: f64) -> Self {
        match self {
            Self::Relative(part) => Self::Relative(part * factor),
            Self::Absolute(amount) => Self::Absolute(amount * factor),
        }
    }
}

/// What is off by itself: a part, a resistor of a network, or all resistors of a network together.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Its line of the list, as "R101 R102".
    pub reference: String,
    /// The netlist's names of what moves together.
    pub devices: Vec<String>,
    /// Ohms, farads, volts or amperes.
    pub value: f64,
    /// At delivery, to one side.
    pub tolerance: Spread,
    /// For a kelvin, to one side.
    pub drift: Spread,
}

/// Reads the list; lines without devices (what is not in the netlist) give no unit.
pub fn units(csv: &str) -> Result<Vec<Unit>> {
    let mut lines = csv.lines();
    ensure!(lines.next() == Some(HEADER), "parts.csv: the first line is not `{HEADER}`");
    let mut found = Vec::new();
    for (index, line) in lines.enumerate() {
        let unit = units_of(line).with_context(|| format!("parts.csv:{}", index + 2))?;
        found.extend(unit);
    }
    Ok(found)
}

/// The values of all devices of the units, as the list says.
pub fn nominal(units: &[Unit]) -> BTreeMap<String, f64> {
    units.iter().flat_map(|unit| unit.devices.iter().map(|device| (device.clone(), unit.value))).collect()
}

/// The values of the devices when each unit is off by a fraction, -1 to 1, of what `spread` gives; devices of units that
/// are not off are left out. A resistor may be in two units: its own deviation and its network's.
pub fn off(units: &[Unit], fractions: &[f64], spread: impl Fn(&Unit) -> Spread) -> BTreeMap<String, f64> {
    let mut values = BTreeMap::new();
    for (unit, fraction) in units.iter().zip(fractions).filter(|(_, fraction)| **fraction != 0.0) {
        for device in &unit.devices {
            let value = values.entry(device.clone()).or_insert(unit.value);
            match spread(unit) {
                Spread::Relative(part) => *value *= 1.0 + part * fraction,
                Spread::Absolute(amount) => *value += amount * fraction,
            }
        }
    }
    values
}

fn units_of(line: &str) -> Result<Vec<Unit>> {
    let fields: Vec<&str> = line.split(',').collect();
    let [reference, _, value, tolerance, drift, _, devices, _] = fields[..] else {
        bail!("{} fields, not 8: a field may have no comma", fields.len());
    };
    let unit = |group: &str| {
        Ok(Unit {
            reference: reference.to_owned(),
            devices: group.split('+').map(str::to_owned).collect(),
            value: spice_number(value)?,
            tolerance: spread(tolerance)?,
            drift: spread(drift.strip_suffix("/C").context("drift is not given for a kelvin, as in 10 ppm/C")?)?,
        })
    };
    devices.split_whitespace().map(unit).collect()
}

/// "0.1 %", "10 ppm", "10 uV", "100 pA".
fn spread(text: &str) -> Result<Spread> {
    let (number, unit) = text.trim().split_once(' ').with_context(|| format!("`{text}` is not `number unit`"))?;
    let number: f64 = number.parse().with_context(|| format!("`{text}`"))?;
    Ok(match unit {
        "%" => Spread::Relative(number * 1e-2),
        "ppm" => Spread::Relative(number * 1e-6),
        "uV" => Spread::Absolute(number * 1e-6),
        "pA" => Spread::Absolute(number * 1e-12),
        _ => bail!("`{text}`: the unit is none of %, ppm, uV, pA"),
    })
}

/// A number with SPICE's scale letters: 30.9k, 47n, 1meg.
fn spice_number(text: &str) -> Result<f64> {
    let digits = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, scale) = text.split_at(digits);
    let scale = match scale {
        "" => 1.0,
        "k" => 1e3,
        "meg" => 1e6,
        "m" => 1e-3,
        "u" => 1e-6,
        "n" => 1e-9,
        "p" => 1e-12,
        _ => bail!("`{text}`: `{scale}` is none of meg, k, m, u, n, p"),
    };
    Ok(number.parse::<f64>().with_context(|| format!("`{text}` is no number"))? * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIST: &str = "reference,quantity,value,tolerance,drift,part,devices,reason\n\
        R1 R2,2,10k,0.1 %,10 ppm/C,thin film,r.x.r1 r.x.r2,why\n\
        both,0,10k,15 %,25 ppm/C,the same,r.x.r1+r.x.r2,why\n\
        U1,1,0,10 uV,0.02 uV/C,amplifier,v.x.vos,why\n\
        J1,1,,,,connector,,why\n";

    #[test]
    fn devices_move_alone_or_together() {
        let units = units(LIST).unwrap();
        let sizes: Vec<usize> = units.iter().map(|unit| unit.devices.len()).collect();
        assert_eq!(sizes, [1, 1, 2, 1]);
        assert_eq!(units[2].reference, "both");
        assert!(matches!(units[3].tolerance, Spread::Absolute(volts) if (volts - 1e-5).abs() < 1e-12));
    }

    #[test]
    fn a_resistor_s_own_deviation_and_its_network_s_multiply() {
        let units = units(LIST).unwrap();
        let values = off(&units, &[1.0, 0.0, -1.0, 0.5], |unit| unit.tolerance);
        assert!((values["r.x.r1"] - 10e3 * 1.001 * 0.85).abs() < 1e-9);
        assert!((values["r.x.r2"] - 10e3 * 0.85).abs() < 1e-9);
        assert!((values["v.x.vos"] - 5e-6).abs() < 1e-18);
    }

    #[test]
    fn a_line_that_cannot_be_read_is_named() {
        let error = units(&format!("{HEADER}\nR1,1,10x,1 %,1 ppm/C,a,r.r1,b\n")).unwrap_err();
        assert!(format!("{error:#}").contains("parts.csv:2") && format!("{error:#}").contains("10x"));
        assert!(units("name,value\n").is_err());
        assert!(units(&format!("{HEADER}\nR1,1,10k,1 %,1 ppm/C,a, b,r.r1,c\n")).is_err());
    }

    #[test]
    fn scale_letters_are_spice_s() {
        for (text, value) in [("30.9k", 30.9e3), ("1meg", 1e6), ("47n", 47e-9), ("5.0", 5.0)] {
            assert!((spice_number(text).unwrap() / value - 1.0).abs() < 1e-12, "{text}");
        }
    }
}
