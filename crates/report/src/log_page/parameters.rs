//! Text to be copied: a button where the browser lets it, and text that is selected at a click everywhere.

use maud::{Markup, html};
use zerorate_cal::calibration::Calibration;
use zerorate_cal::units::{RateUnit, TemperatureUnit};
use zerorate_export::{ExportOptions, Format, export};

use super::LogPage;
use crate::page::told;

/// The forms that a page shows: those of autopilots, which people paste.
const SHOWN: [(Format, &str); 3] = [
    (Format::Px4, "PX4 (QGroundControl)"),
    (Format::ArduPilot, "ArduPilot (Mission Planner, MAVProxy)"),
    (Format::MethodicConfigurator, "ArduPilot (MethodicConfigurator)"),
];

/// Copies a text at a click on its button: by the clipboard where the page may, else by selecting it and the browser's own
/// command, and if that fails too the text stays selected, for the keyboard.
pub(super) const SCRIPT: &str = r#"
document.querySelectorAll("button[data-copies]").forEach(button => {
  button.hidden = false;
  const text = document.getElementById(button.dataset.copies);
  const say = word => { button.textContent = word; setTimeout(() => { button.textContent = "Copy"; }, 2000); };
  const select = () => {
    const range = document.createRange();
    range.selectNodeContents(text);
    const selection = getSelection();
    selection.removeAllRanges();
    selection.addRange(range);
  };
  const byCommand = () => {
    select();
    let copied = false;
    try { copied = document.execCommand("copy"); } catch { copied = false; }
    say(copied ? "Copied" : "Selected");
  };
  button.addEventListener("click", () => {
    if (navigator.clipboard) { navigator.clipboard.writeText(text.textContent).then(() => say("Copied"), byCommand); }
    else { byCommand(); }
  });
});
"#;

/// A text with its button. The button is hidden until the script has seen it, and the text is selected whole at a click
/// by the style sheet, so that without the script nothing is missing but the button.
pub(super) fn to_copy(id: &str, text: &str) -> Markup {
    html! {
        div.copy {
            button type="button" data-copies=(id) hidden { "Copy" }
            pre tabindex="0" { code id=(id) { (text) } }
        }
    }
}

/// The parameters of each program, as `export` writes them; none for rates or temperatures in counts, or for a rejected log.
pub(super) fn chapter(page: &LogPage<'_>) -> Option<Markup> {
    let (fit, command) = (page.fit, page.export_command);
    let in_counts = |unit: RateUnit| unit == RateUnit::Counts;
    let known = fit.axes.first().is_some_and(|axis| axis.temperature_unit == TemperatureUnit::C);
    if !known || fit.axes.iter().any(|axis| in_counts(axis.calibration.rate_unit)) {
        return None;
    }
    let calibration = fit.to_calibration(page.sources.to_vec(), page.serial.map(str::to_owned)).ok()?;
    let calibration = Calibration { told_in: page.units, ..calibration };
    Some(html! {
        p {
            "An autopilot evaluates a cubic of temperature and no more: these are the best cubics there are of this log. What they "
            "cost against the chosen model stands in their comments."
        }
        @for (place, (format, program)) in SHOWN.into_iter().enumerate() {
            h3 { (program) }
            @match export(&calibration, format, &ExportOptions::default()) {
                Ok(exported) => {
                    @let text = exported.text;
                    details open[place == 0] {
                        summary { (text.lines().filter(|line| !line.starts_with('#')).count()) " parameters" }
                        (to_copy(&format!("parameters-{}", place + 1), &text))
                    }
                }
                Err(why) => p { (told(&why.to_string())) "." }
            }
            @if let Some(command) = command { p.small { "To write them to a file: " code { (command(format)) } } }
        }
    })
}
