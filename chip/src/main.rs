//! Runs the very image for the STM32F405 against the simulated bench: `zerorate-chip ELF`, a line a case; `zerorate-chip ELF
//! TEXT`, those cases alone whose names have the text.

mod bench;
mod cases;
mod chip;
mod deployment;
mod lock_step;
mod machine;
mod native;
// Made for tests, as all of this is.
#[allow(clippy::unwrap_used)]
#[path = "../../crates/bench/tests/paper_record/mod.rs"]
mod paper_record;

use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, Result};

use crate::cases::Given;

fn main() -> Result<ExitCode> {
    let path = std::env::args_os().nth(1).context("say which ELF: zerorate-chip ELF")?;
    let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
    let wanted = std::env::args().nth(2).unwrap_or_default();
    let given = Given::new(&bytes)?;
    let began = Instant::now();
    let cases = cases::ALL.iter().filter(|(name, _)| name.contains(&wanted));
    let (mut run, mut failed) = (0, 0);
    for (name, case) in cases {
        run += 1;
        match case(&given) {
            Ok(numbers) => println!("    {name}: {numbers}"),
            Err(error) => {
                failed += 1;
                println!("    {name}: FAILED: {error:#}");
            }
        }
    }
    println!("    {run} cases, {failed} failed, in {:.1} s", began.elapsed().as_secs_f64());
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
