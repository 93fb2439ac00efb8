//! The page in a browser, opened from the disk: its numbers are the command's, and nothing leaves the machine.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Command};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};

use crate::browser::Browser;
use crate::devtools::{DevTools, SCREENS, Screen};
use crate::faults;
use crate::figures::difference::between;
use crate::python;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// The most that a page may take, kB.
const MOST_MEMORY_KB: u64 = 300_000;

/// A log so long that a page which kept it would be seen, bytes.
const LONG: u64 = 2_000_000_000;

/// Builds the page and tries it.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let page = super::build(workspace)?;
    let Some(recording) = workspace.recording() else {
        return Ok(Outcome::Skipped(
            "built, not tried: no ../shared/data, and ZERORATE_DATA names no other folder".into(),
        ));
    };
    let folder = workspace.target.join("web/logs");
    fs::create_dir_all(&folder)?;
    let [ulog, dataflash, csv] = python::encoded(workspace, &recording, &folder.join("chamber"), &[])?;
    let long = python::encoded(workspace, &recording, &folder.join("chamber-100"), &["--hz", "100"])?[0].clone();
    let url = format!("file://{}", page.canonicalize()?.display());
    let trial = Trial { workspace, url: &url, pictures: workspace.target.join("web-screenshots") };
    fs::create_dir_all(&trial.pictures)?;
    for (place, log) in [ulog, dataflash, csv].iter().enumerate() {
        trial.of_log(log, SCREENS[place % 2])?;
    }
    trial.of_log(&long, SCREENS[0])?;
    trial.of_damaged(&folder, &fs::read(&long)?)?;
    trial.of_fields(&folder)?;
    trial.of_very_long(&folder, &long)?;
    trial.of_rules()?;
    println!("    no request, no console error, no overflow; pictures in {}", trial.pictures.display());
    Ok(Outcome::Passed)
}

struct Trial<'a> {
    workspace: &'a Workspace,
    url: &'a str,
    pictures: PathBuf,
}

impl Trial<'_> {
    /// A browser with the page on a screen.
    fn open(&self, screen: Screen, scheme: &str) -> Result<Browser> {
        let mut browser = Browser::start(&self.workspace.target)?;
        browser.devtools.open_page()?;
        browser.devtools.go_to(self.url, screen, scheme)?;
        Ok(browser)
    }

    /// A log is fitted as the command fits it, and the page looks as it should.
    fn of_log(&self, log: &Path, screen: Screen) -> Result<()> {
        let name = log.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let began = Instant::now();
        let (code, printed) = self.command(log)?;
        let command_s = began.elapsed().as_secs_f64();
        ensure!(code == Some(0), "zerorate fit {name} ended with {code:?}");
        let mut browser = self.open(screen, "light")?;
        let memory = browser.memory();
        let page = &mut browser.devtools;
        let began = Instant::now();
        choose(page, log)?;
        let answered = answer(page)?;
        let page_s = began.elapsed().as_secs_f64();
        let fitted = &answered["answer"]["fitted"];
        ensure!(fitted.is_object(), "{name}: {}", answered["answer"]);
        let mut differences = between(&without_paths(printed), &without_paths(fitted["fit"].clone()));
        // A page writes 0.0 as 0.
        differences.retain(|difference| difference.relative() > 0.0);
        ensure!(
            differences.is_empty(),
            "{name}: the page's numbers are others: {}",
            differences.iter().take(10).map(ToString::to_string).collect::<Vec<_>>().join("; ")
        );
        let saved = page.evaluate("[...document.querySelectorAll('.save')].map(link => link.download)")?;
        let count = if name.ends_with("csv") { 2 } else { 3 };
        ensure!(saved.as_array().is_some_and(|saved| saved.len() == count), "{name}: to save there is {saved}");
        // The report has drawn itself, and the page has grown with it.
        let heading = page.evaluate(HEADING)?;
        ensure!(
            heading.as_str().is_some_and(|heading| heading.contains(&name)),
            "{name}: the report's heading is {heading}"
        );
        let wide = page.evaluate(WIDEST)?.as_f64().unwrap_or(f64::INFINITY);
        ensure!(wide <= f64::from(screen.1), "{name}: {wide} px wide on a screen of {} px", screen.1);
        page.photograph(&self.pictures.join(format!("{name}-{}.png", screen.0)))?;
        let faults: Vec<String> = page.events.iter().filter_map(|event| faults::of(event, self.url)).collect();
        ensure!(faults.is_empty(), "{name}: {}", faults.join("; "));
        let memory = memory.most_kb();
        println!(
            "    {name}: as the command, to the last bit; {:.1} times its time; {}",
            page_s / command_s,
            told_memory(memory)
        );
        ensure!(memory.is_none_or(|memory| memory <= MOST_MEMORY_KB), "{name}: {}", told_memory(memory));
        Ok(())
    }

    /// What the command says of a log that cannot be fitted, the page says.
    fn of_damaged(&self, folder: &Path, log: &[u8]) -> Result<()> {
        let damaged = folder.join("damaged.ulg");
        for (damage, bytes) in
            [("its head alone", &log[..200]), ("another file's bytes", &log[1000..9000]), ("nothing", &[])]
        {
            fs::write(&damaged, bytes)?;
            let (_, printed) = self.command(&damaged)?;
            let mut browser = self.open(SCREENS[1], "dark")?;
            let page = &mut browser.devtools;
            choose(page, &damaged)?;
            let answered = answer(page)?["answer"].take();
            // One that can be read in part is rejected, with reasons; any other is an error, with a sentence.
            let (said, told) = match printed["error"].as_str() {
                Some(said) => {
                    (json!(said.replace(&damaged.display().to_string(), "damaged.ulg")), page.evaluate(FAILURE)?)
                }
                None => (printed["reasons"].clone(), answered["fitted"]["fit"]["reasons"].clone()),
            };
            ensure!(told == said, "{damage}: the command says\n    {said}\nand the page\n    {told}");
            page.photograph(&self.pictures.join("damaged-phone.png"))?;
        }
        println!("    a damaged log gets the command's sentence");
        Ok(())
    }

    /// What can be asked for is told by the name that its field has.
    fn of_fields(&self, folder: &Path) -> Result<()> {
        let log = folder.join("columns.csv");
        let rows = (0..4000).map(|row| format!("{row},{},{}\n", 20.0 + f64::from(row) / 2000.0, row * 7919 % 101 + 1));
        let rows: String = rows.collect();
        for (heads, report, wanted) in [
            ("a,b,c", false, "say which (“Temperature column”)"),
            (
                "time_s,temperature_c,gyro_x_dps",
                true,
                "allow a narrow one in the fit of a log (“Accept a temperature span under 10 °C”)",
            ),
        ] {
            fs::write(&log, format!("{heads}\n{rows}"))?;
            let mut browser = self.open(SCREENS[0], "light")?;
            let page = &mut browser.devtools;
            choose(page, &log)?;
            answer(page)?;
            if report {
                page.evaluate(HEADING)?;
            }
            let told = page.evaluate(if report { REPORT } else { FAILURE })?;
            ensure!(told.as_str().is_some_and(|told| told.contains(wanted)), "{wanted}: the page says\n    {told}");
        }
        Ok(())
    }

    /// A very long log takes no more memory, and can be left in the middle.
    fn of_very_long(&self, folder: &Path, log: &Path) -> Result<()> {
        let very_long = folder.join("very-long.ulg");
        python::run(
            self.workspace,
            &[
                &self.workspace.root.join(python::SCRIPTS).join("long_log.py"),
                log,
                &very_long,
                Path::new(&LONG.to_string()),
            ],
        )?;
        let mut browser = self.open(SCREENS[0], "light")?;
        let memory = browser.memory();
        let page = &mut browser.devtools;
        choose(page, &very_long)?;
        page.evaluate("new Promise(done => { const look = () => /^Reading .* of 2.00 GB/.test(document.getElementById('doing').textContent) ? done(1) : setTimeout(look, 20); look(); })")?;
        page.evaluate("document.getElementById('cancel').click()")?;
        let gone = page.evaluate("!document.getElementById('work').checkVisibility() && worker === null")?;
        ensure!(gone == true, "the page works on after Cancel");
        let began = Instant::now();
        choose(page, &very_long)?;
        let answered = answer(page)?;
        ensure!(answered["answer"]["fitted"].is_object(), "2 GB: {}", answered["answer"]);
        let memory = memory.most_kb();
        println!("    2 GB: read in {:.0} s; {}", began.elapsed().as_secs_f64(), told_memory(memory));
        ensure!(memory.is_none_or(|memory| memory <= MOST_MEMORY_KB), "2 GB: {}", told_memory(memory));
        fs::remove_file(very_long)?;
        Ok(())
    }

    /// The browser keeps the page, and what works for it, from asking the network.
    fn of_rules(&self) -> Result<()> {
        let mut browser = self.open(SCREENS[0], "light")?;
        for (who, asks) in [("page", ASKS), ("worker", WORKER_ASKS)] {
            let refused = browser.devtools.evaluate(asks)?;
            ensure!(
                refused == "connect-src",
                "what asks the network in the {who} is refused by {refused}, not by connect-src"
            );
        }
        Ok(())
    }

    /// What the command makes of a log, as JSON; an error is JSON too.
    fn command(&self, log: &Path) -> Result<(Option<i32>, Value)> {
        let output = Command::new(self.workspace.zerorate()?).arg("fit").arg(log).arg("--json").output()?;
        let printed = serde_json::from_slice(&output.stdout);
        Ok((output.status.code(), printed.with_context(|| String::from_utf8_lossy(&output.stderr).into_owned())?))
    }
}

/// The heading of the report, once there is one and its frame is as high as it.
const HEADING: &str = "new Promise(done => {
    const look = () => {
        const report = document.getElementById('report');
        const page = report.contentDocument;
        const heading = page?.querySelector('h1');
        if (heading && report.clientHeight >= page.documentElement.scrollHeight) done(heading.textContent);
        else setTimeout(look, 50);
    };
    look();
})";

/// The sentence of an error, where it can be seen.
const FAILURE: &str = "(() => {
    const failure = document.getElementById('failure');
    return failure.checkVisibility() ? failure.textContent : null;
})()";

/// The report's words.
const REPORT: &str = "document.getElementById('report').contentDocument.body.innerText";

/// How wide the page is, or its report beyond its frame.
const WIDEST: &str = "(() => {
    const report = document.getElementById('report');
    const inside = report.contentDocument.documentElement;
    return document.documentElement.scrollWidth + Math.max(0, inside.scrollWidth - inside.clientWidth);
})()";

/// Asks the network, and tells which rule refused it.
const ASKS: &str = "new Promise(done => {
    addEventListener('securitypolicyviolation', event => done(event.effectiveDirective));
    fetch('http://127.0.0.1:9/').then(() => done('nothing'), () => setTimeout(() => done('nothing'), 1000));
})";

/// The same in a worker, made as the page makes its own.
const WORKER_ASKS: &str = "new Promise(done => {
    const asks = `addEventListener('securitypolicyviolation', event => postMessage(event.effectiveDirective));
        fetch('http://127.0.0.1:9/').then(() => postMessage('nothing'), () => setTimeout(() => postMessage('nothing'), 1000));`;
    new Worker(URL.createObjectURL(new Blob([asks]))).onmessage = ({ data }) => done(data);
})";

/// Gives the page a log, as by its field.
fn choose(page: &mut DevTools<ChildStdin>, log: &Path) -> Result<()> {
    let document = page.call("DOM.getDocument", json!({}))?;
    let field = json!({ "nodeId": document["root"]["nodeId"], "selector": "#files" });
    let field = page.call("DOM.querySelector", field)?;
    let files = json!({ "files": [log.canonicalize()?], "nodeId": field["nodeId"] });
    page.call("DOM.setFileInputFiles", files)?;
    Ok(())
}

/// What the page answers, once it does.
fn answer(page: &mut DevTools<ChildStdin>) -> Result<Value> {
    page.evaluate(
        "new Promise(done => { const look = () => answered ? done(answered) : setTimeout(look, 20); look(); })",
    )
}

/// What names a file by its folder is the command's alone.
fn without_paths(mut fit: Value) -> Value {
    fn strip(value: &mut Value) {
        match value {
            Value::String(text) if text.starts_with('/') => {
                *text = text.rsplit('/').next().unwrap_or_default().to_owned()
            }
            Value::Array(values) => values.iter_mut().for_each(strip),
            Value::Object(fields) => fields.values_mut().for_each(strip),
            _ => (),
        }
    }
    strip(&mut fit);
    fit
}

fn told_memory(kb: Option<u64>) -> String {
    kb.map_or_else(|| "memory unknown".to_owned(), |kb| format!("{} MB at most", kb / 1000))
}
