//! `zerorate calibrate`.

mod acquisition;
mod bar;
mod dry_run;
mod instrument;
mod looked_on;
mod many;
mod operator;
mod page;
mod real;
mod schedule;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use zerorate_bench::board::emulated_bench;
use zerorate_bench::calibrate::calibrate;
use zerorate_bench::calibrated::Unit;
use zerorate_bench::checkpoint::Keep;
use zerorate_bench::choice::DeviceChoice;
use zerorate_bench::error::BenchError;
use zerorate_bench::instruments::Bench;
use zerorate_bench::output;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::results;
use zerorate_bench::run::Progress as _;
use zerorate_bench::setup::SetUp;
use zerorate_board_run::summary::Summary;
use zerorate_cal::quality::Verdict;
use zerorate_live::Listen;
use zerorate_words::sentence;

use self::acquisition::Acquisition;
use self::bar::Bar;
use self::dry_run::RampsOf;
use self::instrument::Instrument;
use self::looked_on::LookedOn;
use self::operator::AtTerminal;
use self::real::Instruments;
use super::{Outcome, unless_gone};
use crate::looking_on::{self, LookingOn};
use crate::notify::Notice;
use crate::plant::Plant;
use crate::screen;
use crate::{interrupt, labels};

/// Run the whole experiment, simulated or on a real board: ramp, fit, trim, compensate, verify, report
///
/// Takes a unit through the experiment of Wu, Wang and Tang (2012): soak at the cold end, record one heating ramp (and, if the set-up says so, the way
/// back), fit the drift, find in 21 steps of a fine supply how the potentiometer moves the reading, compose the two, put
/// the law on the device, and prove it on a second ramp - once with the potentiometer alone, once with the rest
/// subtracted in numbers - heating and cooling, and with the axes swapped. Eleven soaks, the traditional test, are run
/// beside it to compare with.
///
/// On a real board a person is at the chamber, the supply and the switch: told what to do, and watched by the board's own
/// temperature reading. Or chamber and supply obey by themselves, by Modbus or SCPI: then nobody needs to be there, and at
/// every end - done, error, Ctrl-C - the chamber is sent to its safe set point and stopped, and the supply is off. A second
/// Ctrl-C ends the program at once and leaves them as they are. Before it begins the run says its steps, how long each takes and when the last ends. Ctrl-C stops
/// such a run, --resume goes on after what was finished; a step whose result cannot be used is run again.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Calibrate {
    /// Write the results into this folder; earlier ones stay until the run is whole
    #[arg(long, value_name = "DIR", default_value = "calibration")]
    out: PathBuf,

    /// Write over the results of another unit that are in the folder, or over files that no run has left; a simulated run
    /// never writes over a real unit's
    #[arg(long)]
    force: bool,

    /// The board: native (the application in this program), emulated (the firmware in QEMU; the results are the same to
    /// the last bit), serial:PATH or tcp:HOST:PORT. Given several times: real boards in one chamber, which goes on when all are
    /// done where it is; the results of each are in a folder of its serial number in --out, and one that fails leaves the others
    /// running
    #[arg(long = "device", value_name = "DEVICE", default_values_t = [DeviceChoice::Native])]
    devices: Vec<DeviceChoice>,

    /// The chamber: manual (a person is told), modbus-tcp:HOST:PORT, modbus-rtu:PATH, scpi:HOST:PORT or scpi:PATH, with the
    /// controller in the set-up; without it simulated with a simulated board, manual with a real one
    #[arg(long, value_name = "INSTRUMENT")]
    chamber: Option<Instrument>,

    /// The fine supply and the voltmeter: manual, scpi:HOST:PORT or scpi:PATH; without it simulated with a
    /// simulated board, manual with a real one. Of several boards one for each, in their order, or one that is wired to all and used by one after the other
    #[arg(long = "supply", value_name = "INSTRUMENT")]
    supplies: Vec<Instrument>,

    /// Say the plan - steps, how long each takes, how fast the ramps are, when it ends - and what the instruments answer, and do
    /// nothing
    #[arg(long)]
    dry_run: bool,

    /// Run this command by the shell at the end, however it ends: ZERORATE_RESULT is passed, rejected, stopped or failed,
    /// ZERORATE_MESSAGE a sentence, ZERORATE_OUT the folder
    #[arg(long, value_name = "CMD")]
    notify: Option<String>,

    /// Serve a page that shows the run as it goes: at 127.0.0.1:5495, or ADDRESS:PORT of this machine (port 0: any free one).
    /// Beyond this machine its address has a token in it, which it prints. Of several boards this page shows where each of them is, and each has one of its own, at the ports after it
    #[arg(long, value_name = "ADDRESS:PORT", num_args = 0..=1, default_missing_value = looking_on::HERE)]
    live: Option<Listen>,

    /// Go on with a run on a real board that was stopped: what was finished is not repeated
    #[arg(long)]
    resume: bool,

    /// The simulated board
    #[arg(long, value_enum, default_value_t = Plant::Paper)]
    plant: Plant,

    /// The seed that everything in the simulated board is drawn from
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// What stands between the simulated A/D and the processor; the results are the same but for less than the noise
    #[arg(long, value_enum, default_value_t = Acquisition::Port)]
    acquisition: Acquisition,

    /// The firmware for `--device emulated`; without it what `cargo xtask firmware` has built
    #[arg(long, value_name = "FILE")]
    firmware: Option<PathBuf>,

    /// The set-up file of board and bench; without it the plant's own (see `zerorate setup`)
    #[arg(long, value_name = "FILE")]
    setup: Option<PathBuf>,

    /// The unit's serial number, up to 32 bytes; without it the board's own, and ZR-0001 for a simulated one
    #[arg(long, value_name = "S", value_parser = NonEmptyStringValueParser::new())]
    serial: Option<String>,

    /// Print JSON on standard output (the same as summary.json), and nothing else there
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  zerorate calibrate
      the paper's board; open calibration/report.html afterwards
  zerorate calibrate --plant typical --seed 7 --out unit-7 --serial ZR-0007
  zerorate calibrate --device emulated
      the same by the firmware in QEMU (build it by `cargo xtask firmware`)
  zerorate setup > bench.toml; zerorate calibrate --setup bench.toml
      the limits that a unit must pass are in the set-up
  zerorate calibrate --device serial:/dev/ttyUSB0 --chamber manual --supply manual --setup bench.toml
      a real board; soaks_c = [] in the set-up leaves out the soaks, which take 13 of the 28 hours
  zerorate setup --controller watlow-f4t > night.toml
  zerorate calibrate --device serial:/dev/ttyUSB0 --chamber modbus-tcp:10.0.0.7:502 --supply scpi:10.0.0.8:5025 \\
      --setup night.toml --dry-run
      the plan of a night, and whether chamber and supply answer; without --dry-run it begins
  zerorate calibrate --device serial:/dev/ttyUSB0 --device serial:/dev/ttyUSB1 --chamber modbus-tcp:10.0.0.7:502 \\
      --supply scpi:10.0.0.8:5025 --setup night.toml --out lot-7
      two boards in one chamber; lot-7 has a folder for each serial number
  zerorate calibrate ... --live 0.0.0.0:5495
      the run as it goes, on a telephone in the same network: open the address that it prints
  zerorate calibrate ... --notify 'curl -d \"$ZERORATE_MESSAGE\" https://ntfy.sh/my-bench'

Exit codes: 0 the unit passed; 1 it was rejected, with reasons; 2 error.";

impl Calibrate {
    /// How it ended, and what is told of that to whom it may concern.
    pub fn run(&self) -> (Result<Outcome>, Option<Notice>) {
        let end = self.carry_through();
        let notice = self.notify.clone().filter(|_| !self.dry_run).map(|command| {
            let (result, message) = self.told(&end);
            Notice { command, result, message, out: self.out.clone() }
        });
        let outcome = end.map(|end| match end {
            End::Planned | End::Carried(Verdict::Good | Verdict::Warning) => Outcome::Done,
            End::Carried(Verdict::Rejected) => Outcome::Rejected,
            End::NotAll(_) => Outcome::Failed,
        });
        (outcome, notice)
    }

    /// What is told of an end: a word for programs, and a sentence.
    fn told(&self, end: &Result<End>) -> (&'static str, String) {
        let of_several = self.devices.len() > 1;
        let out = self.out.display();
        let stopped = if interrupt::was_asked_for() { "stopped" } else { "failed" };
        match end {
            Ok(End::Carried(worst)) => {
                let result = if *worst == Verdict::Rejected { "rejected" } else { "passed" };
                let message = match worst {
                    verdict if !of_several => format!("the unit {}; the report is in {out}", words(*verdict)),
                    Verdict::Good => format!("all units passed; the reports are in {out}"),
                    Verdict::Warning => format!("all units passed, not all without warnings; the reports are in {out}"),
                    Verdict::Rejected => format!("not all units passed; the reports are in {out}"),
                };
                (result, message)
            }
            Ok(End::NotAll(which)) => {
                (stopped, format!("not all runs came to their end: {which}; what there is is in {out}"))
            }
            // Of a plan nobody is told.
            Ok(End::Planned) => ("planned", String::new()),
            Err(error) => (stopped, sentence(error.as_ref())),
        }
    }

    fn carry_through(&self) -> Result<End> {
        let kind = self.plant.kind();
        let setup = match &self.setup {
            Some(file) => SetUp::read(file)?,
            None => kind.setup(),
        };
        labels::tell_doubts(&setup.labels);
        ensure!(
            !self.resume || self.out.exists(),
            "--resume: there is no {}, and so no run to go on with: give its folder (--out), or leave --resume out to begin one",
            self.out.display()
        );
        let device = match &self.devices[..] {
            [one] => {
                output::refuse_where_a_run_goes_on(&self.out)?;
                one
            }
            several => return self.run_many(several, &setup),
        };
        if device.is_real() {
            return self.run_real(device, &setup);
        }
        ensure!(!self.resume, "--resume is for a real board: a simulated run is over in seconds, run it again");
        let others = self.chamber.iter().chain(&self.supplies).any(|own| *own != Instrument::Simulated);
        ensure!(
            !others,
            "the board is simulated, and so are its chamber and supply: name a real board by --device, or leave --chamber and --supply out"
        );
        if self.dry_run {
            dry_run::print(&setup, RampsOf::Simulated(kind), &[], None, self.json)?;
            return Ok(End::Planned);
        }
        let unit = Unit::new(self.serial.as_deref().unwrap_or("ZR-0001"), Some((kind, self.seed)))?;
        let mut bench = self.bench(device, kind, &setup, &unit)?;
        let live = self.looking_on(&setup, &unit)?;
        let run = Run { setup: &setup, out: &self.out, live, keep: Keep::Nothing };
        self.end_with(&self.carry_out(&mut bench, run, unit, Bar::new(&setup))?, &setup)
    }

    /// A real board, and a person or instruments about it.
    fn run_real(&self, choice: &DeviceChoice, setup: &SetUp) -> Result<End> {
        let [chamber, supply] =
            [self.chamber.as_ref(), self.supplies.first()].map(|own| own.unwrap_or(&Instrument::Manual));
        ensure!(self.supplies.len() < 2, "--supply was given more often than --device: a board has one");
        let mut instruments = Instruments::open(chamber, supply, setup)?;
        let mut device = choice.open()?.context("a real board has a line")?;
        let identity = device.identify()?;
        let own = identity.unit.as_str();
        let serial = match (&self.serial, own) {
            (None, "") => bail!("the board has no serial number of its own: give its one with --serial"),
            (None, own) => own,
            (Some(given), own) if own.is_empty() || given == own => given,
            (Some(given), own) => {
                bail!("--serial {given}: the board says that it is {own}, and would refuse the calibration")
            }
        };
        let unit = Unit::new(serial, None)?;
        if self.dry_run {
            instruments.found.push(format!("the board at {choice} is {serial}"));
            let stopped = dry_run::stopped(&self.out, self.resume);
            dry_run::print(setup, RampsOf::Real, &instruments.found, stopped.as_deref(), self.json)?;
            return Ok(End::Planned);
        }
        interrupt::watch()?;
        let setup = &instruments.named_in(setup);
        let mut bar = Bar::without_end();
        instruments.found.iter().for_each(|found| bar.note(found));
        let mut bench = instruments.bench(device, || AtTerminal::new(bar.bar.clone()))?;
        let run = Run { setup, out: &self.out, live: self.looking_on(setup, &unit)?, keep: self.keep() };
        self.end_with(&self.carry_out(&mut bench, run, unit, bar)?, setup)
    }

    fn keep(&self) -> Keep {
        if self.resume { Keep::Resume } else { Keep::Anew }
    }

    fn looking_on(&self, setup: &SetUp, unit: &Unit) -> Result<Option<LookingOn>> {
        self.live
            .as_ref()
            .map(|listen| LookingOn::open(listen, &looking_on::calibration(&unit.serial), setup))
            .transpose()
    }

    fn carry_out(&self, bench: &mut Bench, run: Run, unit: Unit, bar: Bar) -> Result<Summary> {
        let result = self.seen(bench, &run, unit, bar);
        if let Some(live) = run.live {
            live.end(match &result {
                Ok(summary) => format!("The unit {}; the report says how.", words(summary.verdict)),
                Err(error) => format!("It ended before it was done: {}.", sentence(error.as_ref())),
            });
        }
        result
    }

    /// The run, while others may look on.
    fn seen(&self, bench: &mut Bench, run: &Run, unit: Unit, mut bar: Bar) -> Result<Summary> {
        let Run { setup, out, live, keep } = run;
        results::refuse_others(out, &unit, self.force)?;
        setup.unreachable().iter().for_each(|sentence| bar.note(sentence));
        if let Some(live) = live {
            bar.note(&live.told());
        }
        let mut progress = LookedOn::new(&mut bar, setup, RampsOf::unit(&unit), live.as_ref());
        let mut result = calibrate(bench, setup, unit.clone(), out, &mut progress, *keep);
        // At night nobody is there to go on.
        if let Err(error @ BenchError::OffCourse) = &result {
            progress.note(&format!("{error}; it is run again, once"));
            result = calibrate(bench, setup, unit, out, &mut progress, Keep::Resume);
        }
        bar.finish();
        result.map_err(|error| with_what_is_left(error, out, *keep))
    }

    /// The result is said; who does not hear it to its end has it in the folder.
    fn end_with(&self, summary: &Summary, setup: &SetUp) -> Result<End> {
        let said = if self.json { screen::print_json(summary) } else { page::page(summary, &self.out, setup).print() };
        unless_gone(said)?;
        Ok(End::Carried(summary.verdict))
    }

    fn bench(&self, device: &DeviceChoice, kind: PlantKind, setup: &SetUp, unit: &Unit) -> Result<Bench> {
        match device {
            DeviceChoice::Native => self.acquisition.bench(kind, self.seed, setup, unit),
            DeviceChoice::Emulated if self.acquisition != Acquisition::Port => {
                bail!("the emulated board has an acquisition port: leave --acquisition out")
            }
            DeviceChoice::Emulated => {
                Ok(emulated_bench(kind.build(self.seed), setup, &unit.serial, self.firmware.as_deref())?)
            }
            other => bail!("{other} cannot stand on the simulated bench: give native or emulated"),
        }
    }
}

/// How all that was asked for has ended.
enum End {
    /// Nothing but the plan was asked for.
    Planned,
    /// Everything was carried through, and this is the worst verdict.
    Carried(Verdict),
    /// Of several units' runs not all came to their end: which, and why.
    NotAll(String),
}

/// What a verdict makes of a unit.
const fn words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Good => "passed",
        Verdict::Warning => "passed, with warnings",
        Verdict::Rejected => "was rejected",
    }
}

/// One unit's run.
struct Run<'a> {
    setup: &'a SetUp,
    out: &'a Path,
    live: Option<LookingOn>,
    keep: Keep,
}

fn with_what_is_left(error: BenchError, out: &Path, keep: Keep) -> anyhow::Error {
    if error.is_refused() {
        // It says itself what there is, and from when.
        return error.into();
    }
    if matches!(error, BenchError::DoneLeftOn(_)) {
        let done = format!("the results are in {}", out.display());
        return anyhow::Error::from(error).context(done);
    }
    let kept = out.join(zerorate_bench::output::IN_PROGRESS);
    let left = if kept.is_dir() {
        let go_on = match keep {
            Keep::Nothing => "",
            _ if error.is_interrupted() => "; the same with --resume goes on after what was finished",
            _ => "; once the cause is mended, the same with --resume goes on with the step that failed",
        };
        format!("the run stopped; what it had recorded is in {}{go_on}", kept.display())
    } else {
        "the run ended before it had recorded anything".into()
    };
    match error {
        // Somebody has to go there: that comes first.
        BenchError::LeftOn { first, left_on } => anyhow::Error::from(*first).context(left).context(left_on.to_string()),
        error => anyhow::Error::from(error).context(left),
    }
}

#[cfg(test)]
mod tests {
    use zerorate_bench::instruments::InstrumentError;
    use zerorate_words::sentence;

    use super::*;

    /// A telephone shows the first words of a message.
    #[test]
    fn what_is_left_on_comes_first() {
        let left_on = InstrumentError::Power("it is on: GO THERE".to_owned());
        let error = BenchError::LeftOn { first: Box::new(InstrumentError::Interrupted.into()), left_on };
        let folder = tempfile::tempdir().unwrap();
        let told = sentence(with_what_is_left(error, folder.path(), Keep::Resume).as_ref());
        let places = ["GO THERE", "the run ended before it had recorded anything", "stopped by Ctrl-C"];
        let places = places.map(|part| told.find(part).unwrap_or_else(|| panic!("{part} is missing from: {told}")));
        assert!(places.is_sorted() && told.starts_with("the board does not come up"), "{told}");
    }
}
