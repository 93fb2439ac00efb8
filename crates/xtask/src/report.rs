//! Opens the reports of a calibration and of a log as their reader would: on a desktop and on a phone, in light and in dark.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use crate::browser::Browser;
use crate::devtools::{DevTools, SCREENS, Screen};
use crate::faults;
use crate::live;
use crate::provide;
use crate::steps::Outcome;
use crate::workspace::Workspace;

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
    faults.extend(live::look(workspace, &mut browser.devtools, &pictures)?);
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
    let Some(recording) = workspace.recording() else { return Ok(None) };
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
    screen: Screen,
    scheme: &str,
    picture: &Path,
) -> Result<Vec<String>> {
    page.open_page()?;
    page.go_to(url, screen, scheme)?;
    page.photograph(picture)?;
    let mut faults = faults::shown(page, screen)?;
    // Last, so that what the page did meanwhile counts as well.
    faults.extend(page.events.iter().filter_map(|event| faults::of(event, url)));
    Ok(faults)
}
