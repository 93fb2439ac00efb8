//! Runs the very image for the STM32F405 against the simulated bench.
mod bench;
mod chip;
mod machine;
#[path = "../../crates/bench/tests/paper_record/mod.rs"]
mod paper_record;

use bench::Bench;
use chip::memory::Image;
use chip::time::*;
use zerorate_sim::{Plant, PlantParameters};

fn main() -> anyhow::Result<()> {
    let path = std::env::args_os().nth(1).expect("an ELF");
    let image = Image::of_elf(&std::fs::read(path)?)?;
    let mut bench = Bench::new(&image, Plant::new(PlantParameters::paper(), 1), None)?;
    let t = std::time::Instant::now();
    println!("{:?}", bench.identify());
    println!("{:?} {}", t.elapsed(), milliseconds(bench.now()));
    println!("{:?}", bench.deploy(&paper_record::record([8500.0, 11_900.0], None, 0.05)));
    println!("{:?} {}", t.elapsed(), milliseconds(bench.now()));
    println!("{:?} erased {}", bench.identify(), bench.machine.chip().flash.erased);
    println!("{:?}", bench.faults());
    println!("{:?}", bench.machine.chip().wrong);
    bench.power_cycle()?;
    let from = bench.now();
    println!("{:?}", bench.machine.run(from + 5*SECOND, |m| m.chip().board.written_after.len() >= 6));
    println!("{:?} {}", t.elapsed(), milliseconds(bench.now() - from));
    { let b = &bench.machine.chip().board; println!("{:?} {} {}", b.written_after, b.empty_frames, b.sets); }
    bench.stream()?;
    println!("{:?}", bench.groups(3));
    println!("{:?} {}", t.elapsed(), milliseconds(bench.now() - from));
    println!("{:?}", bench.groups(30)?.len());
    println!("{:?} {}", t.elapsed(), milliseconds(bench.now() - from));
    println!("{:?}", bench.machine.chip().wrong);
    Ok(())
}
