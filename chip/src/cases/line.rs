//! Faults of the host's line.

use anyhow::{Context, Result, ensure};
use zerorate_core::wire::frame;
use zerorate_core::wire::{Request, SampleWindow};

use super::{Given, consecutive};
use crate::chip::time::{MILLISECOND, SECOND, Ticks};

/// Blocks of a group's samples where all are asked for: 500 of each axis, 25 a block.
const BLOCKS: u32 = 2 * 500 / 25;

/// Noise and half frames on the line.
pub fn damaged(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    let noise: Vec<u8> = (0..200_u8).map(|byte| byte.wrapping_mul(73) | 1).chain([0]).collect();
    for _ in 0..10 {
        bench.send(&noise);
        bench.pass(SECOND / 10)?;
    }
    // Whole, and nothing of this version.
    bench.send(&frame::encode(&[0xFF_u8; 20]).ok().context("a frame that cannot be")?);
    bench.pass(SECOND / 10)?;
    let identity = bench.identify()?;
    let faults = bench.faults()?;
    ensure!(faults.unknown_frames == 1, "{faults:?}");
    ensure!(identity.running && faults.damaged_frames >= 10 && faults.restarts == 0, "{faults:?}");
    consecutive(&bench.groups(4)?)?;
    bench.nothing_wrong()?;
    Ok(format!(
        "{} frames that cannot be read and {} that says nothing: counted, not acted on; groups go on",
        faults.damaged_frames, faults.unknown_frames
    ))
}

/// A line that has more to carry than it can: samples that find no time are dropped and counted, and no group is.
pub fn slow(given: &Given) -> Result<String> {
    const GROUPS: u32 = 8;
    let mut bench = given.at_work()?;
    bench.order(Request::SetStream { groups: true, samples: SampleWindow::ALL })?;
    bench.forget_groups();
    bench.groups(2)?;
    // All samples of a group take the line for a second of its one and a half; the record, read again and again, for more than
    // what is left.
    bench.blocks = 0;
    let mut groups = bench.groups(1)?;
    let until = bench.now() + Ticks::from(GROUPS - 2) * 3 * SECOND / 2;
    let mut asked = 0;
    while bench.now() < until {
        bench.call(Request::ReadCalibration { offset: 0 })?;
        bench.pass(20 * MILLISECOND)?;
        asked += 1;
    }
    // The last ones have the line for themselves again.
    groups.extend(bench.groups(GROUPS as usize)?);
    consecutive(&groups)?;
    let faults = bench.faults()?;
    let (came, expected) = (bench.blocks, BLOCKS * (1 + GROUPS));
    ensure!(
        faults.dropped_uploads > 0 && came + faults.dropped_uploads == expected,
        "{came} of {expected}, {faults:?}"
    );
    ensure!(faults.restarts == 0 && faults.lost_sets == 0, "{faults:?}");
    bench.nothing_wrong()?;
    Ok(format!(
        "{asked} answers beside all samples: {came} blocks of {expected} came, {} dropped and counted; of {} groups none",
        faults.dropped_uploads,
        1 + GROUPS
    ))
}

/// A host that asks again and again, faster than it can be answered: the watchdog is fed and the groups come all the same.
pub fn without_end(given: &Given) -> Result<String> {
    /// Longer than the watchdog's time.
    const ASKED: Ticks = 15 * SECOND;
    const GROUPS: usize = 9;
    let mut bench = given.at_work()?;
    let mut asked = 0;
    for period in [2, 5, 12] {
        bench.forget_groups();
        let until = bench.now() + ASKED;
        while bench.now() < until {
            bench.call(Request::Faults)?;
            bench.pass(period * MILLISECOND)?;
            asked += 1;
        }
        let resets = bench.machine.resets.len();
        ensure!(resets == 1, "{} restarts of a board that was asked every {period} ms", resets - 1);
        // What has come while it was asked; no time passes.
        let groups: Vec<_> = (0..GROUPS).map(|_| bench.group_within(MILLISECOND)).collect::<Result<_>>()?;
        consecutive(&groups)?;
        bench.pass(SECOND)?;
    }
    let faults = bench.faults()?;
    ensure!(faults.lost_sets == 0 && faults.restarts == 0, "{faults:?}");
    bench.nothing_wrong()?;
    Ok(format!(
        "{asked} questions, every 2, 5 and 12 ms for 15 s each: no restart, {GROUPS} groups in each time, none lost"
    ))
}
