//! Text to be copied: a button where the browser lets it, and text that is selected at a click everywhere.

use maud::{Markup, html};

use crate::Parameters;

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

/// The parameters of each program.
pub(super) fn chapter(parameters: &[Parameters]) -> Markup {
    html! {
        p {
            "An autopilot evaluates a cubic of temperature and no more: these are the best cubics there are of this log. What they "
            "cost against the chosen model stands in their comments."
        }
        @for (place, parameters) in parameters.iter().enumerate() {
            h3 { (parameters.program) }
            @match &parameters.text {
                Ok(text) => {
                    details open[place == 0] {
                        summary { (text.lines().filter(|line| !line.starts_with('#')).count()) " parameters" }
                        (to_copy(&format!("parameters-{}", place + 1), text))
                    }
                }
                Err(why) => p { (why) "." }
            }
            p.small { "To write them to a file: " code { (parameters.command) } }
        }
    }
}
