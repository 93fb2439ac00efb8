//! `zerorate chamber`.

mod progress;

use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use anyhow::Result;
use clap::Args;
use zerorate_bench::instruments::{Chamber as _, InstrumentError, rest_for};
use zerorate_bench::profile::{Pace, Profile, Seconds, drive};
use zerorate_bench::remote::{Address, Found, RemoteChamber};
use zerorate_bench::setup::SetUp;
use zerorate_cal::recording::{ChamberInfo, ChamberWriter};
use zerorate_words::sentence;

use self::progress::{Told, plan};
use super::Outcome;
use crate::notify::Notice;
use crate::screen::Page;
use crate::{interrupt, labels, output, screen};

/// Run a chamber through a profile, beside boards that log by themselves, and record where its air was
///
/// A profile is a text file, a line for each ramp, soak or group of cycles; --example prints one. The chamber's registers and its
/// limits are in the set-up, as for `calibrate`. Every second the air's temperature is recorded, with the time of day: `fit
/// LOG --chamber RECORDING` joins it to a log that has the time of day as well.
///
/// A chamber that does not answer is waited for: soaks and ramps stand still meanwhile. At every end - done, error, Ctrl-C -
/// it is sent to its safe set point and stopped, and what was recorded is kept. A second Ctrl-C ends the program at once and leaves the
/// chamber as it is.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Chamber {
    /// The profile
    #[arg(value_name = "PROFILE", required_unless_present = "example")]
    profile: Option<PathBuf>,

    /// The chamber: modbus-tcp:HOST:PORT, modbus-rtu:PATH, scpi:HOST:PORT or scpi:PATH
    #[arg(long, value_name = "ADDRESS", required_unless_present = "example")]
    chamber: Option<Address>,

    /// The set-up with the chamber's controller and limits: `zerorate setup --controller watlow-f4t` prints one
    #[arg(long, value_name = "FILE", required_unless_present = "example")]
    setup: Option<PathBuf>,

    /// Write the recording here; without it named after the profile, as night.parquet
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    #[command(flatten)]
    force: output::Force,

    /// Say the plan - steps, how long each takes, when it ends - and what the chamber answers, and do nothing
    #[arg(long)]
    dry_run: bool,

    /// Run this command by the shell at the end, however it ends: ZERORATE_RESULT is done, stopped or failed, ZERORATE_MESSAGE a
    /// sentence, ZERORATE_OUT the recording
    #[arg(long, value_name = "CMD")]
    notify: Option<String>,

    /// Print a profile to begin with, and do nothing
    #[arg(long)]
    example: bool,
}

const EXAMPLES: &str = "\
Examples:
  zerorate chamber --example > night.toml
  zerorate setup --controller watlow-f4t > bench.toml
  zerorate chamber night.toml --chamber modbus-tcp:10.0.0.7:502 --setup bench.toml --dry-run
      the plan, and whether the chamber answers; without --dry-run it begins
  zerorate fit flight.ulg --chamber night.parquet
      the log of a board that lay in it, with the air beside its own temperature

Exit codes: 0 done; 2 error.";

impl Chamber {
    /// How it ended, and what is told of that to whom it may concern.
    pub fn run(&self) -> (Result<Outcome>, Option<Notice>) {
        let (Some(profile), Some(chamber), Some(setup)) = (&self.profile, &self.chamber, &self.setup) else {
            print!("{}", Profile::EXAMPLE);
            return (Ok(Outcome::Done), None);
        };
        let out = self
            .out
            .clone()
            .unwrap_or_else(|| Path::new(profile.file_stem().unwrap_or_default()).with_extension("parquet"));
        let result = self.carry_through(profile, chamber, setup, &out);
        let notice = self.notify.clone().filter(|_| !self.dry_run).map(|command| {
            let (result, message) = match &result {
                Ok(_) => ("done", format!("the profile is done; the recording is {}", out.display())),
                Err(error) if interrupt::was_asked_for() => ("stopped", sentence(error.as_ref())),
                Err(error) => ("failed", sentence(error.as_ref())),
            };
            Notice { command, result, message, out }
        });
        (result, notice)
    }

    fn carry_through(&self, profile: &Path, address: &Address, setup: &Path, out: &Path) -> Result<Outcome> {
        let setup = SetUp::read(setup)?;
        labels::tell_doubts(&setup.labels);
        let profile_file = profile;
        let profile = Profile::read(profile, setup.chamber.limits_c)?;
        output::check("--out", out, &[profile_file])?;
        self.force.recording("--out", out)?;
        let (mut chamber, Found { told, label }) = RemoteChamber::open(address, &setup)?;
        let times = profile.times(chamber.air()?, setup.ramp_rate());
        let plan = plan(&profile, &times);
        if self.dry_run {
            let mut page = Page::default();
            plan.iter().for_each(|line| page.sentence("", line));
            page.gap();
            page.sentence("", &format!("{told}. Nothing was moved or recorded."));
            page.print()?;
            return Ok(Outcome::Done);
        }
        interrupt::watch()?;
        plan.iter().for_each(|line| screen::note(line));
        screen::note(&told);
        let mut labels = setup.labels.clone();
        labels.entry("chamber".into()).or_insert(label);
        let info = ChamberInfo { started: SystemTime::now().into(), profile: profile.text.clone(), labels };
        let writer = ChamberWriter::create(out, &info)?;
        if let Some(aside) = writer.set_aside() {
            screen::note(&format!(
                "an earlier run to {} was ended before it could finish its recording: that is kept as {}, which `fit` takes as well",
                out.display(),
                aside.display()
            ));
        }
        let mut told = Told::new(&profile, times, writer);
        let driven = drive(&profile, &mut chamber, &mut WallClock::begin(), &mut told);
        let rested = chamber.rest(&|waited| waited < rest_for(interrupt::was_asked_for()));
        let written = told.finish();
        if let Err(error) = driven {
            let kept = match &written {
                Ok(file) => format!("what was recorded is in {}", file.display()),
                Err(error) => sentence(error),
            };
            let stopped = anyhow::Error::from(error).context(format!("the profile stopped; {kept}"));
            // Somebody has to go there: that comes first, in a message too.
            return Err(match rested {
                Ok(()) => stopped,
                Err(left_on) => stopped.context(left_on.to_string()),
            });
        }
        rested?;
        screen::note(&format!(
            "the profile is done, and the chamber is at rest; the recording is {}",
            written?.display()
        ));
        Ok(Outcome::Done)
    }
}

/// Time as it passes, in which Ctrl-C is heard.
struct WallClock(Instant);

/// How often it is looked whether Ctrl-C was pressed.
const LOOK_EVERY: Duration = Duration::from_millis(50);

impl WallClock {
    fn begin() -> Self {
        Self(Instant::now())
    }
}

impl Pace for WallClock {
    fn wait(&mut self, time: Seconds) -> Result<Seconds, InstrumentError> {
        let before = self.0;
        let until = before + Duration::from_secs_f64(time.0);
        loop {
            if interrupt::was_asked_for() {
                return Err(InstrumentError::Interrupted);
            }
            let now = Instant::now();
            if now >= until {
                self.0 = now;
                return Ok(Seconds(now.duration_since(before).as_secs_f64()));
            }
            thread::sleep(LOOK_EVERY.min(until - now));
        }
    }
}
