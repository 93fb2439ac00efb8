//! ngspice in batch mode: the bench of hardware/zero-adjust, run many times in one process with other values.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail, ensure};

use crate::provide;
use crate::workspace::Workspace;

/// Where the circuit is.
pub const CIRCUIT: &str = "hardware/zero-adjust";

/// What one run measured, by name.
pub type Measured = BTreeMap<String, f64>;

/// Values of devices, by their names in the netlist.
pub type Values = BTreeMap<String, f64>;

/// A bench with its circuit, ready to run.
pub struct Spice {
    /// ngspice's.
    program: PathBuf,
    /// Where decks and data are written: target/circuit.
    folder: PathBuf,
    /// Everything of bench.cir before its commands.
    netlist: String,
    /// bench.cir's commands.
    measure: String,
}

impl Spice {
    /// Finds ngspice, installing it where that is allowed, and reads the bench.
    pub fn new(workspace: &Workspace) -> Result<Self> {
        let found = || provide::on_path(&["ngspice"]);
        if found().is_none() {
            provide::install("ngspice", &["ngspice"])?;
        }
        let program = found().context("there is no ngspice on the PATH, though its package is installed")?;
        let bench = workspace.read(format!("{CIRCUIT}/bench.cir"))?;
        let (netlist, rest) = bench.split_once(".control\n").context("bench.cir has no .control")?;
        let (measure, _) = rest.split_once(".endc").context("bench.cir has no .endc")?;
        // The deck is run from target: it needs the whole path.
        let board = workspace.root.join(CIRCUIT).join("zero-adjust.cir");
        let include = ".include zero-adjust.cir\n";
        ensure!(netlist.contains(include), "bench.cir does not include zero-adjust.cir");
        let netlist = netlist.replace(include, &format!(".include \"{}\"\n", board.display()));
        let folder = workspace.target.join("circuit");
        fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        Ok(Self { program, folder, netlist, measure: measure.to_owned() })
    }

    /// The values that the netlist gives to devices.
    pub fn values(&self, devices: &[String]) -> Result<Values> {
        let ask = |device: &String| {
            let parameter = match device.rsplit('.').next().unwrap_or_default().chars().next() {
                Some('r') => "resistance",
                Some('c') => "capacitance",
                Some('v' | 'i') => "dc",
                _ => bail!("parts.csv: `{device}` is no resistor, capacitor or source"),
            };
            Ok(format!("print @{device}[{parameter}]\n"))
        };
        let questions: String = devices.iter().map(ask).collect::<Result<_>>()?;
        let answers = self.batch("values", &format!("set numdgt=12\n{questions}"))?;
        let value = |device: &String| {
            let answer = answers.iter().find(|(name, _)| name.strip_prefix('@').is_some_and(|n| is_of(n, device)));
            let (_, value) = answer.with_context(|| format!("parts.csv: the netlist has no `{device}`"))?;
            Ok((device.clone(), *value))
        };
        devices.iter().map(value).collect()
    }

    /// Measures once for each set of values that differ from the netlist's; `nominal` has the netlist's.
    pub fn measure(&self, nominal: &Values, runs: &[Values]) -> Result<Vec<Measured>> {
        let mut commands = String::new();
        for run in runs {
            run.iter().for_each(|(device, value)| commands.push_str(&format!("alter {device} = {value:e}\n")));
            commands.push_str(&self.measure);
            for device in run.keys() {
                let value = nominal.get(device).with_context(|| format!("no nominal value of {device}"))?;
                commands.push_str(&format!("alter {device} = {value:e}\n"));
            }
            commands.push_str("let run_done=1\nprint run_done\n");
        }
        let mut measured = Vec::new();
        let mut one = Measured::new();
        for (name, value) in self.batch("measure", &commands)? {
            if name == "run_done" {
                measured.push(std::mem::take(&mut one));
            } else {
                one.insert(name, value);
            }
        }
        ensure!(measured.len() == runs.len(), "ngspice finished {} of {} runs", measured.len(), runs.len());
        Ok(measured)
    }

    /// Sweeps a source, and gives for each point the source's value and the voltages of the nodes.
    pub fn sweep(&self, source: &str, [from, to, step]: [f64; 3], nodes: &[&str]) -> Result<Vec<Vec<f64>>> {
        let data = self.folder.join(format!("{source}.data"));
        let vectors: Vec<String> = nodes.iter().map(|node| format!("v({node})")).collect();
        self.batch(
            source,
            &format!(
                "set wr_singlescale\ndc {source} {from} {to} {step}\nwrdata {source}.data {}\n",
                vectors.join(" ")
            ),
        )?;
        let text = fs::read_to_string(&data).with_context(|| data.display().to_string())?;
        let row = |line: &str| line.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>();
        let rows: Vec<Vec<f64>> = text.lines().map(row).collect::<Result<_, _>>()?;
        ensure!(rows.iter().all(|row| row.len() == nodes.len() + 1), "{}: a column is missing", data.display());
        Ok(rows)
    }

    /// The noise at a node, rms, up to where nothing passes any more.
    pub fn noise_v(&self, node: &str) -> Result<f64> {
        let commands = format!("noise v({node}) vrate dec 20 0.01 100meg\nsetplot noise2\nprint onoise_total\n");
        let answers = self.batch("noise", &commands)?;
        let total = answers.iter().find(|(name, _)| name == "onoise_total");
        Ok(total.with_context(|| format!("ngspice has no noise of {node}"))?.1)
    }

    /// What the nodes are when a device of the bench is not there.
    pub fn without(&self, device: &str, nodes: &[&str]) -> Result<Vec<f64>> {
        let is_kept = |line: &&str| line.split_whitespace().next() != Some(device);
        let netlist: Vec<&str> = self.netlist.lines().filter(is_kept).collect();
        ensure!(netlist.len() + 1 == self.netlist.lines().count(), "bench.cir has no `{device}`");
        let prints: String = nodes.iter().map(|node| format!("let n_{node}=v({node})\nprint n_{node}\n")).collect();
        let answers = self.run(&format!("without-{device}"), &netlist.join("\n"), &format!("op\n{prints}"))?;
        ensure!(answers.len() == nodes.len(), "ngspice without {device}: {answers:?}");
        Ok(answers.into_iter().map(|(_, value)| value).collect())
    }

    /// Runs commands on the bench; what they print as `name = value`, in order.
    fn batch(&self, name: &str, commands: &str) -> Result<Vec<(String, f64)>> {
        self.run(name, &self.netlist, commands)
    }

    fn run(&self, name: &str, netlist: &str, commands: &str) -> Result<Vec<(String, f64)>> {
        let deck = self.folder.join(format!("{name}.cir"));
        let text = format!("{}\n.control\n{commands}.endc\n.end\n", netlist.trim_end());
        fs::write(&deck, text).with_context(|| deck.display().to_string())?;
        let mut ngspice = Command::new(&self.program);
        ngspice.current_dir(&self.folder).arg("-b").arg(&deck).stdin(Stdio::null());
        let output = ngspice.output().context("ngspice could not be started")?;
        let (said, complained) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        // It ends with 0 or 1 by other rules than success; an analysis that fails says so.
        let faults = ["error", "failed", "aborted", "singular", "no such"];
        let is_fault = |line: &&str| faults.iter().any(|fault| line.to_lowercase().contains(fault));
        if let Some(fault) = said.lines().chain(complained.lines()).find(is_fault) {
            bail!("ngspice on {}: {}", deck.display(), fault.trim());
        }
        Ok(said.lines().filter_map(assignment).collect())
    }
}

fn is_of(vector: &str, device: &str) -> bool {
    vector.strip_prefix(device).is_some_and(|rest| rest.starts_with('['))
}

/// `name = value`; other lines with an equals sign have a space in the name or no number.
fn assignment(line: &str) -> Option<(String, f64)> {
    let (name, value) = line.split_once('=')?;
    let name = name.trim();
    let value = value.trim().parse().ok()?;
    (!name.is_empty() && !name.contains(' ')).then(|| (name.to_owned(), value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ngspice_prints_is_read_and_its_other_lines_are_not() {
        assert_eq!(assignment("x_centre = 8.2001413162e+03"), Some(("x_centre".into(), 8200.1413162)));
        assert_eq!(assignment("x_cutoff_hz         =  4.007826e+01"), Some(("x_cutoff_hz".into(), 40.07826)));
        assert_eq!(assignment("Doing analysis at TEMP = 27.000000 and TNOM = 27.000000"), None);
        assert_eq!(assignment("No. of Data Rows : 3"), None);
    }

    #[test]
    fn a_device_is_not_taken_for_one_whose_name_begins_alike() {
        assert!(is_of("r.xx.r1[resistance]", "r.xx.r1"));
        assert!(!is_of("r.xx.r10[resistance]", "r.xx.r1"));
    }
}
