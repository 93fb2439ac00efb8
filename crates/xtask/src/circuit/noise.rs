//! The circuit's own noise at the A/D: ngspice's `.noise` beside the sum that a hand makes of it.

use std::f64::consts::{FRAC_PI_2, PI};

use anyhow::{Context, Result};

use super::parts::Unit;
use super::spice::Spice;
use super::{AXES, OUTPUTS, parts, sim, table};

/// An amplifier's, V/rtHz (AD8628's sheet), and its gain-bandwidth, Hz: those of the netlist's model.
const AMPLIFIER_V: f64 = 22e-9;
const GAIN_BANDWIDTH_HZ: f64 = 2.5e6;
/// Four times Boltzmann's constant at 27 C, ngspice's temperature.
const FOUR_KT: f64 = 4.0 * 1.380_649e-23 * 300.15;
/// The wiper's switch and the source resistance of a potentiometer of 10 kOhm in its middle.
const WIPER_OHM: f64 = 5e3 + 2.5e3;
/// How far the hand's sum may be from ngspice: it takes the amplifiers' bandwidth for one pole and the rest for flat.
const LIMIT: f64 = 0.03;
/// Sim's allowance for a whole board's noise, of which this circuit's must be a small part.
const ALLOWANCE_V: f64 = 125e-6;

/// Prints both; faults where they differ.
pub fn compare(spice: &Spice, units: &[Unit]) -> Result<Vec<String>> {
    let values = parts::nominal(units);
    let mut faults = Vec::new();
    let mut rows = Vec::new();
    for (axis, name) in AXES.iter().enumerate() {
        let of = |part: &str| {
            let device = format!("{}.x{}.{part}", &part[..1], ["x", "y"][axis]);
            values.get(&device).copied().with_context(|| format!("parts.csv has no {device}"))
        };
        let thermal = |ohm: f64| FOUR_KT * ohm;
        let amplifier = AMPLIFIER_V.powi(2);
        let (feedback, gain_ohm) = (of("r1")?, of("r3")? + of("r4")?);
        let gain = 1.0 + 2.0 * feedback / gain_ohm;
        // Before the low-pass, in V^2/Hz: what each source is at the output of U1C.
        let input_pair = gain.powi(2) * (2.0 * amplifier + thermal(WIPER_OHM) + thermal(of("r15")?))
            + 2.0 * thermal(feedback)
            + thermal(gain_ohm) * (gain - 1.0).powi(2);
        let difference = 4.0 * thermal(of("rn1a")?) + 4.0 * amplifier;
        let centre = amplifier + thermal(of("rn3a")? / 2.0);
        let low_pass = input_pair + difference + centre + thermal(of("r5")?);
        let corner_hz = 1.0 / (2.0 * PI * of("r5")? * of("c1")?);
        // U1D comes after it: two poles in a row pass pi/2 f1 f2/(f1 + f2).
        let driver_hz = 1.0 / (2.0 * PI * of("r6")? * of("c2")?);
        let band_hz = FRAC_PI_2 * driver_hz * GAIN_BANDWIDTH_HZ / (driver_hz + GAIN_BANDWIDTH_HZ);
        // And the resistor at the A/D: kT/C.
        let sampled = FOUR_KT / 4.0 / of("c2")?;
        let slow_v = (low_pass * FRAC_PI_2 * corner_hz).sqrt();
        let hand_v = (slow_v.powi(2) + amplifier * band_hz + sampled).sqrt();

        let spice_v = spice.noise_v(OUTPUTS[axis])?;
        let off = hand_v / spice_v - 1.0;
        // What is no number is a fault, too.
        let is_good = off.abs() <= LIMIT && spice_v < ALLOWANCE_V / 4.0;
        if !is_good {
            faults.push(format!("{name}: noise of {spice_v:e} V by ngspice, {hand_v:e} V by hand"));
        }
        rows.push(vec![
            (*name).to_owned(),
            format!("{:.2}", spice_v * 1e6),
            format!("{:.2}", hand_v * 1e6),
            format!("{:+.1} %", off * 100.0),
            format!("{:.2}", slow_v * 1e6),
            format!("{:.3}", spice_v / sim::COUNT_V),
            if is_good { "good" } else { "OUT" }.to_owned(),
        ]);
    }
    table(&["noise at the A/D, uV rms", "ngspice", "by hand", "difference", "of it below 63 Hz", "counts", ""], &rows);
    Ok(faults)
}
