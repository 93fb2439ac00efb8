//! A calibration as a Rust module without std.

use std::fmt::Write as _;

use super::code::{
    Axis, Curve, IntAxis, IntCurve, IntTerm, STEP_MS, Term, axes, identifier, number, quoted, remarks, sizes,
};
use super::{ExportError, Exported, origin};
use crate::calibration::Calibration;

/// The code, the same for all calibrations.
const TEMPLATE: &str = include_str!("template.rs.txt");

pub(super) fn write(calibration: &Calibration) -> Result<Exported, ExportError> {
    let axes = axes(calibration);
    let notes = vec![
        "bias = AXES[i].bias(temperature), or for an axis with terms `advance` at every step and `bias_with_history`; subtract it from the reading".to_owned(),
        "the same in integers, for processors without floating point: INT_AXES".to_owned(),
        "Real may be f64 where the processor has it".to_owned(),
    ];
    let mut text =
        "// The drift of a gyroscope over temperature, for a microcontroller. Needs core alone.\n".to_owned();
    for line in origin(calibration).iter().chain(&remarks(&axes)).chain(&notes) {
        put(&mut text, &format!("// {line}"));
    }
    let (_, terms) = sizes(&axes);
    put(&mut text, "\n/// The numbers of the floating-point form.\npub type Real = f32;\n");
    put(&mut text, &format!("/// Terms of a history, at most.\npub const TERMS: usize = {terms};"));
    put(
        &mut text,
        &format!(
            "/// The step by which [`IntAxis::advance`] is called, milliseconds.\npub const STEP_MS: u32 = {STEP_MS};"
        ),
    );
    let integers = axes.iter().map(Axis::integers).collect::<Result<Vec<_>, _>>()?;
    for (place, axis) in axes.iter().enumerate() {
        put(&mut text, &format!("/// The place of {} among the axes; in {}.", quoted(&axis.name), axis.unit));
        put(&mut text, &format!("pub const {}: usize = {place};", identifier(&axis.name)));
    }
    text.push('\n');
    text.push_str(TEMPLATE);
    put(&mut text, &format!("\n/// The axes in floating point.\npub static AXES: [Axis; {}] = [", axes.len()));
    for axis in &axes {
        float_axis(&mut text, axis);
    }
    put(&mut text, &format!("];\n\n/// The axes in integers.\npub static INT_AXES: [IntAxis; {}] = [", axes.len()));
    for (axis, named) in integers.iter().zip(&axes) {
        int_axis(&mut text, axis, &named.name);
    }
    put(&mut text, "];");
    Ok(Exported { text, sensors: Vec::new(), notes })
}

fn put(text: &mut String, line: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{line}");
}

fn list<T>(values: &[T], each: impl Fn(&T) -> String) -> String {
    values.iter().map(each).collect::<Vec<_>>().join(", ")
}

fn curve(curve: &Curve) -> String {
    let Curve { is_table, centre, half_span, values } = curve;
    let values = list(values, |value| number(*value));
    let (centre, half_span) = (number(*centre), number(*half_span));
    format!("Curve {{ is_table: {is_table}, centre: {centre}, half_span: {half_span}, values: &[{values}] }}")
}

fn term(term: &Term) -> String {
    let Term { is_play, size, weight, share } = term;
    let (size, weight, share) = (number(*size), number(*weight), number(*share));
    format!("Term {{ is_play: {is_play}, size: {size}, weight: {weight}, share: {share} }}")
}

fn float_axis(text: &mut String, axis: &Axis) {
    put(text, "    Axis {");
    put(text, &format!("        name: {},", quoted(&axis.name)));
    put(text, &format!("        least: {},\n        most: {},", number(axis.least), number(axis.most)));
    put(text, &format!("        fixed: {},", curve(&axis.fixed)));
    put(text, &format!("        known: {},", curve(&axis.known)));
    put(text, &format!("        terms: &[{}],\n    }},", list(&axis.terms, term)));
}

fn int_curve(curve: &IntCurve) -> String {
    let IntCurve { is_table, centre, inverse, values } = curve;
    let values = list(values, ToString::to_string);
    format!("IntCurve {{ is_table: {is_table}, centre: {centre}, inverse: {inverse}, values: &[{values}] }}")
}

fn int_term(term: &IntTerm) -> String {
    let IntTerm { is_play, size, kept, follows, weight, share } = term;
    format!(
        "IntTerm {{ is_play: {is_play}, size: {size}, kept: {kept}, follows: {follows}, weight: {weight}, share: {share} }}"
    )
}

fn int_axis(text: &mut String, axis: &IntAxis, name: &str) {
    put(text, "    IntAxis {");
    put(text, &format!("        name: {},\n        unit: {},", quoted(name), number(axis.unit)));
    put(text, &format!("        least: {},\n        most: {},", axis.least, axis.most));
    put(text, &format!("        fixed: {},", int_curve(&axis.fixed)));
    put(text, &format!("        known: {},", int_curve(&axis.known)));
    put(text, &format!("        weight_bits: {},", axis.weight_bits));
    put(text, &format!("        terms: &[{}],\n    }},", list(&axis.terms, int_term)));
}
