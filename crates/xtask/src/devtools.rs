//! The DevTools protocol over a pair of pipes: JSON messages, a zero byte after each.
//!
//! Source: Chromium's `--remote-debugging-pipe`. Pipes need no port, no web socket and no handshake.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

/// A screen: name, width and height in CSS pixels, whether it is a phone's.
pub type Screen = (&'static str, u32, u32, bool);

/// Those on which pages are looked at.
pub const SCREENS: [Screen; 2] = [("desktop", 1280, 900, false), ("phone", 390, 844, true)];

/// Longer than any answer should take; a browser that is silent for so long is stuck.
const PATIENCE: Duration = Duration::from_secs(600);

/// One conversation with a browser.
pub struct DevTools<W> {
    to: W,
    from: Receiver<Value>,
    last_id: u64,
    session: Option<String>,
    /// What the page has told of unasked, oldest first.
    pub events: Vec<Value>,
}

impl<W: Write> DevTools<W> {
    /// A conversation on the two ends of the browser's pipes.
    pub fn new(to: W, from: impl Read + Send + 'static) -> Self {
        let (sender, receiver) = mpsc::channel();
        // Reading blocks for ever when a browser is stuck: it has a thread, and we wait on the channel with patience.
        thread::spawn(move || {
            for message in BufReader::new(from).split(0).map_while(std::result::Result::ok) {
                let Ok(message) = serde_json::from_slice(&message) else {
                    continue;
                };
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        Self { to, from: receiver, last_id: 0, session: None, events: Vec::new() }
    }

    /// Opens an empty page and talks to it from now on; what the page before it told is forgotten.
    pub fn open_page(&mut self) -> Result<()> {
        self.session = None;
        let page = self.call("Target.createTarget", json!({ "url": "about:blank" }))?;
        let attached = self.call("Target.attachToTarget", json!({ "targetId": page["targetId"], "flatten": true }))?;
        self.session = Some(attached["sessionId"].as_str().context("the browser gave no session")?.to_owned());
        self.events.clear();
        Ok(())
    }

    /// Goes to an address on a screen, in a colour scheme, and waits until what is there has drawn itself.
    pub fn go_to(&mut self, url: &str, (_, width, height, mobile): Screen, scheme: &str) -> Result<()> {
        for domain in ["Page", "Runtime", "Log", "Network"] {
            self.call(&format!("{domain}.enable"), json!({}))?;
        }
        let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile });
        self.call("Emulation.setDeviceMetricsOverride", metrics)?;
        let media = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        self.call("Emulation.setEmulatedMedia", media)?;
        self.call("Page.navigate", json!({ "url": url }))?;
        self.wait_for("Page.loadEventFired")?;
        // Two frames on, scripts that draw have drawn.
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(0))))")?;
        Ok(())
    }

    /// Takes a picture of the whole page.
    pub fn photograph(&mut self, picture: &Path) -> Result<()> {
        let shot = self.call("Page.captureScreenshot", json!({ "captureBeyondViewport": true }))?;
        fs::write(picture, BASE64_STANDARD.decode(shot["data"].as_str().unwrap_or_default())?)?;
        Ok(())
    }

    /// Asks the whole browser to end.
    pub fn close_browser(&mut self) -> Result<()> {
        self.session = None;
        self.call("Browser.close", json!({})).map(|_| ())
    }

    /// Calls a method and waits for its result.
    pub fn call(&mut self, method: &str, parameters: Value) -> Result<Value> {
        self.last_id += 1;
        let id = self.last_id;
        let mut request = json!({ "id": id, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            request["sessionId"] = json!(session);
        }
        let mut bytes = serde_json::to_vec(&request)?;
        bytes.push(0);
        self.to.write_all(&bytes).and_then(|()| self.to.flush()).context("the browser closed its pipe")?;
        loop {
            let mut message = self.next(method)?;
            if message["id"] != id {
                self.events.push(message);
            } else if let Some(error) = message.get("error") {
                bail!("{method}: {}", error["message"].as_str().unwrap_or("refused"));
            } else {
                return Ok(message["result"].take());
            }
        }
    }

    /// Waits until the page has told of `event`.
    pub fn wait_for(&mut self, event: &str) -> Result<()> {
        while !self.events.iter().any(|told| told["method"] == event) {
            let message = self.next(event)?;
            self.events.push(message);
        }
        Ok(())
    }

    /// The value of a JavaScript expression in the page; a promise is waited for.
    pub fn evaluate(&mut self, expression: &str) -> Result<Value> {
        let parameters = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut answer = self.call("Runtime.evaluate", parameters)?;
        if answer.get("exceptionDetails").is_some() {
            bail!("`{expression}` threw: {}", answer["exceptionDetails"]["exception"]["description"]);
        }
        Ok(answer["result"]["value"].take())
    }

    fn next(&self, awaited: &str) -> Result<Value> {
        self.from.recv_timeout(PATIENCE).with_context(|| format!("the browser ended or is stuck before {awaited}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(messages: &[Value]) -> std::io::Cursor<Vec<u8>> {
        let bytes = messages.iter().flat_map(|message| [message.to_string().into_bytes(), vec![0]].concat());
        std::io::Cursor::new(bytes.collect())
    }

    #[test]
    fn what_comes_before_an_answer_is_kept_as_an_event() {
        let answers = told(&[json!({ "method": "Page.loaded" }), json!({ "id": 1, "result": { "value": 7 } })]);
        let mut sent = Vec::new();
        let mut browser = DevTools::new(&mut sent, answers);
        assert_eq!(browser.call("Page.ask", json!({})).unwrap(), json!({ "value": 7 }));
        browser.wait_for("Page.loaded").unwrap();
        assert_eq!(sent.last(), Some(&0));
    }

    #[test]
    fn a_refusal_and_an_end_are_errors_that_name_the_method() {
        let answers = told(&[json!({ "id": 1, "error": { "message": "no such method" } })]);
        let mut browser = DevTools::new(Vec::new(), answers);
        assert_eq!(browser.call("Page.ask", json!({})).unwrap_err().to_string(), "Page.ask: no such method");
        assert!(browser.call("Page.again", json!({})).unwrap_err().to_string().contains("Page.again"));
    }
}
