//! Verilates ../rtl at two scales of time, compiles the C++ and links it. Wants Verilator (5.006 will do), g++ and ar.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The two models: name, clocks a microsecond, half period of the A/D's SCK and its conversion in clocks.
///
/// `board` has the parameters' own values. In `fast` a microsecond of SCAN_PERIOD is three clocks, an eighth: 300 clocks
/// are the shortest period, and a scan takes 222 of them. SPI is not scaled: it meets the same 24 MHz.
const MODELS: [(&str, u32, u32, u32); 2] = [("board", 24, 2, 84), ("fast", 3, 1, 4)];

fn main() {
    let here = PathBuf::from(variable("CARGO_MANIFEST_DIR"));
    let out = PathBuf::from(variable("OUT_DIR"));
    let rtl = here.join("../rtl");
    let ours = here.join("cpp");
    println!("cargo::rerun-if-changed={}", rtl.display());
    println!("cargo::rerun-if-changed={}", ours.display());

    let runtime = verilator_root().join("include");
    let compile = |source: &Path, object: &Path, extra: &[OsString]| {
        let mut gpp = Command::new("g++");
        // Verilator's own code is compiled as it is: its warnings are none of ours.
        gpp.args(["-std=c++17", "-O2", "-fPIC", "-w", "-DVL_USER_STOP", "-c"]);
        gpp.arg("-I").arg(&runtime).arg("-I").arg(runtime.join("vltstd")).args(extra);
        run(gpp.arg("-o").arg(object).arg(source));
        object.to_owned()
    };

    let mut objects = vec![compile(&ours.join("stop.cpp"), &out.join("stop.o"), &[])];
    for name in ["verilated", "verilated_threads"] {
        let source = runtime.join(name).with_extension("cpp");
        objects.push(compile(&source, &out.join(name).with_extension("o"), &[]));
    }
    for (name, clocks_per_us, half_clocks, convert_clocks) in MODELS {
        let folder = out.join(name);
        let _ = fs::remove_dir_all(&folder);
        let mut verilator = Command::new("verilator");
        verilator.args(["--cc", "-Wall", "--assert", "-O3", "--x-initial", "unique", "--top-module", "acquisition"]);
        verilator.arg(format!("-GCLOCKS_PER_US={clocks_per_us}"));
        verilator.arg(format!("-GADC_HALF_CLOCKS={half_clocks}"));
        verilator.arg(format!("-GADC_CONVERT_CLOCKS={convert_clocks}"));
        verilator.arg("--prefix").arg(format!("V{name}")).arg("--Mdir").arg(&folder);
        run(verilator.arg("-I".to_owned() + &rtl.to_string_lossy()).arg(rtl.join("acquisition.sv")));

        let include: [OsString; 2] = ["-I".into(), folder.clone().into()];
        for source in sources(&folder) {
            objects.push(compile(&source, &source.with_extension("o"), &include));
        }
        let named =
            [include.to_vec(), vec![format!("-DNAME={name}").into(), format!("-DMODEL=V{name}").into()]].concat();
        let header: OsString = format!("-DHEADER=\"V{name}.h\"").into();
        objects.push(compile(&ours.join("model.cpp"), &folder.join("shim.o"), &[named, vec![header]].concat()));
    }

    let library = out.join("libgateware.a");
    let _ = fs::remove_file(&library);
    run(Command::new("ar").arg("crs").arg(&library).args(&objects));
    println!("cargo::rustc-link-search=native={}", out.display());
    println!("cargo::rustc-link-lib=static=gateware");
    println!("cargo::rustc-link-lib=stdc++");
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut paths: Vec<PathBuf> = paths.filter(|path| path.extension().is_some_and(|end| end == "cpp")).collect();
    paths.sort();
    paths
}

fn verilator_root() -> PathBuf {
    let asked = Command::new("verilator").args(["--getenv", "VERILATOR_ROOT"]).output();
    let asked = asked.unwrap_or_else(|error| panic!("verilator could not be started ({error}): {MISSING}"));
    PathBuf::from(String::from_utf8_lossy(&asked.stdout).trim())
}

const MISSING: &str = "on Debian it is in the packages verilator and g++, which `cargo xtask gateware` installs";

fn run(command: &mut Command) {
    let program = command.get_program().to_string_lossy().into_owned();
    let status = command.status().unwrap_or_else(|error| panic!("{program} could not be started ({error}): {MISSING}"));
    assert!(status.success(), "{program} ended with {status}");
}

fn variable(name: &str) -> String {
    env::var(name).unwrap_or_else(|_| panic!("{name} is not set: this is a build script"))
}
