//! The image's groups against the native board's: sums, taps, corrections, all of them.

use anyhow::{Result, ensure};
use zerorate_core::units::{Celsius, Taps};
use zerorate_sim::{Plant, PlantParameters, PotentiometerParameters, SharedPlant};

use super::Given;
use crate::bench::Bench;
use crate::chip::board::SCAN_NS;
use crate::chip::time::{MILLISECOND, SECOND};
use crate::native;

const GROUPS: usize = 1000;
/// From a set's last scan to where the wipers move electrically, on both plants: longer than the image takes to write them. The
/// native board is faster, for of its time there is only that of the buses.
const LATENCY_US: u32 = 2900;

/// A plant on its way to -40 C, its wipers in the middle when its power comes.
fn plant() -> Result<Plant> {
    let mut plant = Plant::new(
        PlantParameters {
            wiper_latency_us: LATENCY_US,
            potentiometer: PotentiometerParameters { factory_tap: Taps::MIDDLE, ..PotentiometerParameters::default() },
            ..PlantParameters::paper()
        },
        7,
    );
    plant.chamber_set_point(Celsius(-40.0))?;
    Ok(plant)
}

/// When the port starts, which is the image's to say: the native board starts then.
pub fn start_of_port(bench: &mut Bench) -> Result<u64> {
    let starts = |plant: &SharedPlant| plant.borrow().next_scan_ns();
    bench.machine.run(SECOND, |machine| starts(&machine.chip().board.plant).is_some())?;
    let started_ns = starts(&bench.plant).map_or(0, |ns| ns - SCAN_NS);
    ensure!(started_ns > 0, "the port does not start");
    Ok(started_ns)
}

/// The first groups after power, alone on a ramp.
pub fn groups(given: &Given) -> Result<String> {
    let mut bench = Bench::new(&given.image, plant()?, Some(&given.records))?;
    let started_ns = start_of_port(&mut bench)?;
    bench.pass(20 * MILLISECOND)?;
    bench.stream()?;
    let image = bench.groups(GROUPS)?;

    let plant = plant()?.share();
    let native = native::first_groups(&plant, &given.record, started_ns, GROUPS)?;
    if let Some((image, native)) = image.iter().zip(&native).find(|(image, native)| image != native) {
        anyhow::bail!("image {image:?}\n    native {native:?}");
    }
    let moves = image.iter().flat_map(|group| &group.axes).filter(|axis| axis.moved_to.is_some()).count();
    ensure!(image.len() == GROUPS && native.len() == GROUPS && moves >= 10, "{moves} moves");
    bench.nothing_wrong()?;
    Ok(format!("{GROUPS} reports are the same bit for bit, {moves} moves of a wiper among them"))
}
