//! The wiring of the named board, hardware/wiring.md, against what it is a table of: the firmware's pins, the gateware's
//! constraints, and the analogue board's connectors.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};

use crate::steps::Outcome;
use crate::workspace::Workspace;

const TABLE: &str = "hardware/wiring.md";
const FIRMWARE: &str = "firmware/stm32f405/src/main.rs";
const CONSTRAINTS: &str = "gateware/acquisition/board/icebreaker.pcf";
const BOARD: &str = "hardware/zero-adjust/capture.py";

/// Pins of the FPGA that are wired on the iCEBreaker itself.
const ON_THE_BOARD: [&str; 3] = ["clk_12mhz", "button_n", "led_green_n"];

/// A PMOD's pins by Digilent's numbers, and the FPGA's (iCEBreaker V1.0e, schematic, sheet of the PMODs).
const PMODS: [(&str, [(u8, u8); 8]); 2] = [
    ("PMOD 1A", [(1, 4), (2, 2), (3, 47), (4, 45), (7, 3), (8, 48), (9, 46), (10, 44)]),
    ("PMOD 1B", [(1, 43), (2, 38), (3, 34), (4, 31), (7, 42), (8, 36), (9, 32), (10, 28)]),
];

/// The firmware's pins: the signal in the table, and what stands in the source before its pin.
const PROCESSOR: [(&str, &str); 12] = [
    ("port, chip select", "PortAcquisition<ExclusiveDevice<Spi<SPI1>, "),
    ("port, SCK", "let pins = (Some(a."),
    ("port, MISO", "let pins = (Some(a.pa5), Some(a."),
    ("port, MOSI", "let pins = (Some(a.pa5), Some(a.pa6), Some(a."),
    ("data ready", "data_ready_pin: "),
    ("scan ready", "scan_ready_pin: "),
    ("potentiometer, chip select", "Max5494Trim<ExclusiveDevice<Spi<SPI2>, "),
    ("potentiometer, SCLK", "let pins = (Some(b."),
    ("potentiometer, DIN", "SPI2::NoMiso, Some(b."),
    ("host, board sends", "device.USART2.serial::<u8>((a."),
    ("host, board receives", "device.USART2.serial::<u8>((a.pa2, a."),
    ("second line, board sends", "device.USART1.tx::<u8>(b."),
];

/// The analogue board's: the signal, and its pin of the connector as capture.py has it.
const CONNECTORS: [(&str, &str, &str); 7] = [
    ("A/D, CNV", "J3, 1", "\"J3\", \"PMOD\", **{\"1\": cnv,"),
    ("A/D, DIN", "J3, 2", "\"1\": cnv, \"2\": din,"),
    ("A/D, SDO", "J3, 3", "\"2\": din, \"3\": sdo_in,"),
    ("A/D, SCK", "J3, 4", "\"3\": sdo_in, \"4\": sck,"),
    ("potentiometer, chip select", "J4, 1", "\"J4\", \"header of 5\", **{\"1\": cs,"),
    ("potentiometer, SCLK", "J4, 2", "\"1\": cs, \"2\": sclk,"),
    ("potentiometer, DIN", "J4, 3", "\"2\": sclk, \"3\": pot_din,"),
];

/// Everything, as a step.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let sources = [TABLE, FIRMWARE, CONSTRAINTS, BOARD].map(|path| workspace.read(path));
    let [table, firmware, constraints, board] = sources;
    let faults = faults(&table?, &firmware?, &constraints?, &board?)?;
    ensure!(faults.is_empty(), "{} faults\n    {}", faults.len(), faults.join("\n    "));
    Ok(Outcome::Passed)
}

/// A row of the table.
#[derive(Debug)]
struct Row<'a> {
    processor: &'a str,
    pmod: &'a str,
    fpga_pin: &'a str,
    fpga_name: &'a str,
    connector: &'a str,
}

/// The table's rows by their signals.
fn rows(table: &str) -> BTreeMap<&str, Row<'_>> {
    table.lines().filter_map(row).collect()
}

fn row(line: &str) -> Option<(&str, Row<'_>)> {
    let cells = line.trim().strip_prefix('|')?.strip_suffix('|')?;
    let cells: Vec<&str> = cells.split('|').map(|cell| cell.trim().trim_matches('`')).collect();
    let [signal, processor, pmod, fpga_pin, fpga_name, connector] = cells[..] else { return None };
    let is_row = signal != "signal" && !signal.starts_with('-');
    is_row.then_some((signal, Row { processor, pmod, fpga_pin, fpga_name, connector }))
}

/// What the table says that the sources do not, and the other way.
fn faults(table: &str, firmware: &str, constraints: &str, board: &str) -> Result<Vec<String>> {
    let rows = rows(table);
    let mut faults = Vec::new();
    let mut expect = |signal: &str, what: &str, said: Option<&str>, is: &str| {
        if said != Some(is) {
            faults.push(format!("{TABLE}: {signal} has {what} `{}`, it is `{is}`", said.unwrap_or("(no row)")));
        }
    };

    for (signal, before) in PROCESSOR {
        let (_, after) =
            firmware.split_once(before).with_context(|| format!("{FIRMWARE} has no `{before}`: {signal}"))?;
        let pin = after.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_uppercase();
        expect(signal, "the processor's pin", rows.get(signal).map(|row| row.processor), &pin);
    }
    for (signal, connector, in_source) in CONNECTORS {
        let is = if board.contains(in_source) { connector } else { "elsewhere in capture.py" };
        expect(signal, "the connector", rows.get(signal).map(|row| row.connector), is);
    }

    let mut wired = 0;
    for line in constraints.lines().filter(|line| line.starts_with("set_io ")) {
        let mut words = line.split_whitespace().rev();
        let (pin, name) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
        if ON_THE_BOARD.contains(&name) {
            continue;
        }
        wired += 1;
        let found = rows.iter().find(|(_, row)| row.fpga_name == name);
        expect(name, "the FPGA's pin", found.map(|(_, row)| row.fpga_pin), pin);
        let holes = PMODS.iter().flat_map(|(pmod, pins)| pins.iter().map(move |pin| (pmod, pin)));
        let mut hole = holes
            .filter(|(_, (_, of_fpga))| of_fpga.to_string() == pin)
            .map(|(pmod, (hole, _))| format!("{pmod}, {hole}"));
        let hole = hole.next().with_context(|| format!("{CONSTRAINTS}: {pin} is at neither PMOD"))?;
        expect(name, "the PMOD's pin", found.map(|(_, row)| row.pmod), &hole);
    }

    // Nothing stands in the table that nobody has.
    let known = |signal: &str| {
        PROCESSOR.iter().any(|(known, _)| *known == signal) || CONNECTORS.iter().any(|(known, ..)| *known == signal)
    };
    faults.extend(rows.keys().filter(|signal| !known(signal)).map(|signal| format!("{TABLE}: nobody has `{signal}`")));
    let said = rows.values().filter(|row| !row.fpga_name.is_empty()).count();
    if said != wired {
        faults.push(format!("{TABLE}: {said} pins of the FPGA, {CONSTRAINTS} has {wired}"));
    }
    Ok(faults)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_the_sources(change: impl Fn(usize, String) -> String) -> Vec<String> {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../");
        let read = |path: &str| std::fs::read_to_string(root.to_owned() + path).unwrap();
        let mut number = 0;
        let [table, firmware, constraints, board] = [TABLE, FIRMWARE, CONSTRAINTS, BOARD].map(|path| {
            number += 1;
            change(number - 1, read(path))
        });
        faults(&table, &firmware, &constraints, &board).unwrap()
    }

    #[test]
    fn a_pin_that_is_moved_in_one_of_the_four_is_a_fault() {
        assert_eq!(of_the_sources(|_, text| text), Vec::<String>::new());
        let moved = [
            (0, "| PA6 |", "| PA7 |"),
            (0, "PMOD 1A, 8", "PMOD 1A, 9"),
            (1, "PB12<Output>", "PB11<Output>"),
            (2, "spi_miso 46", "spi_miso 45"),
            (3, "\"2\": din, \"3\": sdo_in", "\"2\": sdo_in, \"3\": din"),
        ];
        for (file, from, to) in moved {
            let faults = of_the_sources(|number, text| if number == file { text.replace(from, to) } else { text });
            assert!(!faults.is_empty(), "{from}");
        }
    }

    #[test]
    fn a_row_that_nobody_has_is_a_fault() {
        let row = "| host, board receives";
        let faults = of_the_sources(|number, text| {
            if number == 0 { text.replace(row, &format!("| lamp | PC12 | | | | |\n{row}")) } else { text }
        });
        assert_eq!(faults, ["hardware/wiring.md: nobody has `lamp`"]);
    }
}
