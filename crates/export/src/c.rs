//! A calibration as a header in C99.

use std::fmt::Write as _;

use super::code::{
    Axis, Curve, IntAxis, IntCurve, IntTerm, STEP_MS, Term, axes, identifier, number, quoted, remarks, sizes,
};
use super::{ExportError, Exported, origin, to_know};
use zerorate_cal::calibration::Calibration;

/// The code, the same for all calibrations.
const TEMPLATE: &str = include_str!("template.h");

pub(super) fn write(calibration: &Calibration) -> Result<Exported, ExportError> {
    let axes = axes(calibration);
    let mut notes = vec![
        "bias = zr_bias(&ZR_AXES[i], temperature), or for an axis with terms zr_advance at every step and zr_bias_with_history; subtract it from the reading".to_owned(),
        "the same in integers, for processors without floating point: zr_int_bias, zr_int_advance, zr_int_bias_with_history".to_owned(),
    ];
    notes.extend(to_know(calibration, calibration.no_gains()));
    let mut text =
        "/* The drift of a gyroscope over temperature, for a microcontroller. C99, header only.\n".to_owned();
    for line in origin(calibration).iter().chain(&remarks(&axes)).chain(&notes) {
        put(&mut text, &format!("   {line}"));
    }
    text.push_str("*/\n\n#ifndef ZERORATE_CALIBRATION_H\n#define ZERORATE_CALIBRATION_H\n\n#include <stdint.h>\n\n");
    let (values, terms) = sizes(&axes);
    put(
        &mut text,
        &format!("#define ZR_VALUES {values}\n#define ZR_TERMS {terms}\n#define ZR_AXIS_COUNT {}", axes.len()),
    );
    put(&mut text, &format!("#define ZR_STEP_MS {STEP_MS} /* of zr_int_advance */\n"));
    let integers = axes.iter().map(Axis::integers).collect::<Result<Vec<_>, _>>()?;
    let mut names: Vec<String> = Vec::new();
    for (place, (axis, integer)) in axes.iter().zip(&integers).enumerate() {
        let mut name = identifier(&axis.name);
        if names.contains(&name) {
            // Names that differ in other letters alone.
            name = format!("{name}_{place}");
        }
        names.push(name.clone());
        put(&mut text, &format!("#define ZR_{name} {place} /* in {} */", axis.unit));
        put(&mut text, &format!("#define ZR_{name}_UNIT {} /* what 1 of zr_int_bias is */", number(integer.unit)));
    }
    text.push('\n');
    text.push_str(TEMPLATE);
    text.push_str("\n#ifndef ZERORATE_NO_FLOAT\n\nstatic const zr_axis ZR_AXES[ZR_AXIS_COUNT] = {\n");
    for axis in &axes {
        float_axis(&mut text, axis);
    }
    text.push_str("};\n\n#endif /* ZERORATE_NO_FLOAT */\n\nstatic const zr_int_axis ZR_INT_AXES[ZR_AXIS_COUNT] = {\n");
    for axis in &integers {
        int_axis(&mut text, axis);
    }
    text.push_str("};\n\n#endif /* ZERORATE_CALIBRATION_H */\n");
    Ok(Exported { text, sensors: Vec::new(), notes })
}

fn put(text: &mut String, line: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{line}");
}

fn real(value: f64) -> String {
    format!("(zr_real){}", number(value))
}

fn list<T>(values: &[T], each: impl Fn(&T) -> String) -> String {
    values.iter().map(each).collect::<Vec<_>>().join(", ")
}

fn curve(curve: &Curve) -> String {
    let values = list(&curve.values, |value| real(*value));
    let is_table = i32::from(curve.is_table);
    format!("{{{is_table}, {}, {}, {}, {{{values}}}}}", curve.values.len(), real(curve.centre), real(curve.half_span))
}

fn term(term: &Term) -> String {
    let is_play = i32::from(term.is_play);
    format!("{{{is_play}, {}, {}, {}, {}}}", real(term.size), real(term.weight), real(term.behind), real(term.share))
}

fn float_axis(text: &mut String, axis: &Axis) {
    put(text, &format!("    {{{}, {}, {},", quoted(&axis.name), real(axis.least), real(axis.most)));
    put(text, &format!("     {},", curve(&axis.fixed)));
    put(text, &format!("     {}, {},", axis.terms.len(), curve(&axis.known)));
    put(
        text,
        &format!(
            "     {{{}}}}},",
            if axis.terms.is_empty() { "{0, 0, 0, 0, 0}".to_owned() } else { list(&axis.terms, term) }
        ),
    );
}

fn int_curve(curve: &IntCurve) -> String {
    let values = list(&curve.values, ToString::to_string);
    let is_table = i32::from(curve.is_table);
    format!("{{{is_table}, {}, {}, INT64_C({}), {{{values}}}}}", curve.values.len(), curve.centre, curve.inverse)
}

fn int_term(term: &IntTerm) -> String {
    let IntTerm { is_play, size, kept, follows, weight, behind, share } = term;
    format!("{{{}, INT64_C({size}), {kept}, {follows}, {weight}, {behind}, {share}}}", i32::from(*is_play))
}

fn int_axis(text: &mut String, axis: &IntAxis) {
    put(text, &format!("    {{{}, {}, {},", axis.least, axis.most, int_curve(&axis.fixed)));
    put(text, &format!("     {}, {}, {},", axis.terms.len(), axis.weight_bits, int_curve(&axis.known)));
    let terms = if axis.terms.is_empty() { "{0, 0, 0, 0, 0, 0, 0}".to_owned() } else { list(&axis.terms, int_term) };
    put(text, &format!("     {{{terms}}}}},"));
}
