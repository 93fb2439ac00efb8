//! What is wrong with a page: by what it shows, and by what it tells of itself that it should not have to.

use std::io::Write;

use anyhow::Result;
use serde_json::Value;

use crate::devtools::{DevTools, Screen};

/// A figure's text is legible from about this height on, in CSS pixels of its glyph box.
const LEGIBLE_PX: f64 = 7.0;

/// How addresses begin of what a page carries or made itself.
const OWN: [&str; 2] = ["data:", "blob:"];

/// What an event says is wrong: an error in the console, or a request for anything but the page itself.
pub fn of(event: &Value, url: &str) -> Option<String> {
    let told = &event["params"];
    match event["method"].as_str()? {
        "Runtime.exceptionThrown" => Some(format!("exception: {}", told["exceptionDetails"]["text"])),
        "Runtime.consoleAPICalled" if told["type"] == "error" || told["type"] == "assert" => {
            Some(format!("console: {}", told["args"]))
        }
        "Log.entryAdded" if told["entry"]["level"] == "error" => Some(format!("log: {}", told["entry"]["text"])),
        "Network.requestWillBeSent" => {
            let asked = told["request"]["url"].as_str().unwrap_or_default();
            (asked != url && !OWN.iter().any(|own| asked.starts_with(own))).then(|| format!("request for {asked}"))
        }
        _ => None,
    }
}

/// What is wrong with what a page shows.
pub fn shown<W: Write>(page: &mut DevTools<W>, screen: Screen) -> Result<Vec<String>> {
    let width = screen.1;
    let mut faults = Vec::new();
    let wide = page.evaluate("document.documentElement.scrollWidth")?.as_f64().unwrap_or(f64::INFINITY);
    if wide > f64::from(width) {
        faults.push(format!("{wide} px wide on a screen of {width} px"));
    }
    if let Some(height) = page.evaluate(SMALLEST_TEXT)?.as_f64()
        && height < LEGIBLE_PX
    {
        faults.push(format!("a figure has text {height:.1} px high, legible is {LEGIBLE_PX} px"));
    }
    let covering = page.evaluate(COVERING_BUTTONS)?.as_f64().unwrap_or(f64::INFINITY);
    if covering > 0.0 {
        faults.push(format!("{covering} buttons cover what is under them"));
    }
    Ok(faults)
}

/// The height in CSS pixels of the lowest text in any figure, as scaled on this screen and whichever way it is turned;
/// null without figures.
const SMALLEST_TEXT: &str = "(() => {
    const heights = [...document.querySelectorAll('svg text')]
        .map(text => text.getBBox().height * Math.abs(text.getScreenCTM().a || text.getScreenCTM().b))
        .filter(height => height > 0);
    return heights.length ? Math.min(...heights) : null;
})()";

/// How many buttons lie on a text, a table or a figure. What is folded away has a place too, and is not seen.
const COVERING_BUTTONS: &str = "(() => {
    const seen = selector => [...document.querySelectorAll(selector)].filter(element => element.checkVisibility());
    const places = selector => seen(selector).map(element => element.getBoundingClientRect());
    const meet = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
    const beneath = places('pre, table, svg');
    return places('button').filter(button => button.width > 0 && beneath.some(other => meet(button, other))).length;
})()";

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn the_page_may_load_itself_and_what_it_carries_and_nothing_else() {
        let asks = |asked: &str| {
            let event = json!({ "method": "Network.requestWillBeSent", "params": { "request": { "url": asked } } });
            of(&event, "file:///report.html")
        };
        assert_eq!(asks("file:///report.html"), None);
        assert_eq!(asks("data:image/svg+xml,x"), None);
        assert_eq!(asks("blob:null/5c1d"), None);
        assert!(asks("file:///style.css").is_some());
        assert!(asks("https://example.org/font.woff2").is_some());
    }

    #[test]
    fn console_errors_count_and_other_lines_do_not() {
        let says = |kind: &str| {
            of(&json!({ "method": "Runtime.consoleAPICalled", "params": { "type": kind, "args": [] } }), "")
        };
        assert!(says("error").is_some());
        assert!(says("log").is_none());
        assert!(of(&json!({ "method": "Page.loadEventFired", "params": {} }), "").is_none());
    }
}
