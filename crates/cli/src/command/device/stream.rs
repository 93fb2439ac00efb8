//! `zerorate device stream`.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde::Serialize;
use zerorate_bench::scan_line::{HeardScan, ScanFlags, ScanLine};
use zerorate_report::number::counted;

use super::Device;
use crate::command::Outcome;
use crate::interrupt;
use crate::screen;

/// How often Ctrl-C is looked for while no scan comes.
const LOOK_EVERY: Duration = Duration::from_millis(200);
/// A line on which nothing is heard for so long is no second line of a board at work.
const SILENCE: Duration = Duration::from_secs(5);

/// Show each scan of a board's second line as it comes, corrected: a line of CSV each
///
/// It is the line that a control loop reads (docs/scan-line.md has its bytes), and --port names that line: a board's PB6 behind a
/// serial adapter, 460800 baud unless another rate is named. Nothing is said on it; the board sends while its acquisition runs. x
/// and y are counts; the flags beside them are the mode and, where they apply, at_work, held, outside, uncertain, settling,
/// saturated. Scans that were missed are told on standard error. Ctrl-C ends it.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Stream {
    /// End after so many scans
    #[arg(long, value_name = "N")]
    scans: Option<u32>,

    /// Microseconds from scan to scan, as `device info` says it: what makes a time of a scan's number
    #[arg(long, value_name = "US", default_value_t = 3000)]
    scan_period_us: u32,
}

const EXAMPLES: &str = "\
Examples:
  zerorate device --port serial:/dev/ttyUSB1 stream > scans.csv
  zerorate device --port serial:/dev/ttyUSB1@921600 stream --scans 20000 --json > scans.jsonl
  zerorate virtual-board --on tcp:127.0.0.1:5494 --scans-on tcp:127.0.0.1:5495     a board to try it on";

impl Stream {
    pub fn run(&self, device: &Device) -> Result<Outcome> {
        ensure!(self.scan_period_us > 0, "--scan-period-us 0: give the time from scan to scan");
        let port = device.port.as_ref().context("say which line: --port serial:PATH or tcp:HOST:PORT")?;
        let mut line = ScanLine::open(port)?;
        interrupt::watch()?;
        if !device.json {
            screen::print("scan,time_s,x_counts,x_flags,y_counts,y_flags\n")?;
        }
        let (mut shown, mut quiet) = (0, Duration::ZERO);
        while self.scans.is_none_or(|scans| shown < scans) && !interrupt::was_asked_for() {
            let Some(scan) = line.next(LOOK_EVERY)? else {
                quiet += LOOK_EVERY;
                ensure!(
                    quiet < SILENCE,
                    "no scan within {} s: is this the board's second line, its rate right, and its acquisition running?",
                    SILENCE.as_secs()
                );
                continue;
            };
            quiet = Duration::ZERO;
            self.show(&scan, device.json)?;
            shown += 1;
        }
        if line.damaged() > 0 {
            screen::note(&counted(line.damaged() as usize, "damaged frame"));
        }
        Ok(Outcome::Done)
    }

    fn show(&self, scan: &HeardScan, json: bool) -> Result<()> {
        let shown = Shown::of(scan, self.scan_period_us);
        if scan.missed > 0 {
            let scans = counted(scan.missed as usize, "scan");
            screen::note(&format!("{scans} before scan {} did not arrive", shown.scan));
        }
        if json {
            return screen::print(&(serde_json::to_string(&shown)? + "\n"));
        }
        let Shown { scan, time_s, x, y } = shown;
        let axis = |axis: &ShownAxis| format!("{:.4},{}", axis.counts, axis.flags.join(" "));
        screen::print(&format!("{scan},{time_s:.6},{},{}\n", axis(&x), axis(&y)))
    }
}

/// A scan as it is shown.
#[derive(Debug, Serialize)]
struct Shown {
    scan: u32,
    time_s: f64,
    x: ShownAxis,
    y: ShownAxis,
}

#[derive(Debug, Serialize)]
struct ShownAxis {
    counts: f64,
    flags: Vec<&'static str>,
}

impl Shown {
    fn of(scan: &HeardScan, period_us: u32) -> Self {
        let [x, y] = scan.report.axes.map(|axis| ShownAxis { counts: axis.counts(), flags: words(axis.flags) });
        Self { scan: scan.report.scan, time_s: f64::from(scan.report.scan) * f64::from(period_us) * 1e-6, x, y }
    }
}

/// The mode, and the flags that are set.
fn words(flags: ScanFlags) -> Vec<&'static str> {
    let named = [
        (ScanFlags::AT_WORK, "at_work"),
        (ScanFlags::HELD, "held"),
        (ScanFlags::OUTSIDE, "outside"),
        (ScanFlags::UNCERTAIN, "uncertain"),
        (ScanFlags::SETTLING, "settling"),
        (ScanFlags::SATURATED, "saturated"),
    ];
    let set = named.into_iter().filter(|&(flag, _)| flags.has(flag)).map(|(_, name)| name);
    std::iter::once(flags.mode().name()).chain(set).collect()
}
