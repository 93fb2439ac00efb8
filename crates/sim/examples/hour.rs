//! Measures how fast the plant runs: an hour of the paper's ramp through the acquisition port, noise included.
//!
//!     cargo run --release -p zerorate-sim --example hour

use std::time::Instant;

use embedded_hal::spi::SpiDevice;
use zerorate_core::units::{Celsius, Seconds};
use zerorate_sim::{Plant, PlantParameters, PortSpi};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let plant = Plant::new(PlantParameters::paper(), 1).share();
    let mut port = PortSpi::new(&plant);
    plant.borrow_mut().chamber_set_point(Celsius(-40.0))?;

    let begun = Instant::now();
    plant.borrow_mut().wait(Seconds(3600.0));
    println!("an hour's soak: {:.1} ms", begun.elapsed().as_secs_f64() * 1e3);

    plant.borrow_mut().chamber_set_point(Celsius(60.0))?;
    port.write(&[0x82, 0, 0, 0, 0, 1, 0xAD, 0x20, 0x81, 0xE6])?;
    let begun = Instant::now();
    let mut scans = 0;
    for _ in 0..2400 {
        scans += plant.borrow_mut().run_set().map_or(0, |truth| truth.scans);
        let mut burst = [0; 2 + 4 * 16];
        burst[0] = 0x10;
        port.transfer_in_place(&mut burst)?;
    }
    let seconds = begun.elapsed().as_secs_f64();
    println!("an hour's ramp: {seconds:.3} s, {:.2} million scans/s", f64::from(scans) / seconds * 1e-6);
    Ok(())
}
