//! Chip select of the acquisition port goes high by itself, at any bit: within the reading of sets, and within the setting up.

use anyhow::{Context, Result, ensure};
use zerorate_core::wire::GroupReport;
use zerorate_sim::{PortSpi, SharedPlant};

use super::Given;
use crate::bench::Bench;
use crate::chip::board::Cut;
use crate::chip::time::{MILLISECOND, SECOND, Ticks, milliseconds};

const CUTS: u32 = 1000;
/// Scans a set.
const SET: usize = 500;
/// The clocks of a register read and of one written.
const READ: u32 = 8 * 6;
const WRITE: u32 = 8 * 10;
/// What a group's reading clocks: STATUS, then the burst's header.
const READING: u32 = READ + 8 * 66;
/// What setting up clocks: identity and version, stop, period and length and start, each read back. (After power the length
/// of all sets but the first comes after it.)
const SETTING_UP: u32 = 2 * READ + WRITE + 3 * (WRITE + READ);
/// Two groups, and what the tick and the line take.
const TWO_GROUPS: Ticks = 3 * SECOND + 30 * MILLISECOND;

/// From a port that begins anew to its next set, a cut in its setting up: two groups without a set by ticks, of which the first may
/// still have seen one; a tick more, where the cut has spoiled the setting up; a set.
const SETTING_UP_TAKES: Ticks = (1 + 3 + 1) * SECOND + 3 * SECOND / 2 + 30 * MILLISECOND;

/// A sequence that looks like chance and is always the same (xorshift64).
struct Chance(u64);

impl Chance {
    fn below(&mut self, n: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        u32::try_from(self.0 >> 33).unwrap_or(0) % n
    }

    /// A cut before one of so many bits; half of them end by themselves, within a transfer.
    fn cut(&mut self, bits: u32) -> Cut {
        let after = 1 + self.below(bits);
        let lasts = (self.below(2) == 1).then(|| 1 + self.below(64));
        Cut { after, lasts }
    }
}

/// The port's registers that can be written, read past the chip: at its pins, for a transfer would take the plant's time, and a scan
/// that came within it would be missing in the board's own record.
pub fn registers(plant: &SharedPlant) -> [u32; 3] {
    let mut pins = PortSpi::new(plant).pins();
    [2_u64, 3, 4].map(|address| {
        pins.select();
        // Head, turn-around and the word are 48 bits; the word is the last 32 of the answer.
        let sent = address << 40;
        let register =
            (0..48).rev().fold(0, |answer, place| answer << 1 | u32::from(pins.clock(sent >> place & 1 == 1)));
        pins.deselect();
        register
    })
}

/// A group's sums as the A/D gave its scans, or an error: a torn set, or one that was never taken.
fn untorn(group: &GroupReport, bench: &mut Bench, from: &mut usize) -> Result<()> {
    let [x, y] = [&group.axes[0].sums, &group.axes[1].sums];
    let sums = [x.temperature, x.zro, y.temperature, y.zro];
    let end = bench.machine.chip().board.end_of(usize::try_from(x.n)?, sums, *from);
    *from = end.with_context(|| format!("group {} is no set that the A/D gave", group.group.0))?;
    Ok(())
}

/// A thousand cuts while groups are read.
pub fn cut_reading(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    let expected = registers(&bench.plant);
    ensure!(expected == [1, 3000, 500], "{expected:?}");
    let (mut chance, mut from, mut longest, mut groups) = (Chance(0x5EED), 0, 0, 0_u32);
    let mut heard = bench.now();
    let odd = bench.machine.chip().board.odd_scans;
    while bench.machine.chip().board.cuts < CUTS {
        if bench.machine.chip().board.cut.is_none_or(|cut| cut.after == 0) {
            bench.machine.chip().board.cut = Some(chance.cut(READING));
        }
        let group = bench.group_within(10 * SECOND)?;
        (longest, heard) = (longest.max(bench.now() - heard), bench.now());
        groups += 1;
        untorn(&group, &mut bench, &mut from)?;
        let found = registers(&bench.plant);
        ensure!(found == expected, "registers {found:?} after cut {}", bench.machine.chip().board.cuts);
    }
    let faults = bench.faults()?;
    ensure!(longest <= TWO_GROUPS, "silence of {:.0} ms", milliseconds(longest));
    ensure!(bench.machine.chip().board.odd_scans == odd, "a scan came at another time");
    bench.nothing_wrong()?;
    Ok(format!(
        "{CUTS} cuts in {groups} groups: none torn, registers as written, longest silence {:.0} ms, {} reads failed, {} groups lost",
        milliseconds(longest),
        faults.acquisition_errors,
        faults.lost_sets
    ))
}

/// Cuts while a port that has begun anew is set up.
pub fn cut_setting_up(given: &Given) -> Result<String> {
    const TIMES: u32 = CUTS;
    let mut bench = given.at_work()?;
    let (mut chance, mut longest, mut restarts) = (Chance(0xC0FFEE), 0, 0);
    for n in 0..TIMES {
        bench.plant.borrow_mut().reset_port();
        // The tick's own look at STATUS comes before, up to five times.
        bench.machine.chip().board.cut = Some(chance.cut(SETTING_UP + 5 * READ));
        longest = longest.max(silence(&mut bench)?);
        let resets = bench.machine.resets.len();
        if resets > 1 + restarts {
            restarts = resets - 1;
            bench.stream()?;
        }
        bench.machine.chip().board.cut = None;
        let found = registers(&bench.plant);
        ensure!(found == [1, 3000, 500], "registers {found:?} after cut {n}");
        bench.forget_groups();
        let mut from = bench.machine.chip().board.scans().saturating_sub(3 * SET);
        let group = bench.group_within(4 * SECOND).with_context(|| format!("after cut {n}"))?;
        untorn(&group, &mut bench, &mut from)?;
    }
    bench.nothing_wrong()?;
    ensure!(longest <= SETTING_UP_TAKES, "no set for {:.0} ms", milliseconds(longest));
    ensure!(restarts == 0, "{restarts} restarts");
    Ok(format!(
        "{TIMES} cuts after the port began anew: none torn, registers as written; groups again after {:.0} ms at most, no restart",
        milliseconds(longest)
    ))
}

/// How long no set comes.
fn silence(bench: &mut Bench) -> Result<Ticks> {
    let began = bench.now();
    let sets = bench.machine.chip().board.sets;
    let comes = bench.machine.run(began + 40 * SECOND, |machine| machine.chip().board.sets > sets)?;
    ensure!(comes, "no set within 40 s");
    Ok(bench.now() - began)
}
