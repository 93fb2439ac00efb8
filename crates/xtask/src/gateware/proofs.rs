//! What docs/acquisition-port.md promises, proved of the RTL by yosys and ABC for every input and any time; and the same with
//! the RTL spoilt, where each proof must find a way to break it, so that it is known to prove something.
//!
//! What is assumed of what is gateware/acquisition/formal/README.md's.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use super::{BLOCK, logged, out, yosys};
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// How it is proved.
enum Engine {
    /// By k-induction, in yosys.
    Induction,
    /// By property directed reachability, in ABC: it finds the invariant by itself, or the inputs that break the property.
    Reachability,
}

/// What is read.
enum Sources {
    /// These files.
    Files(&'static [&'static str]),
    /// The whole block, with those of `formal/abstract` in the place of their namesakes.
    Block,
}

/// One proof, and what spoils it.
struct Proof {
    top: &'static str,
    sources: Sources,
    /// The part of the file's assertions that is proved.
    part: &'static str,
    engine: Engine,
    says: &'static str,
    /// A file, a piece of it, and what is there instead.
    spoilt: (&'static str, &'static str, &'static str),
}

const SERIAL: Sources = Sources::Files(&["rtl/crc32_bit.sv", "rtl/spi_slave.sv", "formal/serial.sv"]);
const SCANS: Sources =
    Sources::Files(&["rtl/scan_timer.sv", "rtl/ad7949_master.sv", "rtl/output_register.sv", "formal/scans.sv"]);

const MEANS: Sources = Sources::Files(&["rtl/scan_timer.sv", "rtl/decimator.sv", "formal/means.sv"]);

const PROOFS: [Proof; 14] = [
    Proof {
        top: "crc",
        sources: Sources::Files(&["rtl/crc32_bit.sv", "formal/crc.sv"]),
        part: "CRC",
        engine: Engine::Reachability,
        says: "a CRC over bytes and what was sent as theirs is 0 for theirs alone",
        spoilt: ("rtl/crc32_bit.sv", "crc[31] != taken", "crc[31]"),
    },
    Proof {
        top: "serial",
        sources: SERIAL,
        part: "COUNTED",
        engine: Engine::Reachability,
        says: "lemma: the slave's state is what the pins had",
        spoilt: ("rtl/spi_slave.sv", "FIRST_BIT_OF_HEAD = 5'd16", "FIRST_BIT_OF_HEAD = 5'd17"),
    },
    Proof {
        top: "serial",
        sources: SERIAL,
        part: "SERIAL",
        engine: Engine::Reachability,
        says: "the slave's toggles and words are the pins' bits, and nothing else moves them",
        spoilt: ("rtl/spi_slave.sv", "LAST_BIT_OF_ADDRESS = 5'd23", "LAST_BIT_OF_ADDRESS = 5'd22"),
    },
    Proof {
        top: "scans",
        sources: SCANS,
        part: "PLACED",
        engine: Engine::Induction,
        says: "lemma: timer and A/D are where the clock has brought them",
        spoilt: ("rtl/scan_timer.sv", "since_us == last_us", "since_us == last_us - 20'd1"),
    },
    Proof {
        top: "scans",
        sources: SCANS,
        part: "SCANS",
        engine: Engine::Reachability,
        says: "a pass begins when the one before is over and summed, and brings the four channels in order",
        spoilt: ("rtl/ad7949_master.sv", "{frame[2], frame[0]}", "{frame[0], frame[2]}"),
    },
    Proof {
        top: "means",
        sources: MEANS,
        part: "COUNTED",
        engine: Engine::Reachability,
        says: "lemma: a scan has as many passes as OVERSAMPLING says, and no sum outgrows them",
        spoilt: ("rtl/scan_timer.sv", "is_last  <= passes == parts", "is_last  <= passes == 4'hF"),
    },
    Proof {
        top: "means",
        sources: MEANS,
        part: "MEANS",
        engine: Engine::Induction,
        says: "a sample is the mean of its conversions, to the nearest count and from a half to the even one",
        spoilt: ("rtl/decimator.sv", "doubled[1] || below", "below"),
    },
    Proof {
        top: "acquisition",
        sources: Sources::Block,
        part: "COUNTED",
        engine: Engine::Reachability,
        says: "lemma: the transfer that the block has open is the one on the pins",
        spoilt: ("rtl/transfer.sv", "beyond    <= head[6:4] != 3'd0", "beyond    <= head[6:5] != 2'd0"),
    },
    Proof {
        top: "acquisition",
        sources: Sources::Block,
        part: "WRITES",
        engine: Engine::Reachability,
        says: "no read writes: a register changes by a whole write alone",
        spoilt: ("rtl/transfer.sv", "closes && is_write && both_came", "closes && both_came"),
    },
    Proof {
        top: "acquisition",
        sources: Sources::Block,
        part: "WRITES",
        engine: Engine::Reachability,
        says: "and of 80 bits, not of more",
        spoilt: ("rtl/transfer.sv", "both_came && !stays_within && is_sound", "both_came && is_sound"),
    },
    Proof {
        top: "acquisition",
        sources: Sources::Block,
        part: "SUMMED",
        engine: Engine::Reachability,
        says: "lemma: a sample is summed before the next, into the bank that fills",
        spoilt: ("rtl/accumulator.sv", "of_bank    <= bank", "of_bank    <= !bank"),
    },
    Proof {
        top: "acquisition",
        sources: Sources::Block,
        part: "WHOLE",
        engine: Engine::Reachability,
        says: "never torn: the bank that is read is not written",
        spoilt: ("rtl/banks.sv", "(read_begins || (reading && !read_ends))", "read_begins"),
    },
    Proof {
        top: "acquisition",
        sources: Sources::Block,
        part: "TOLD",
        engine: Engine::Reachability,
        says: "never silent: a full set is ready, or counted and told as lost",
        spoilt: ("rtl/banks.sv", "!is_released && (waiting || set_full)", "!is_released && waiting"),
    },
    Proof {
        top: "acquisition",
        sources: Sources::Block,
        part: "FALLS",
        engine: Engine::Reachability,
        says: "data ready falls after every release, within six clocks",
        spoilt: ("rtl/banks.sv", "!restart && !is_released && (waiting", "!restart && (waiting"),
    },
];

/// Who owns which bank, by the assertions that stand in banks.sv: in simulation they are watched, too.
const BANKS: &str = "read_verilog -sv -formal rtl/banks.sv; prep -top banks; async2sync; chformal -early; opt; \
                     sat -verify -tempinduct -prove-asserts -set-at 1 rst_n 0 -maxsteps 20";

/// All of them.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let folder = workspace.root.join(BLOCK);
    let log = yosys(&folder, BANKS, &out(workspace)?.join("proof-banks.log"))?;
    // Nothing asserted would be proved as well.
    let is_proved = log.contains("Import proof for assert") && log.contains("Induction step proven: SUCCESS");
    ensure!(is_proved, "no proof: see target/gateware/proof-banks.log");
    println!("    banks.sv: its own assertions");
    for (number, proof) in PROOFS.iter().enumerate() {
        let out = out(workspace)?.join(format!("proof-{}-{}-{number}", proof.top, proof.part.to_lowercase()));
        let verdict = |folder: &Path, what: &str| {
            let work = out.join(what);
            fs::create_dir_all(&work)?;
            proof.holds(folder, &work).with_context(|| format!("{}, {}", proof.top, proof.part))
        };
        ensure!(verdict(&folder, "as-it-is")?, "{} is not so: see {}", proof.says, out.display());
        let spoilt = proof.spoil(workspace, &out.join("sources"))?;
        let is_noticed = !verdict(&spoilt, "spoilt")?;
        ensure!(is_noticed, "{} {} is proved of a spoilt {}, too", proof.top, proof.part, proof.spoilt.0);
        println!("    {}: {}", proof.top, proof.says);
    }
    Ok(Outcome::Passed)
}

impl Proof {
    /// Whether the property holds; an error where neither a proof nor a way to break it was found.
    fn holds(&self, folder: &Path, work: &Path) -> Result<bool> {
        let (log, problem) = (work.join("yosys.log"), work.join("problem.aig"));
        // `SYNTHESIS` leaves out the assertions of simulation, which yosys cannot read.
        let read = format!(
            "read_verilog -sv -formal -D SYNTHESIS -D PROVE_{} -I. {}; hierarchy -check -top {}; proc",
            self.part,
            self.files(folder)?.join(" "),
            self.top
        );
        // The slave's flip-flops have SCK for their clock: an edge is two steps that differ.
        let clocked = if matches!(self.sources, Sources::Files(files) if files.contains(&"rtl/spi_slave.sv")) {
            "clk2fflogic spi_slave; "
        } else {
            ""
        };
        let prepared = format!("{read}; {clocked}prep -top {} -flatten; async2sync; chformal -early", self.top);
        match self.engine {
            Engine::Induction => {
                let prove = "opt; sat -tempinduct -prove-asserts -set-assumes -set-at 1 rst_n 0 -set-at 1 started 0 \
                             -maxsteps 5";
                let said = yosys(folder, &format!("{prepared}; {prove}"), &log)?;
                ensure!(said.contains("Import proof for assert"), "nothing is asserted: see {}", log.display());
                // Five steps do not reach what breaks it: no proof is all that can be asked of a spoilt one.
                verdict(&said, "Induction step proven: SUCCESS", "Reached maximum number of time steps", &log)
            }
            Engine::Reachability => {
                let write = "dffunmap; opt -full; setundef -undriven -anyseq; setattr -unset keep; delete -output; \
                             opt -full; techmap; opt -fast; dffunmap; abc -g AND -fast; opt_clean; \
                             write_aiger -I -B -zinit";
                yosys(folder, &format!("{prepared}; {write} {}", problem.display()), &log)?;
                let log = work.join("abc.log");
                let prove = format!("read_aiger {}; fold; strash; scorr; pdr", problem.display());
                let said = logged(Command::new("yosys-abc").args(["-c", &prove]), &log)?;
                ensure!(!said.contains("has no outputs"), "nothing is asserted: see {}", log.display());
                verdict(&said, "Property proved", "was asserted in frame", &log)
            }
        }
    }

    /// The files that are read, from the block's folder.
    fn files(&self, folder: &Path) -> Result<Vec<String>> {
        match self.sources {
            Sources::Files(files) => Ok(files.iter().map(|file| (*file).to_owned()).collect()),
            Sources::Block => {
                let names = |sub: &str| -> Result<Vec<String>> {
                    let entries = fs::read_dir(folder.join(sub))?.collect::<Result<Vec<_>, _>>()?;
                    let names = entries.iter().map(|entry| entry.file_name().to_string_lossy().into_owned());
                    let mut names: Vec<String> = names.filter(|name| name.ends_with(".sv")).collect();
                    names.sort();
                    Ok(names)
                };
                let abstracted = names("formal/abstract")?;
                let real = names("rtl")?.into_iter().filter(|name| !abstracted.contains(name));
                let real: Vec<String> = real.map(|name| format!("rtl/{name}")).collect();
                Ok(real.into_iter().chain(abstracted.iter().map(|name| format!("formal/abstract/{name}"))).collect())
            }
        }
    }

    /// A copy of the sources with the one piece replaced; its folder.
    fn spoil(&self, workspace: &Workspace, copy: &Path) -> Result<PathBuf> {
        let (spoilt, piece, instead) = self.spoilt;
        let mut replaced = 0;
        for part in ["rtl", "formal"] {
            for file in workspace.files(Path::new(BLOCK).join(part))? {
                let name = file.strip_prefix(BLOCK)?;
                let mut text = workspace.read(&file)?;
                if name == Path::new(spoilt) {
                    replaced = text.matches(piece).count();
                    text = text.replace(piece, instead);
                }
                let to = copy.join(name);
                fs::create_dir_all(to.parent().context("a file without a folder")?)?;
                fs::write(&to, text).with_context(|| to.display().to_string())?;
            }
        }
        ensure!(replaced == 1, "{spoilt} has `{piece}` {replaced} times, not once");
        Ok(copy.to_owned())
    }
}

/// What a prover said.
fn verdict(said: &str, proved: &str, broken: &str, log: &Path) -> Result<bool> {
    match (said.contains(proved), said.contains(broken)) {
        (true, false) => Ok(true),
        (false, true) => Ok(false),
        _ => bail!("neither proved nor broken: see {}", log.display()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prover_that_gives_up_has_proved_nothing() {
        let judge = |said: &str| verdict(said, "Property proved", "was asserted in frame", Path::new("a.log"));
        assert!(judge("Property proved.  Time = 0.20 sec").unwrap());
        assert!(!judge("Output 4 of miter \"a\" was asserted in frame 227.").unwrap());
        assert!(judge("Reached timeout. Property UNDECIDED.").is_err());
    }
}
