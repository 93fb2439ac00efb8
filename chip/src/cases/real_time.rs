//! The second line: every scan, corrected, while the next one is being awaited.

use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use zerorate_core::compensate::Mode;
use zerorate_core::record::DeviceRecord;
use zerorate_core::trim::TapEffects;
use zerorate_core::units::{Axis, Celsius, Counts, Taps};
use zerorate_core::wire::{Request, SampleWindow, ScanFlags, ScanReport};
use zerorate_sim::{ChamberParameters, Fault, Plant, PlantParameters, PotentiometerParameters};

use super::same_bits::start_of_port;
use super::select::registers;
use super::{Given, VALID, committed, consecutive, wipers};
use crate::bench::Bench;
use crate::chip::board::Cut;
use crate::chip::time::{MILLISECOND, SECOND, Ticks, milliseconds};
use crate::{native, paper_record};

/// From scan to scan.
const SAMPLE_PERIOD: Ticks = 3 * MILLISECOND;
/// From a set's last scan to where the wipers move electrically, on both plants: on the image's own they do 0.2 ms after it, on
/// the native board 0.1.
const LATENCY_US: u32 = 300;
/// What the circuits are centred on.
const CENTRE_COUNTS: f64 = 8200.0;
/// A frame whose scan has come is there by then, or never.
const PATIENCE: Ticks = 10 * MILLISECOND;
/// So long is listened on this machine's clock, an hour of the board's at most.
const LISTENED: Duration = Duration::from_secs(60);
const HOUR: u32 = 1_200_000;
/// Fewer scans say nothing: a minute of them.
const LEAST: u32 = 20_000;

/// A board with a record whose power has just come, its second line listened to.
fn listened_to(given: &Given) -> Result<Bench> {
    let mut bench = given.calibrated()?;
    bench.machine.chip().board.scan_ready_connected = true;
    Ok(bench)
}

/// The next frame.
fn next(bench: &mut Bench) -> Result<(ScanReport, Ticks)> {
    let until = bench.now() + SECOND;
    bench.scan(until)?.context("no frame within a second")
}

/// Those that have come are passed over.
fn pass_over(bench: &mut Bench) -> Result<()> {
    let now = bench.now();
    while bench.scan(now)?.is_some() {}
    Ok(())
}

/// From the scan to the last byte of its frame.
fn latency(bench: &mut Bench, report: &ScanReport, at: Ticks) -> Result<Ticks> {
    let scan = bench.machine.chip().board.scanned.get(report.scan as usize).context("no such scan")?;
    Ok(at - scan.0)
}

/// From power to the first frame that the law is in force for, with no host; the wipers beside it.
pub fn power_up(given: &Given) -> Result<String> {
    const LIMIT: Ticks = 1500 * MILLISECOND;
    let mut bench = listened_to(given)?;
    let (first, at) = loop {
        let (report, at) = next(&mut bench)?;
        if report.axes.iter().all(|axis| axis.flags.has(ScanFlags::AT_WORK)) {
            break (report, at);
        }
    };
    ensure!(at <= LIMIT, "{:.1} ms", milliseconds(at));
    ensure!(wipers(&bench) != [511; 2], "the wipers stand in the middle");
    // Counts from the centre, by the plant's own truth of the drift that is left.
    let settled = loop {
        let (report, at) = next(&mut bench)?;
        if report.axes.iter().all(|axis| !axis.flags.has(ScanFlags::SETTLING)) {
            break at;
        }
    };
    bench.nothing_wrong()?;
    Ok(format!(
        "the first corrected frame, of scan {}, {:.2} ms after power; the wipers settled to a count {:.1} ms after power",
        first.scan,
        milliseconds(at),
        milliseconds(settled)
    ))
}

/// A plant on its way from the cold to the hot end, where its taps change most often.
fn plant() -> Result<Plant> {
    let mut plant = Plant::new(
        PlantParameters {
            wiper_latency_us: LATENCY_US,
            potentiometer: PotentiometerParameters { factory_tap: Taps::MIDDLE, ..PotentiometerParameters::default() },
            chamber: ChamberParameters { start_c: -40.0, ..ChamberParameters::default() },
            ..PlantParameters::paper()
        },
        7,
    );
    plant.chamber_set_point(Celsius(60.0))?;
    Ok(plant)
}

/// The record of that plant's X, its taps by what they do there.
fn record(plant: &Plant) -> Result<DeviceRecord> {
    let first = Taps::new(485).context("a tap")?;
    let effects: Vec<Counts> =
        (485..535).filter_map(Taps::new).map(|tap| Counts(plant.true_tap_counts(Axis::X, tap))).collect();
    Ok(paper_record::record(VALID, TapEffects::new(first, &effects), 0.05))
}

/// What a tap change of X does to its samples in hybrid, by the plant's own truth.
#[derive(Default)]
struct AfterChanges {
    last: Option<Taps>,
    /// Samples since the last change.
    since: Option<u32>,
    changes: u32,
    worst_counts: f64,
}

impl AfterChanges {
    /// In the second after a change.
    const WATCHED: u32 = 333;

    /// How far a sample, its noise taken off, is from the centre: the correction is what was taken off it, and so much is left of
    /// the reading without noise.
    fn take(&mut self, corrected_counts: f64, sampled: u16, noise_free_counts: f64, tap: Taps) {
        let off = noise_free_counts - (f64::from(sampled) - corrected_counts) - CENTRE_COUNTS;
        if self.last.replace(tap).is_some_and(|last| last != tap) {
            (self.since, self.changes) = (Some(0), self.changes + 1);
        }
        if let Some(since) = self.since.filter(|&since| since < Self::WATCHED) {
            self.worst_counts = self.worst_counts.max(off.abs());
            self.since = Some(since + 1);
        }
    }
}

/// Every scan of a board alone on a ramp: there within a sample period, the native board's to the bit, and in hybrid none that a
/// tap change throws.
pub fn every_scan(given: &Given) -> Result<String> {
    let native_plant = plant()?;
    let record = record(&native_plant)?;
    let mut bench = Bench::new(&given.image, plant()?, Some(&committed(&given.image, &record)?))?;
    bench.machine.chip().board.scan_ready_connected = true;
    let started_ns = start_of_port(&mut bench)?;
    let native_plant = native_plant.share();
    let mut native = native::at_work(&native_plant, &record, started_ns)?;

    let (began, from) = (Instant::now(), bench.now());
    let (mut scans, mut longest, mut after) = (0_u32, 0, AfterChanges::default());
    while scans < HOUR && (scans < LEAST || began.elapsed() < LISTENED) {
        // The plant's own time is at this scan when its frame has come; the next one is 2.5 ms away.
        let (report, at) = next(&mut bench)?;
        let expected = native.scan()?;
        ensure!(report == expected, "image {report:?}\n    native {expected:?}");
        ensure!(report.scan == scans, "scan {} where {scans} comes next", report.scan);
        longest = longest.max(latency(&mut bench, &report, at)?);
        if report.axes[0].flags.has(ScanFlags::AT_WORK) {
            let plant = bench.plant.borrow();
            let tap = plant.potentiometer().wiper(Axis::X);
            after.take(report.axes[0].counts(), plant.held()[1], plant.noise_free_counts()[0], tap);
        }
        scans += 1;
    }
    ensure!(longest <= SAMPLE_PERIOD, "{:.2} ms", milliseconds(longest));
    let AfterChanges { changes, worst_counts, .. } = after;
    ensure!(changes > 0 && worst_counts <= 4.0, "{worst_counts:.2} counts after {changes} tap changes");
    let virtual_s = milliseconds(bench.now() - from) / 1e3;
    bench.nothing_wrong()?;
    Ok(format!(
        "{scans} scans in {virtual_s:.0} s, none lost, each the native board's bit for bit; from a scan to the last byte of its \
         frame {:.2} ms at most; X at most {worst_counts:.2} counts from the centre in the second after each of {changes} tap \
         changes",
        milliseconds(longest)
    ))
}

/// The wipers with each scan read beside them; and that no scan is missed while their samples are streamed, which are not read
/// twice.
pub fn beside_the_groups(given: &Given) -> Result<String> {
    const GROUPS: u64 = 20;
    let mut bench = listened_to(given)?;
    bench.plant.borrow_mut().chamber_set_point(Celsius(60.0))?;
    bench.pass(2 * SECOND)?;
    bench.machine.chip().board.written_after.clear();
    bench.pass(GROUPS * 3 * SECOND / 2)?;
    let written = bench.machine.chip().board.written_after.iter().copied().max().unwrap_or(0);
    ensure!(written > 0 && written <= SAMPLE_PERIOD, "{:.2} ms", milliseconds(written));
    bench.order(Request::SetStream { groups: true, samples: SampleWindow { axes: [true; 2], first: 25, last: 0 } })?;
    bench.pass(2 * SECOND)?;
    pass_over(&mut bench)?;
    let until = bench.now() + GROUPS * 3 * SECOND / 2;
    let (mut last, mut missed) = (None, 0);
    let (mut scans, mut longest) = (0, 0);
    while let Some((report, at)) = bench.scan(until)? {
        missed += last.map_or(0, |last| report.scan - last - 1);
        longest = longest.max(latency(&mut bench, &report, at)?);
        (last, scans) = (Some(report.scan), scans + 1);
    }
    ensure!(
        missed == 0 && scans >= 9990 && longest <= SAMPLE_PERIOD,
        "{missed} missed of {scans}, {:.2} ms",
        milliseconds(longest)
    );
    bench.nothing_wrong()?;
    Ok(format!(
        "wipers written {:.2} ms after the last scan at most; while samples are streamed none of {scans} scans is missed, {:.2} ms \
         to the last byte at most",
        milliseconds(written),
        milliseconds(longest)
    ))
}

/// A scan that the port did not give: its group has no samples, and every other one has.
pub fn missed(given: &Given) -> Result<String> {
    const GROUPS: usize = 6;
    /// The first 25 samples of each axis are a block; one group has none.
    const BLOCKS: u32 = 2 * 5;
    let mut bench = listened_to(given)?;
    bench.pass(SECOND / 10)?;
    bench.order(Request::SetStream { groups: true, samples: SampleWindow { axes: [true; 2], first: 25, last: 0 } })?;
    bench.groups(2)?;
    let before = bench.faults()?;
    pass_over(&mut bench)?;
    let (first, _) = next(&mut bench)?;
    bench.plant.borrow_mut().inject(Fault::MutePort { transfers: 1 });
    bench.forget_groups();
    bench.blocks = 0;
    consecutive(&bench.groups(GROUPS)?)?;
    let (mut last, mut missed) = (first.scan, 0);
    let now = bench.now();
    while let Some((report, _)) = bench.scan(now)? {
        (missed, last) = (missed + report.scan - last - 1, report.scan);
    }
    let faults = bench.faults()?;
    let dropped = faults.dropped_uploads - before.dropped_uploads;
    let blocks = bench.blocks;
    ensure!(
        (missed, dropped, blocks) == (1, 1, BLOCKS),
        "{missed} scans missed, {dropped} dropped, {blocks} blocks of {GROUPS} groups"
    );
    ensure!(faults.lost_sets == 0, "{faults:?}");
    bench.nothing_wrong()?;
    Ok(format!("1 scan missed: of {GROUPS} groups 1 without its samples, which is counted; no other scan missed"))
}

/// Chip select cut at any bit of a scan's reading: no frame says what the A/D did not.
pub fn cut(given: &Given) -> Result<String> {
    const CUTS: u32 = 1000;
    /// What a scan's reading clocks.
    const READING: u64 = 8 * 18;
    let mut bench = listened_to(given)?;
    bench.pass(20 * MILLISECOND)?;
    for axis in Axis::BOTH {
        bench.order(Request::SetMode { axis, mode: Mode::Off })?;
    }
    bench.pass(2 * SECOND)?;
    pass_over(&mut bench)?;
    let expected = registers(&bench.plant);
    let (mut state, mut last, mut missed, mut frames) = (0x5CA7_u64, None, 0, 0_u32);
    while bench.machine.chip().board.cuts < CUTS {
        let board = &mut bench.machine.chip().board;
        if board.cut.is_none_or(|cut| cut.after == 0) {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let after = 1 + u32::try_from(state % READING)?;
            board.cut =
                Some(Cut { after, lasts: (state >> 40 & 1 == 1).then_some(1 + u32::try_from(state >> 41 & 63)?) });
        }
        let (report, _) = next(&mut bench)?;
        let taken = bench.machine.chip().board.scanned[report.scan as usize].1;
        let said = report.axes.map(|axis| axis.corrected_q16);
        ensure!(said == [taken[1], taken[3]].map(|zro| i32::from(zro) << 16), "{report:?} is not {taken:?}");
        missed += last.map_or(0, |last| report.scan - last - 1);
        (last, frames) = (Some(report.scan), frames + 1);
    }
    ensure!(registers(&bench.plant) == expected, "a register was changed");
    let faults = bench.faults()?;
    ensure!(faults.lost_sets == 0 && faults.restarts == 0, "{faults:?}");
    bench.pass(PATIENCE)?;
    bench.nothing_wrong()?;
    Ok(format!(
        "{CUTS} cuts in {frames} scans: each frame is what the A/D gave, {missed} scans missed, {} reads failed, registers as \
         written, no group lost",
        faults.acquisition_errors
    ))
}
