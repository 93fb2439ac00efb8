//! What a debug probe is told.

use anyhow::{Result, ensure};
use zerorate_core::wire::Stop;

use super::{Given, paper};
use crate::bench::Bench;
use crate::chip::nvic;
use crate::chip::time::SECOND;
use crate::machine::Ambush;

/// The lines since they were last read.
fn lines(bench: &mut Bench) -> Result<Vec<String>> {
    Ok(String::from_utf8(bench.machine.probed()?)?.lines().map(str::to_owned).collect())
}

/// What a start has found, and where the program stopped itself before.
pub fn told(given: &Given) -> Result<String> {
    let starts = |cause: &str| format!("zerorate {} starts: {cause}", env!("CARGO_PKG_VERSION"));
    let mut bench = Bench::new(&given.image, paper(), None)?;
    bench.pass(SECOND / 2)?;
    let blank = lines(&mut bench)?;
    let unit = format!("unit {}", given.record.unit);
    let waits = "record: none was ever stored; it waits for a host";
    ensure!(blank == [starts("power came"), unit.clone(), waits.into()], "{blank:?}");
    ensure!(lines(&mut bench)?.is_empty(), "it is told twice");

    let image = given.image.clone().with_serial(b"");
    let mut bench = Bench::new(&image, paper(), Some(&given.records))?;
    bench.pass(SECOND)?;
    bench.machine.ambush(nvic::EXTI0, Ambush::Panic)?;
    bench.pass(3 * SECOND)?;
    let panicked = lines(&mut bench)?;
    let site = &given.image.panic;
    let Stop::Panic { file, line } = Stop::panic_at(&site.file, site.line) else { anyhow::bail!("no panic") };
    let expected = [
        starts("the program stopped itself"),
        "restarts since power came: 1".into(),
        format!("it stopped itself last at {file}:{line}"),
        "no serial: any unit's record is taken".into(),
        "record: in use; groups are taken".into(),
    ];
    ensure!(panicked == expected, "{panicked:?}");
    bench.nothing_wrong()?;
    Ok(format!("without a record {} lines, after a panic {}: {}", blank.len(), panicked.len(), panicked.join("; ")))
}
