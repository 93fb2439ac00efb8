//! A Rust that builds for another target than this machine: the board's, or a browser's.

use std::env;
use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

use anyhow::Result;

use crate::cargo;
use crate::provide;

/// The oldest Rust that builds us.
const LEAST: &str = env!("CARGO_PKG_RUST_VERSION");

/// A target and what builds for it.
pub struct Toolchain {
    target: &'static str,
    /// Which of its libraries are built: by the names that cargo has for them.
    libraries: &'static str,
    /// What Debian's Rust links with: it has its own std's source and builds from it. Without, it is the Rust that runs us,
    /// whose rustup has the target and what links for it.
    debians_linker: Option<&'static str>,
}

impl Toolchain {
    /// For the boards: without an operating system, and so without std.
    pub fn of_board() -> Result<Self> {
        Self::find("thumbv7em-none-eabihf", "core", ("/usr/bin/arm-none-eabi-ld", "binutils-arm-none-eabi"))
    }

    /// For a browser.
    pub fn of_browser() -> Result<Self> {
        Self::find("wasm32-unknown-unknown", "std,panic_abort", ("/usr/bin/wasm-ld", "lld"))
    }

    /// The ordinary one where the target is installed, else Debian's, which is installed if it may be, with the linker of the
    /// given file and package.
    fn find(target: &'static str, libraries: &'static str, linker: (&'static str, &str)) -> Result<Self> {
        let packages = ["rustc-web", "cargo-web", "rust-web-src", linker.1];
        let files = ["/usr/bin/rustc", "/usr/bin/cargo", "/usr/lib/rustlib/src/rust/library/core/Cargo.toml", linker.0];
        let installed = Command::new("rustup").args(["target", "list", "--installed"]).output();
        if installed.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).lines().any(|line| line == target)) {
            return Ok(Self { target, libraries, debians_linker: None });
        }
        if !files.iter().all(|path| Path::new(path).is_file()) || is_older(&version_of(files[0]), LEAST) {
            println!("    `rustup target add {target}` would do; without it {libraries} is built from Debian's source");
            provide::install("a Rust with its own source, to build it for other targets", &packages)?;
        }
        Ok(Self { target, libraries, debians_linker: Some(linker.0) })
    }

    /// Runs a cargo command in a folder, for the target; what is built goes to a folder of its own, for another compiler
    /// may have built what is in the ordinary one.
    pub fn run(&self, folder: &Path, built: &Path, arguments: &[&str]) -> Result<()> {
        println!("    cargo {} --target {}", arguments.join(" "), self.target);
        let mut command = self.debians_linker.map_or_else(cargo::program, |linker| self.debians_cargo(linker));
        command.current_dir(folder).env("CARGO_TARGET_DIR", built);
        provide::succeed(command.args(arguments).args(["--target", self.target]))
    }

    /// Debian's cargo with its rustc, as `rustc-web` and `rust-web-src` install them.
    fn debians_cargo(&self, linker: &str) -> Command {
        let mut command = Command::new("/usr/bin/cargo");
        let mut path = OsString::from("/usr/bin:");
        path.push(env::var_os("PATH").unwrap_or_default());
        let target = self.target.replace('-', "_").to_uppercase();
        command
            .env("PATH", path)
            .env("RUSTC_BOOTSTRAP", "1")
            .env("CARGO_UNSTABLE_BUILD_STD", self.libraries)
            .env(format!("CARGO_TARGET_{target}_LINKER"), linker);
        for variable in ["CARGO", "RUSTC", "RUSTUP_TOOLCHAIN", "RUSTFLAGS"] {
            command.env_remove(variable);
        }
        command
    }
}

/// What a compiler says of itself, `rustc 1.96.0 (...)`; nothing where it does not run.
fn version_of(compiler: &str) -> String {
    let output = Command::new(compiler).arg("--version").output();
    output.map_or_else(|_| String::new(), |output| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Whether a compiler that says so of itself is older than a version, by its first two numbers.
fn is_older(says: &str, least: &str) -> bool {
    let numbers =
        |version: &str| -> Vec<u32> { version.split('.').take(2).map_while(|part| part.parse().ok()).collect() };
    says.split_whitespace().nth(1).is_none_or(|own| numbers(own) < numbers(least))
}

#[cfg(test)]
mod tests {
    use super::is_older;

    #[test]
    fn a_compiler_that_is_too_old_or_says_nothing_is_not_taken() {
        let says = |version: &str| format!("rustc {version} (30a34c682 2026-05-25) (built from a source tarball)");
        for (version, older) in
            [("1.85.0", true), ("1.94.1", true), ("1.95.0", false), ("1.96.0", false), ("2.0.0", false)]
        {
            assert_eq!(is_older(&says(version), "1.95"), older, "{version}");
        }
        assert!(is_older("", "1.95"));
    }
}
