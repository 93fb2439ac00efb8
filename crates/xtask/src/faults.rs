//! What a page tells of itself that it should not have to.

use serde_json::Value;

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
