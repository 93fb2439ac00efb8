//! Opens the reports of a calibration and of a log as their reader would: on a desktop and on a phone, in light and in dark.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

use crate::browser::Browser;
use crate::devtools::DevTools;
use crate::provide;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// A screen: name, width and height in CSS pixels, whether it is a phone's.
const SCREENS: [(&str, u32, u32, bool); 2] = [("desktop", 1280, 900, false), ("phone", 390, 844, true)];

/// A figure's text is legible from about this height on, in CSS pixels of its glyph box.
const LEGIBLE_PX: f64 = 7.0;

/// Calibrates, fits a log where there is a recording, then opens both reports on each screen in each scheme. The pictures
/// stay in target/report-screenshots.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let mut reports = vec![("calibration", of_calibration(workspace)?)];
    match of_log(workspace)? {
        Some(report) => reports.push(("log", report)),
        None => println!("    without a log's report: no ../shared/data, and ZERORATE_DATA names no other folder"),
    }
    let pictures = workspace.target.join("report-screenshots");
    fs::create_dir_all(&pictures)?;
    let mut browser = Browser::start(&workspace.target)?;
    let mut faults = Vec::new();
    for (name, report) in reports {
        let url = format!("file://{}", report.canonicalize().with_context(|| report.display().to_string())?.display());
        for screen in SCREENS {
            for scheme in ["light", "dark"] {
                let view = format!("{name}-{}-{scheme}", screen.0);
                let picture = pictures.join(format!("{view}.png"));
                let found =
                    look(&mut browser.devtools, &url, screen, scheme, &picture).with_context(|| view.clone())?;
                faults.extend(found.into_iter().map(|fault| format!("{view}: {fault}")));
            }
        }
    }
    ensure!(faults.is_empty(), "{} faults\n    {}", faults.len(), faults.join("\n    "));
    println!("    no console error, no request, no overflow; pictures in {}", pictures.display());
    Ok(Outcome::Passed)
}

/// The report of a calibration on the simulated bench.
fn of_calibration(workspace: &Workspace) -> Result<PathBuf> {
    let out = workspace.target.join("report-calibration");
    println!("    zerorate calibrate --out {}", out.display());
    let mut calibrate = Command::new(workspace.zerorate()?);
    provide::succeed(calibrate.arg("calibrate").arg("--out").arg(&out).stdout(Stdio::null()))?;
    Ok(out.join("report.html"))
}

/// The report of a real log, where there is one.
fn of_log(workspace: &Workspace) -> Result<Option<PathBuf>> {
    let recording = workspace.data().map(|data| data.join("imu-chamber-cycle/imu_raw_data.tsv"));
    let Some(recording) = recording.filter(|recording| recording.is_file()) else { return Ok(None) };
    let report = workspace.target.join("report-log.html");
    println!("    zerorate fit {} --report {}", recording.display(), report.display());
    let mut fit = Command::new(workspace.zerorate()?);
    provide::succeed(fit.arg("fit").arg(&recording).arg("--force").arg("--report").arg(&report).stdout(Stdio::null()))?;
    Ok(Some(report))
}

/// Opens the page in one view, takes its picture, and lists what is wrong with it.
fn look<W: std::io::Write>(
    page: &mut DevTools<W>,
    url: &str,
    (_, width, height, mobile): (&str, u32, u32, bool),
    scheme: &str,
    picture: &Path,
) -> Result<Vec<String>> {
    page.open_page()?;
    for domain in ["Page", "Runtime", "Log", "Network"] {
        page.call(&format!("{domain}.enable"), json!({}))?;
    }
    let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile });
    page.call("Emulation.setDeviceMetricsOverride", metrics)?;
    let media = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
    page.call("Emulation.setEmulatedMedia", media)?;
    page.call("Page.navigate", json!({ "url": url }))?;
    page.wait_for("Page.loadEventFired")?;
    // Two frames on, scripts that draw have drawn.
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(0))))")?;

    let shot = json!({ "captureBeyondViewport": true });
    let shot = page.call("Page.captureScreenshot", shot)?;
    fs::write(picture, BASE64_STANDARD.decode(shot["data"].as_str().unwrap_or_default())?)?;

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
    // Last, so that what the page did meanwhile counts as well.
    faults.extend(page.events.iter().filter_map(|event| fault_of(event, url)));
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

/// What an event says is wrong: an error in the console, or a request for anything but the page itself.
fn fault_of(event: &Value, url: &str) -> Option<String> {
    let told = &event["params"];
    match event["method"].as_str()? {
        "Runtime.exceptionThrown" => Some(format!("exception: {}", told["exceptionDetails"]["text"])),
        "Runtime.consoleAPICalled" if told["type"] == "error" || told["type"] == "assert" => {
            Some(format!("console: {}", told["args"]))
        }
        "Log.entryAdded" if told["entry"]["level"] == "error" => Some(format!("log: {}", told["entry"]["text"])),
        "Network.requestWillBeSent" => {
            let asked = told["request"]["url"].as_str().unwrap_or_default();
            (asked != url && !asked.starts_with("data:")).then(|| format!("request for {asked}"))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_may_load_itself_and_what_it_carries_and_nothing_else() {
        let asks = |asked: &str| {
            let event = json!({ "method": "Network.requestWillBeSent", "params": { "request": { "url": asked } } });
            fault_of(&event, "file:///report.html")
        };
        assert_eq!(asks("file:///report.html"), None);
        assert_eq!(asks("data:image/svg+xml,x"), None);
        assert!(asks("file:///style.css").is_some());
        assert!(asks("https://example.org/font.woff2").is_some());
    }

    #[test]
    fn console_errors_count_and_other_lines_do_not() {
        let says = |kind: &str| {
            fault_of(&json!({ "method": "Runtime.consoleAPICalled", "params": { "type": kind, "args": [] } }), "")
        };
        assert!(says("error").is_some());
        assert!(says("log").is_none());
        assert!(fault_of(&json!({ "method": "Page.loadEventFired", "params": {} }), "").is_none());
    }
}
