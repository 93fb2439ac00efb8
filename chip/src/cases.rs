//! What is held against the image.

mod acquisition;
mod calibration;
mod faults;
mod line;
mod power;
mod probe;
mod real_time;
mod records;
mod restarts;
mod same_bits;
mod select;
mod unit;

use anyhow::{Result, ensure};
use zerorate_core::compensate::StaticLaw;
use zerorate_core::group::CODES_PER_COUNT;
use zerorate_core::record::DeviceRecord;
use zerorate_core::units::{Axis, Taps, TemperatureScale};
use zerorate_core::wire::GroupReport;
use zerorate_sim::{Plant, PlantParameters};

use crate::bench::Bench;
use crate::chip::memory::Image;
use crate::chip::time::{MILLISECOND, SECOND};
use crate::paper_record;

/// A case: what it measured, or why it does not hold.
pub type Case = fn(&Given) -> Result<String>;

/// Every case, in the order in which they are run.
pub const ALL: [(&str, Case); 47] = [
    ("power comes, no record", power::without_a_record),
    ("a record committed over the line", power::commit),
    ("power comes, a record and no host", power::alone),
    ("an FPGA that is configured late", power::late_port),
    ("how deep the stack was", power::stack),
    ("from the last scan to the wipers", power::latency),
    ("the second line, power comes", real_time::power_up),
    ("the second line, every scan", real_time::every_scan),
    ("the second line beside the groups", real_time::beside_the_groups),
    ("the second line, a scan missed", real_time::missed),
    ("the second line, chip select cut", real_time::cut),
    ("the longest erasure, the fastest watchdog", power::longest_commit),
    ("native board and image, 1000 groups", same_bits::groups),
    ("native board and image, a calibration in short", calibration::in_short),
    ("data ready served in vain", acquisition::served_in_vain),
    ("a set damaged on the bus", acquisition::damaged_set),
    ("samples damaged on the bus", acquisition::damaged_samples),
    ("a start that the port has not taken", acquisition::start_not_taken),
    ("an acquisition that forgets its work", acquisition::set_up_anew),
    ("the same, the fastest watchdog", acquisition::fast_watchdog),
    ("sets that stop coming", acquisition::no_scans),
    ("a processor that is late", acquisition::overrun),
    ("chip select cut, reading", select::cut_reading),
    ("chip select cut, setting up", select::cut_setting_up),
    ("a dip of the analogue supply", faults::brown_out),
    ("a potentiometer that does not hear", faults::deaf_potentiometer),
    ("a temperature stuck, jumping, torn off", faults::temperature),
    ("temperatures that disagree", faults::disagreement),
    ("outside the range, and a saturated reading", faults::range_and_reading),
    ("a record damaged, in flash and on its way", records::damaged),
    ("another unit's record", records::another_unit),
    ("the serial's sector, written and not", unit::sector),
    ("a record of an unknown version", records::unknown_version),
    ("numbers that make no law", records::no_law),
    ("a damaged line", line::damaged),
    ("a slow line", line::slow),
    ("a host that asks without end", line::without_end),
    ("a crystal that does not start", restarts::dead_crystal),
    ("a program that hangs", restarts::hang),
    ("a program that stops itself", restarts::panic),
    ("three in a row", restarts::three_in_a_row),
    ("three hangs in a row", restarts::three_hangs),
    ("a dead port and the watchdog", restarts::dead_port),
    ("a stack that is full", restarts::full_stack),
    ("why it was reset", restarts::causes),
    ("power cut in a commit", power::cut_in_a_commit),
    ("what a probe is told", probe::told),
];

/// Each row of the fault table (crates/device/README.md), and the cases in which it is run.
#[cfg(test)]
const FAULTS: [(&str, &[&str]); 23] = [
    ("temperature stuck", &["a temperature stuck, jumping, torn off"]),
    ("temperature jumping", &["a temperature stuck, jumping, torn off"]),
    ("temperatures disagree", &["temperatures that disagree"]),
    ("temperature sensor torn off", &["a temperature stuck, jumping, torn off"]),
    ("temperature outside the calibrated range", &["outside the range, and a saturated reading"]),
    ("A/D saturated", &["outside the range, and a saturated reading"]),
    ("acquisition overrun", &["a processor that is late"]),
    ("SPI error, acquisition", &["a set damaged on the bus", "chip select cut, reading"]),
    ("SPI error, samples", &["samples damaged on the bus"]),
    (
        "a setting or a start that the port has not taken",
        &["a start that the port has not taken", "chip select cut, setting up"],
    ),
    ("SPI error, potentiometer", &["a potentiometer that does not hear"]),
    ("dip of the analogue supply: the potentiometer is at its tap of power-up", &["a dip of the analogue supply"]),
    ("SPI error, a scan read alone", &["the second line, a scan missed", "the second line, chip select cut"]),
    ("data ready served in vain", &["data ready served in vain"]),
    ("sets stop coming", &["an acquisition that forgets its work", "the same, the fastest watchdog"]),
    (
        "sets still do not come, task or interrupt hangs",
        &["sets that stop coming", "a crystal that does not start", "a program that hangs"],
    ),
    ("the program stops itself", &["a program that stops itself"]),
    ("the processor's supply dips", &["why it was reset"]),
    (
        "the program stops itself, or hangs at what its record decides, three times in a row, never at work for 40 groups in between",
        &["three in a row", "three hangs in a row"],
    ),
    (
        "record blank, damaged, of an unknown version, another unit's",
        &[
            "power comes, no record",
            "a record damaged, in flash and on its way",
            "a record of an unknown version",
            "another unit's record",
        ],
    ),
    ("record whose numbers make no law, or another one than its table of edges", &["numbers that make no law"]),
    ("frame damaged, frame unknown", &["a damaged line"]),
    ("line too slow", &["a slow line"]),
];

/// The range of temperature readings that the record is of.
const VALID: [f64; 2] = [8500.0, 11_900.0];

/// What every case begins with.
pub struct Given {
    image: Image,
    /// What the flash for records holds after the commit of the record.
    records: Vec<u8>,
    record: DeviceRecord,
    law: StaticLaw,
}

impl Given {
    /// Takes the image of an ELF, gives the board the serial that the cases' record is of, and has it commit that record.
    ///
    /// # Errors
    /// It does not, or is none for this chip.
    pub fn new(elf: &[u8]) -> Result<Self> {
        let record = paper_record::record(VALID, None, 0.05);
        let image = Image::of_elf(elf)?.with_serial(record.unit.as_bytes());
        let law = paper_record::model(VALID, None, 0.05).static_law(TemperatureScale::QUARTER_COUNTS);
        let records = committed(&image, &record)?;
        Ok(Self { image, records, record, law })
    }

    /// A board whose power has just come, with the record.
    fn calibrated(&self) -> Result<Bench> {
        Bench::new(&self.image, paper(), Some(&self.records))
    }

    /// The same, its groups streamed to a host, and three of them taken.
    fn at_work(&self) -> Result<Bench> {
        let mut bench = self.calibrated()?;
        bench.stream()?;
        bench.groups(3)?;
        Ok(bench)
    }

    /// The tap that the law asks for at a group's own temperature.
    fn asked(&self, group: &GroupReport, axis: Axis) -> Option<Taps> {
        self.law.tap(group.axes[axis.index()].sums.temperature_code(CODES_PER_COUNT)?)
    }
}

/// What the flash for records holds after a commit of a record by the image itself.
fn committed(image: &Image, record: &DeviceRecord) -> Result<Vec<u8>> {
    let mut bench = Bench::new(image, paper(), None)?;
    bench.deploy(record)?;
    Ok(bench.machine.chip().flash.records.clone())
}

fn paper() -> Plant {
    Plant::new(PlantParameters::paper(), 1)
}

fn wipers(bench: &Bench) -> [u16; 2] {
    Axis::BOTH.map(|axis| bench.plant.borrow().potentiometer().wiper(axis).get())
}

/// Lets time pass up to just before a set is full: what is broken then is broken for that set's reading, not for a tick's
/// look at STATUS.
fn just_before_a_set(bench: &mut Bench) -> Result<()> {
    let sets = bench.machine.chip().board.sets;
    let until = bench.now() + 3 * SECOND;
    ensure!(bench.machine.run(until, |machine| machine.chip().board.sets > sets)?, "no set within 3 s");
    let full = bench.machine.chip().board.ready_at + 1500 * MILLISECOND;
    bench.machine.run_until(full - MILLISECOND)
}

/// Groups follow one another.
fn consecutive(groups: &[GroupReport]) -> Result<()> {
    let numbers: Vec<u32> = groups.iter().map(|group| group.group.0).collect();
    ensure!(numbers.windows(2).all(|pair| pair[1] == pair[0] + 1), "groups {numbers:?}");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_row_of_the_fault_table_is_run_on_the_image() {
        let text = include_str!("../../crates/device/README.md");
        let table = text.lines().skip_while(|line| !line.starts_with("| fault | how it is seen |")).skip(2);
        let rows = table.map_while(|line| line.strip_prefix("| ")?.split_once(" | ")).map(|(fault, _)| fault);
        assert_eq!(rows.collect::<Vec<_>>(), FAULTS.map(|(fault, _)| fault));
        for case in FAULTS.iter().flat_map(|(_, cases)| *cases) {
            assert!(ALL.iter().any(|(name, _)| name == case), "no case is called {case:?}");
        }
    }
}
