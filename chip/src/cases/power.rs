//! Power comes, records are committed, and how long it all takes.

use anyhow::{Result, bail, ensure};
use zerorate_core::units::{Axis, Celsius};
use zerorate_core::wire::{Answer, CalibrationState, Health, Request, ResetCause, SampleWindow};
use zerorate_sim::Fault;

use super::{Given, paper, wipers};
use crate::bench::Bench;
use crate::chip::rcc::Reset;
use crate::chip::time::{MILLISECOND, SECOND, Ticks, milliseconds};

/// The first set of a board alone has 50 scans, 3 ms apart; before it the board starts.
const FIRST_SET: Ticks = 150 * MILLISECOND;
const START: Ticks = 20 * MILLISECOND;
/// From scan to scan.
const SAMPLE_PERIOD: Ticks = 3 * MILLISECOND;

/// Without a record it answers, at the middle taps.
pub fn without_a_record(given: &Given) -> Result<String> {
    let mut bench = Bench::new(&given.image, paper(), None)?;
    // The clocks take the crystal's 2 ms; what is sent before is not heard.
    bench.pass(20 * MILLISECOND)?;
    let asked = bench.now();
    let identity = bench.identify()?;
    let took = bench.now() - asked;
    ensure!(identity.calibration == CalibrationState::Blank && !identity.running, "{identity:?}");
    ensure!(identity.reset == ResetCause::Power && wipers(&bench) == [511; 2], "{identity:?}");
    // A chip select that is low for a moment as its pin becomes an output.
    let empty = bench.machine.chip().board.empty_frames;
    ensure!(empty == 0, "{empty} selections without a clock");
    bench.nothing_wrong()?;
    Ok(format!(
        "who it is, {:.1} ms after the question, asked 20 ms after power; no chip select low without a clock",
        milliseconds(took)
    ))
}

/// A record is committed over the line, and in use after the next start.
pub fn commit(given: &Given) -> Result<String> {
    let mut bench = Bench::new(&given.image, paper(), None)?;
    bench.pass(20 * MILLISECOND)?;
    bench.identify()?;
    let began = bench.now();
    bench.deploy(&given.record)?;
    let took = bench.now() - began;
    let erased = bench.machine.chip().flash.erased;
    let sent_again = bench.sent_again;
    bench.power_cycle()?;
    bench.pass(100 * MILLISECOND)?;
    let identity = bench.identify()?;
    ensure!(identity.calibration == CalibrationState::InUse && identity.running, "{identity:?}");
    bench.deploy(&given.record)?;
    let again = bench.machine.chip().flash.erased - erased;
    ensure!(bench.resets(Reset::Watchdog) == 0, "the watchdog bit");
    bench.nothing_wrong()?;
    Ok(format!(
        "{:.0} ms with {erased} sector erased, {sent_again} commands sent again; in use after the next start; \
         a second one erased {again}",
        milliseconds(took)
    ))
}

/// With a record and no host, wipers follow from the first group.
pub fn alone(given: &Given) -> Result<String> {
    let mut bench = given.calibrated()?;
    let until = FIRST_SET + START;
    let is_written = bench.machine.run(2 * SECOND, |machine| {
        let board = &machine.chip().board;
        // Both wipers at the start, and both after the first set.
        board.sets > 0 && board.written_after.len() >= 4
    })?;
    let at = bench.now();
    ensure!(is_written, "no wiper written within 2 s");
    ensure!(at <= until, "the wipers are written {:.1} ms after power", milliseconds(at));
    let set_at = bench.machine.chip().board.ready_at;
    ensure!(wipers(&bench) != [511; 2], "the wipers stand in the middle");
    bench.nothing_wrong()?;
    Ok(format!(
        "the wipers are written {:.2} ms after power, the first set's last scan {:.2} ms after it (150 ms of it the set's)",
        milliseconds(at),
        milliseconds(set_at)
    ))
}

/// The FPGA is configured when the processor has long started.
pub fn late_port(given: &Given) -> Result<String> {
    /// From one try to the next.
    const TRY: Ticks = 21 * MILLISECOND;
    let mut longest = 0;
    for configured in [18, 25, 33, 60, 250].map(|ms| ms * MILLISECOND) {
        let mut bench = given.calibrated()?;
        bench.plant.borrow_mut().inject(Fault::MutePort { transfers: u32::MAX });
        bench.pass(configured)?;
        bench.plant.borrow_mut().clear_faults();
        let is_written = bench.machine.run(configured + 3 * SECOND, |machine| {
            let board = &machine.chip().board;
            board.sets > 0 && board.written_after.len() >= 4
        })?;
        ensure!(is_written, "no wiper written within 3 s");
        longest = longest.max(bench.now() - configured);
        let errors = bench.faults()?.acquisition_errors;
        ensure!(errors <= 1, "{errors} errors: each try between ticks counts");
        bench.nothing_wrong()?;
    }
    ensure!(longest <= TRY + FIRST_SET + MILLISECOND, "{:.1} ms after the FPGA", milliseconds(longest));
    Ok(format!(
        "configured 18 to 250 ms after power: wipers written {:.1} ms after it at most (150 ms of it the set's)",
        milliseconds(longest)
    ))
}

/// How deep the stack was, a record in flash and another one committed: the self-test refuses more than 75 %.
pub fn stack(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    let stack = |bench: &mut Bench| match bench.ask(Request::Health)? {
        Answer::Health(Health { stack: Some(stack), .. }) => Ok(stack),
        other => bail!("an answer to another question: {other:?}"),
    };
    let started = stack(&mut bench)?;
    bench.order(Request::SetStream { groups: true, samples: SampleWindow::ALL })?;
    bench.groups(2)?;
    bench.deploy(&given.record)?;
    bench.groups(2)?;
    let worked = stack(&mut bench)?;
    bench.nothing_wrong()?;
    ensure!(worked.used * 2 < worked.size, "{} and {} of {} bytes", started.used, worked.used, worked.size);
    Ok(format!(
        "{} bytes after the start with a record, {} after a commit, of {}: {:.0} %",
        started.used,
        worked.used,
        worked.size,
        f64::from(worked.used) / f64::from(worked.size) * 100.0
    ))
}

/// The wiper is written at most a sample period after the last scan of a group.
pub fn latency(given: &Given) -> Result<String> {
    let mut bench = given.calibrated()?;
    bench.pass(SECOND / 10)?;
    let without = longest_of(&mut bench, 40)?;
    bench.order(Request::SetStream { groups: true, samples: SampleWindow { axes: [true; 2], first: 25, last: 0 } })?;
    bench.pass(2 * SECOND)?;
    let with = longest_of(&mut bench, 20)?;
    bench.nothing_wrong()?;
    ensure!(without.max(with) <= SAMPLE_PERIOD, "{:.2} and {:.2} ms", milliseconds(without), milliseconds(with));
    Ok(format!(
        "at most {:.2} ms over 40 groups on a ramp; {:.2} ms while samples are streamed",
        milliseconds(without),
        milliseconds(with)
    ))
}

fn longest_of(bench: &mut Bench, groups: u32) -> Result<Ticks> {
    bench.plant.borrow_mut().chamber_set_point(Celsius(60.0))?;
    bench.machine.chip().board.written_after.clear();
    bench.pass(SECOND * u64::from(groups) * 3 / 2)?;
    let written = &bench.machine.chip().board.written_after;
    ensure!(written.len() >= 2 * groups as usize - 2, "{} writes in {groups} groups", written.len());
    Ok(written.iter().copied().max().unwrap_or(0))
}

/// The commit of a record by a chip that erases as slowly as its sheet allows and whose watchdog is as fast.
pub fn longest_commit(given: &Given) -> Result<String> {
    let mut bench = given.calibrated()?;
    let chip = bench.machine.chip();
    (chip.watchdog.clock_hz, chip.flash.slow) = (47_000, true);
    bench.power_cycle()?;
    bench.pass(100 * MILLISECOND)?;
    let period = bench.machine.chip().watchdog.period();
    bench.stream()?;
    bench.groups(2)?;
    let committed = bench.deploy(&given.record);
    let resets = bench.resets(Reset::Watchdog);
    ensure!(
        committed.is_ok() && resets == 0,
        "{resets} resets by the watchdog, whose time is {:.2} s",
        milliseconds(period) / 1e3
    );
    let groups = bench.groups(4)?;
    let lost = bench.faults()?.lost_sets;
    ensure!(lost == 0 && groups[3].lost == 0, "{lost} groups lost");
    ensure!(Axis::BOTH.into_iter().all(|axis| groups[3].axes[axis.index()].tap.get() == wipers(&bench)[axis.index()]));
    bench.nothing_wrong()?;
    Ok(format!(
        "0.5 s to erase a sector, 0.1 ms to program a word: no group lost, no reset by a watchdog of {:.2} s",
        milliseconds(period) / 1e3
    ))
}

/// Power goes in the middle of a commit: after the sector is erased, and after some of its words.
pub fn cut_in_a_commit(given: &Given) -> Result<String> {
    let mut bench = given.calibrated()?;
    bench.pass(SECOND / 10)?;
    bench.identify()?;
    bench.deploy(&given.record)?;
    let words = bench.machine.chip().flash.programmed;
    for cut in [0, 1, words / 2, words - 1] {
        let flash = &bench.machine.chip().flash;
        let (erased, programmed) = (flash.erased, flash.programmed);
        bench.deploy_until(&given.record, |flash| flash.erased > erased && flash.programmed == programmed + cut)?;
        bench.power_cycle()?;
        bench.pass(SECOND / 10)?;
        let identity = bench.identify()?;
        let old = identity.calibration.is_in_use() && identity.running;
        ensure!(old, "{cut} of {words} words: {:?}", identity.calibration);
    }
    bench.deploy(&given.record)?;
    ensure!(bench.identify()?.calibration == CalibrationState::InUse);
    bench.nothing_wrong()?;
    Ok(format!(
        "after the erasure, after 1, {} and {} of {words} words: the old record is in use",
        words / 2,
        words - 1
    ))
}
